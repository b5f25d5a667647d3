"""Whether a body may be in a state, and turn there: collisions, clearance of the belly, the legs.

Kernels take a `StateSpace`; a state `(6,)` is position and velocity of the body's centre, m and
m/s; a yaw is given by its cosine and sine, or in rad.
"""

from __future__ import annotations

import math

from cavalcade.geometry.boxes import Footprint
from cavalcade.geometry.trajectory import FLIGHT, TAKE_OFF, WALK
from cavalcade.kernels import kernel, subroutine
from cavalcade.kinodynamic.parameters import GROUND, LEAST_TRAVERSABILITY, MOTION, OK, SOLID
from cavalcade.lattice.collision import Grid, pose_free
from cavalcade.lattice.surface import blend, corner, surface

STILL = 1e-6
"""Below this speed a body stands, m/s."""

HALF_DIAGONAL = 0.7072
"""From a cell's centre to its corners, in cells, rounded up."""

_TURN_STEP = 0.1
"""Between the yaws of a turn that are checked, rad."""


@subroutine
def stands_still(state):
    """Whether a body in this state rests and may turn on the spot."""
    return state[3] * state[3] + state[4] * state[4] <= STILL * STILL


@kernel
def rest_at(space, x, y, out):
    """Write the state of rest at a place, at nominal height."""
    out[0], out[1] = x, y
    out[2] = surface(space.ground, x, y)[0] + space.body.h_nom
    out[3], out[4], out[5] = 0.0, 0.0, 0.0


@subroutine
def _slack_to_discs(discs, x, y, slack):
    """How far the centre may go before it is in a disc, m, at most `slack`."""
    for k in range(discs.shape[0]):
        dx, dy = x - discs[k, 0], y - discs[k, 1]
        slack = min(slack, math.sqrt(dx * dx + dy * dy) - discs[k, 2])
    return slack


@subroutine
def solid_slack(space, x, y):
    """How far the body may go from here in any direction, turning, and meet nothing solid, m.

    Not positive where that is not known without its yaw.
    """
    ground, body, discs = space
    cell = ground.cell
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * cell and 0.0 <= y < rows * cell):
        return -1.0
    reach = math.sqrt(body.half_length * body.half_length + body.half_width * body.half_width)
    slack = ground.clearance[int(y / cell), int(x / cell)] - HALF_DIAGONAL * cell
    slack -= reach + body.margin
    return _slack_to_discs(discs, x, y, slack)


@subroutine
def covered_slack(space, x, y, cos, sin):
    """How far every point of the footprint may go in any direction and meet nothing solid, m.

    From five discs that cover it; not positive where they do not tell.
    """
    ground, body, discs = space
    cell = ground.cell
    rows, cols = ground.solid.shape
    part = 0.2 * body.half_length
    needed = math.sqrt(part * part + body.half_width * body.half_width)
    needed += HALF_DIAGONAL * cell + body.margin
    slack = math.inf
    for k in range(5):
        along = 2.0 * part * (k - 2)
        px, py = x + along * cos, y + along * sin
        if not (0.0 <= px < cols * cell and 0.0 <= py < rows * cell):
            return -1.0
        slack = min(slack, ground.clearance[int(py / cell), int(px / cell)] - needed)
        if slack <= 0.0:
            return slack
    return _slack_to_discs(discs, x, y, slack)


@kernel
def solid_free(space, x, y, cos, sin):
    """Whether the footprint is on the map, free of solids, and its centre outside all discs."""
    ground, body, discs = space
    for k in range(discs.shape[0]):
        dx, dy = x - discs[k, 0], y - discs[k, 1]
        if dx * dx + dy * dy < discs[k, 2] * discs[k, 2]:
            return False
    cell = ground.cell
    rows, cols = ground.solid.shape
    if not (0.0 <= x < cols * cell and 0.0 <= y < rows * cell):
        return False
    # What the clearance around the centre tells: room for any yaw, or for none.
    there = ground.clearance[int(y / cell), int(x / cell)]
    beside = HALF_DIAGONAL * cell
    if there - beside - body.margin > body.half_length + body.half_width:
        return True
    if there + beside < body.half_width + body.margin:
        return False
    if covered_slack(space, x, y, cos, sin) > 0.0:
        return True
    return pose_free(
        Grid(cell, ground.solid, ground.clearance, ground.outlines),
        Footprint(body.half_length, body.half_width, False),
        x,
        y,
        math.atan2(sin, cos),
        body.margin,
    )


@kernel
def carried(space, x, y, z, cos, sin, phase):
    """Whether belly and legs get along with the ground.

    The body is pitched as the smoothed ground along its heading. The belly's corners and its
    centre keep `h_min` in all phases. Outside flight the ground below the centre is traversable,
    and hips are over traversable ground within the legs' reach: those of the rear legs during
    take-off, of all legs otherwise.
    """
    ground, body = space.ground, space.body
    if ground.flat:
        return z - body.belly >= body.h_min and (phase == FLIGHT or z <= body.h_max)
    height, traversability = ground.height, ground.traversability
    rows, cols = height.shape
    scale = 1.0 / ground.cell
    # The ground below the centre, and the pitch along the heading.
    i, j, fu, fv = corner(rows, cols, scale, x, y)
    if phase != FLIGHT and blend(traversability, i, j, fu, fv) < LEAST_TRAVERSABILITY:
        return False
    slope = cos * blend(ground.slope_x, i, j, fu, fv) + sin * blend(ground.slope_y, i, j, fu, fv)
    cp = 1.0 / math.sqrt(1.0 + slope * slope)
    sp = slope * cp
    # The belly's centre and corners.
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
    # The ground below each hip, rear ones first.
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


@subroutine
def state_problem(space, state, cos, sin, phase):
    """What is wrong with a state in a phase: `OK`, `SOLID`, `GROUND` or `MOTION`."""
    x, y, vx, vy = state[0], state[1], state[3], state[4]
    if vx * vx + vy * vy > space.body.v_max * space.body.v_max * (1.0 + 1e-9):
        return MOTION
    if not solid_free(space, x, y, cos, sin):
        return SOLID
    if not carried(space, x, y, state[2], cos, sin, phase):
        return GROUND
    return OK


@subroutine
def wrapped(angle):
    """The same angle in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


@subroutine
def turn_on_spot(space, state, yaw, wanted):
    """Angle to turn by from one yaw to another, the short way if there is room; nan without room.

    The states at both ends are taken to be valid.
    """
    short = wrapped(wanted - yaw)
    if abs(short) < 1e-9:
        return 0.0
    if space.ground.flat and solid_slack(space, state[0], state[1]) > 0.0:
        return short
    if _may_sweep(space, state, yaw, short):
        return short
    other = short - math.copysign(2.0 * math.pi, short)
    if _may_sweep(space, state, yaw, other):
        return other
    return math.nan


@subroutine
def _may_sweep(space, state, yaw, turn):
    """Whether all yaws between the ends of a turn are valid."""
    x, y, z = state[0], state[1], state[2]
    count = int(math.ceil(abs(turn) / _TURN_STEP))
    for k in range(1, count):
        cos, sin = math.cos(yaw + turn * k / count), math.sin(yaw + turn * k / count)
        if not solid_free(space, x, y, cos, sin):
            return False
        if not space.ground.flat and not carried(space, x, y, z, cos, sin, WALK):
            return False
    return True


@subroutine
def may_turn(space, state, yaw, wanted):
    """Whether a body at rest can turn on the spot from one yaw to another; a moving one may."""
    return not stands_still(state) or not math.isnan(turn_on_spot(space, state, yaw, wanted))
