"""Whether a body may be in a state: solid ground, clearance of the belly, reach of the legs."""

from __future__ import annotations

import math

from numba import njit

from cavalcade.geometry.trajectory import FLIGHT, TAKE_OFF
from cavalcade.kinodynamic.parameters import GROUND, MOTION, OK, SOLID
from cavalcade.lattice.collision import pose_free
from cavalcade.lattice.surface import blend, corner

LEAST_TRAVERSABILITY = 0.3
_HALF_DIAGONAL = 0.7072


@njit(cache=True)
def solid_slack(ground, body, discs, x, y):
    """How far the body may go from here in any direction, turning, and meet nothing solid, m.

    Not positive where that is not known without its yaw.
    """
    cell = ground.cell
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * cell and 0.0 <= y < rows * cell):
        return -1.0
    reach = math.sqrt(body.half_length * body.half_length + body.half_width * body.half_width)
    slack = ground.clearance[int(y / cell), int(x / cell)] - _HALF_DIAGONAL * cell
    slack -= reach + body.margin
    for k in range(discs.shape[0]):
        dx, dy = x - discs[k, 0], y - discs[k, 1]
        slack = min(slack, math.sqrt(dx * dx + dy * dy) - discs[k, 2])
    return slack


@njit(cache=True)
def covered_slack(ground, body, discs, x, y, cos, sin):
    """How far every point of the footprint may go in any direction and meet nothing solid, m.

    From five discs that cover it; not positive where they do not tell.
    """
    cell = ground.cell
    rows, cols = ground.solid.shape
    part = 0.2 * body.half_length
    needed = math.sqrt(part * part + body.half_width * body.half_width)
    needed += _HALF_DIAGONAL * cell + body.margin
    slack = math.inf
    for k in range(5):
        way = 2.0 * part * (k - 2)
        px, py = x + way * cos, y + way * sin
        if not (0.0 <= px < cols * cell and 0.0 <= py < rows * cell):
            return -1.0
        slack = min(slack, ground.clearance[int(py / cell), int(px / cell)] - needed)
        if slack <= 0.0:
            return slack
    for k in range(discs.shape[0]):
        dx, dy = x - discs[k, 0], y - discs[k, 1]
        slack = min(slack, math.sqrt(dx * dx + dy * dy) - discs[k, 2])
    return slack


@njit(cache=True)
def solid_free(ground, body, discs, x, y, cos, sin):
    """Whether the footprint is on the map, free of solids, and its centre outside all discs."""
    for k in range(discs.shape[0]):
        dx, dy = x - discs[k, 0], y - discs[k, 1]
        if dx * dx + dy * dy < discs[k, 2] * discs[k, 2]:
            return False
    cell = ground.cell
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * cell and 0.0 <= y < rows * cell):
        return False
    there = ground.clearance[int(y / cell), int(x / cell)]
    beside = _HALF_DIAGONAL * cell
    if there - beside - body.margin > body.half_length + body.half_width:
        return True
    if there + beside < body.half_width + body.margin:
        return False
    if covered_slack(ground, body, discs, x, y, cos, sin) > 0.0:
        return True
    return pose_free(
        (cell, ground.solid, ground.clearance),
        x,
        y,
        math.atan2(sin, cos),
        body.half_length,
        body.half_width,
        0.0,
        body.margin,
    )


@njit(cache=True)
def carried(ground, body, x, y, z, cos, sin, phase):
    """Whether belly and legs get along with the ground.

    The body is pitched as the smoothed ground along its heading. The belly's corners and its
    centre keep `h_min` in all phases. Outside flight the ground below the centre is traversable,
    and hips are over traversable ground within the legs' reach: those of the rear legs during
    take-off, of all legs otherwise.
    """
    if ground.flat:
        return z - body.belly >= body.h_min and (phase == FLIGHT or z <= body.h_max)
    height, traversability = ground.height, ground.traversability
    rows, cols = height.shape
    scale = 1.0 / ground.cell
    i, j, fu, fv = corner(rows, cols, scale, x, y)
    if phase != FLIGHT and blend(traversability, i, j, fu, fv) < LEAST_TRAVERSABILITY:
        return False
    slope = cos * blend(ground.slope_x, i, j, fu, fv) + sin * blend(ground.slope_y, i, j, fu, fv)
    cp = 1.0 / math.sqrt(1.0 + slope * slope)
    sp = slope * cp
    lowest = z - body.belly - body.h_min
    if lowest < blend(height, i, j, fu, fv):
        return False
    along, across = body.trunk_half_length * cp, body.trunk_half_width
    rise = body.trunk_half_length * sp
    for k in range(4):
        e = 1.0 if k < 2 else -1.0
        f = 1.0 if k % 2 == 0 else -1.0
        px = x + e * along * cos - f * across * sin
        py = y + e * along * sin + f * across * cos
        i, j, fu, fv = corner(rows, cols, scale, px, py)
        if lowest + e * rise < blend(height, i, j, fu, fv):
            return False
    if phase == FLIGHT:
        return True
    along, across, rise = body.hip_x * cp, body.hip_y, body.hip_x * sp
    for k in range(4):
        e = -1.0 if k < 2 else 1.0
        if phase == TAKE_OFF and e > 0.0:
            break
        f = 1.0 if k % 2 == 0 else -1.0
        px = x + e * along * cos - f * across * sin
        py = y + e * along * sin + f * across * cos
        i, j, fu, fv = corner(rows, cols, scale, px, py)
        if blend(traversability, i, j, fu, fv) < LEAST_TRAVERSABILITY:
            return False
        if z + e * rise - blend(height, i, j, fu, fv) > body.h_max:
            return False
    return True


@njit(cache=True)
def state_problem(ground, body, discs, x, y, z, vx, vy, cos, sin, phase):
    """What is wrong with a state: `OK`, `SOLID`, `GROUND` or `MOTION`.

    Args:
        ground: A `Ground`.
        body: A `Body`.
        discs: `(K, 3)` x, y, radius where the centre may not be.
        x, y, z: Of the body's centre, m.
        vx, vy: m/s.
        cos, sin: Of the yaw.
        phase: `WALK`, `TAKE_OFF`, `FLIGHT` or `LANDING`.
    """
    if vx * vx + vy * vy > body.v_max * body.v_max * (1.0 + 1e-9):
        return MOTION
    if not solid_free(ground, body, discs, x, y, cos, sin):
        return SOLID
    if not carried(ground, body, x, y, z, cos, sin, phase):
        return GROUND
    return OK
