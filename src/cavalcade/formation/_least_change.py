"""The safety filter's first stage: the least change that respects clearances. Compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.formation._clearance import (
    DistanceMap,
    Footprint,
    ObstacleBoxes,
    contact_centres,
    distance_at,
    rectangle,
    rectangle_gap,
)
from cavalcade.kernels import kernel, subroutine
from cavalcade.robots.motion import MotionLimits, ellipse_scale

ARM = 0.25
"""m; weighs turning against moving: u = (vx, vy, ARM * yaw rate)."""
NEAR_GAP = 0.3
"""m: nearer than this, the lever arms of a pair are taken at the centre of its contact."""
SLOP = 0.03
"""m of distance that still counts as part of that contact."""
NEAR = 1.3
"""m between the circles around two robots beyond which they are not compared."""
SWEEPS = 100


class TeamState(NamedTuple):
    """A team's state and what is wanted of it, in the grid's frame.

    Attributes:
        poses: `(N, 3)` m, m, rad.
        velocities: `(N, 3)` present velocities: m/s, m/s, rad/s.
        wanted: `(N, 3)` wanted velocities: m/s, m/s, rad/s.
        rank: `(N,)` precedence, 0 first: later robots give way.
        frozen: `(N,)` robots that are not commanded.
        evading: `(N,)` robots that get out of the way of a dynamic obstacle: stopping there is
            what hits them, so they keep clear of it by going on.
        clearances: `(N,)` what centres keep off obstacles, m; 0 for nothing.
    """

    poses: np.ndarray
    velocities: np.ndarray
    wanted: np.ndarray
    rank: np.ndarray
    frozen: np.ndarray
    evading: np.ndarray
    clearances: np.ndarray


class Margins(NamedTuple):
    """Gaps in m: footprint to obstacles, footprint to footprint, centre to centre.

    The last counts between robots that are both commanded.
    """

    obstacle: float
    footprint: float
    centres: float


class Horizon(NamedTuple):
    """How robots move, and how far ahead that is predicted.

    Attributes:
        limits: The robots' motion limits.
        braking: Deceleration that closing speeds are bounded by, m/s².
        period: s for which a command is held.
        substeps: Steps into which the period is divided.
        steps: Number of steps that are predicted, a full stop included.
    """

    limits: MotionLimits
    braking: float
    period: float
    substeps: int
    steps: int


class FilterParameters(NamedTuple):
    """What stays the same from cycle to cycle.

    Attributes:
        footprint: The robots'.
        aimed, insisted: Gaps that the first stage aims at and the second insists on.
        horizon: Of braking and prediction.
    """

    footprint: Footprint
    aimed: Margins
    insisted: Margins
    horizon: Horizon


class Constraints(NamedTuple):
    """Linear constraints `rows @ u >= bounds` on the velocities u of one or two robots each.

    Attributes:
        rows: `(R, 6)` coefficients for the first and the second owner.
        bounds: `(R,)` m/s.
        owners: `(R, 2)` robots, -1 for none.
        used: `(1,)` number of rows in use.
    """

    rows: np.ndarray
    bounds: np.ndarray
    owners: np.ndarray
    used: np.ndarray


@subroutine
def approach_speed(gap, deceleration, period):
    """Largest closing speed in m/s from which one stops within `gap` m, a period late."""
    if gap <= 0.0:
        return max(2.0 * gap, -0.15)  # too near already: open up gently
    lag = deceleration * period
    return math.sqrt(2.0 * deceleration * gap + lag * lag) - lag


@subroutine
def new_row(constraints, first, second, bound):
    """The next row, all zero yet, of a constraint between two robots (-1 for none)."""
    k = constraints.used[0]
    constraints.used[0] = k + 1
    constraints.bounds[k] = bound
    constraints.owners[k, 0], constraints.owners[k, 1] = first, second
    return constraints.rows[k]


@subroutine
def set_contact(row, at, nx, ny, rx, ry):
    """Enter how fast a point (rx, ry) from a robot's centre moves along a normal."""
    row[at], row[at + 1] = nx, ny
    row[at + 2] = (-nx * ry + ny * rx) / ARM


@subroutine
def obstacle_rows(k, pose, keep, footprint, map, gap, horizon, constraints):
    """Constraints of robot `k` against the map: its discs and its centre's clearance."""
    discs = footprint.discs
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(discs.shape[0] + 1):
        rx, ry = 0.0, 0.0
        if i == discs.shape[0]:  # the centre; it keeps a little more than is insisted on
            needed = keep + 0.01 if keep > 0.0 else 0.0
        else:
            needed = footprint.radius + gap
            rx, ry = c * discs[i, 0] - s * discs[i, 1], s * discs[i, 0] + c * discs[i, 1]
        if needed <= 0.0:
            continue
        d, gx, gy = distance_at(map, pose[0] + rx, pose[1] + ry)
        if d - needed > 0.5:
            continue
        norm = math.hypot(gx, gy)
        if norm < 0.4:
            continue  # a ridge: no single direction leads away
        speed = approach_speed(d - needed, horizon.braking, horizon.period)
        set_contact(new_row(constraints, k, -1, -speed), 0, gx / norm, gy / norm, rx, ry)


@subroutine
def pair_rows(i, j, poses, both, half, margins, horizon, constraints):
    """Constraints between two robots: the gap of their footprints, the distance of centres.

    The latter only if `both` are commanded: one that does not drive is an obstacle.
    """
    one, other = poses[i], poses[j]
    dx, dy = one[0] - other[0], one[1] - other[1]
    away = math.hypot(dx, dy)
    around = math.hypot(half[0], half[1])
    if away > around + around + NEAR or away < 1e-9:
        return
    deceleration = 1.5 * horizon.braking  # for both of them brake
    a, b = rectangle(one, half), rectangle(other, half)
    gap = rectangle_gap(a, b)
    px, py, qx, qy = gap.ax, gap.ay, gap.bx, gap.by
    if gap.distance < NEAR_GAP:
        px, py, qx, qy = contact_centres(a, b, gap, SLOP)
    speed = approach_speed(gap.distance - margins.footprint, deceleration, horizon.period)
    row = new_row(constraints, i, j, -speed)
    set_contact(row, 0, gap.nx, gap.ny, px - one[0], py - one[1])
    set_contact(row, 3, -gap.nx, -gap.ny, qx - other[0], qy - other[1])
    if not both:
        return
    speed = approach_speed(away - margins.centres, deceleration, horizon.period)
    row = new_row(constraints, i, j, -speed)
    row[0], row[1], row[3], row[4] = dx / away, dy / away, -dx / away, -dy / away


@subroutine
def box_rows(i, pose, half, boxes, gap, horizon, constraints):
    """Constraints of robot `i` against dynamic obstacles, whose own motion counts as closing."""
    for j in range(boxes.poses.shape[0]):
        near = rectangle_gap(rectangle(pose, half), rectangle(boxes.poses[j], boxes.half[j]))
        if near.distance > 2.0:
            continue
        approach = near.nx * boxes.velocities[j, 0] + near.ny * boxes.velocities[j, 1]
        speed = approach_speed(near.distance - gap, horizon.braking, horizon.period)
        row = new_row(constraints, i, -1, approach - speed)
        set_contact(row, 0, near.nx, near.ny, near.ax - pose[0], near.ay - pose[1])


@subroutine
def project(wanted, weights, constraints):
    """Hildreth's method: the nearest `u` (weighted) that meets the constraints.

    Constraints are served the tightest first: an order that a mirrored problem shares.

    Args:
        wanted: `(N, 3)` wanted u.
        weights: `(N,)` how dear a change of each robot's u is.
        constraints: What u has to meet.
    """
    rows, bounds, owners = constraints.rows, constraints.bounds, constraints.owners
    count = constraints.used[0]
    u = wanted.copy()
    dual = np.zeros(count)
    # Insertion sort, the largest bound first; equal ones keep their order.
    order = np.empty(count, np.int64)
    for r in range(count):
        k = r
        while k > 0 and bounds[order[k - 1]] < bounds[r]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = r
    for _ in range(SWEEPS):
        change = 0.0
        for k in range(count):
            r = order[k]
            i, j = owners[r, 0], owners[r, 1]
            # How far the row is from its bound, and how far a unit of its multiplier moves it.
            value = -bounds[r]
            square = 1e-9
            for a in range(3):
                value += rows[r, a] * u[i, a]
                square += rows[r, a] * rows[r, a] / weights[i]
                if j >= 0:
                    value += rows[r, 3 + a] * u[j, a]
                    square += rows[r, 3 + a] * rows[r, 3 + a] / weights[j]
            step = max(dual[r] - value / square, 0.0) - dual[r]
            if step == 0.0:
                continue
            dual[r] += step
            change = max(change, abs(step))
            for a in range(3):
                u[i, a] += step * rows[r, a] / weights[i]
                if j >= 0:
                    u[j, a] += step * rows[r, 3 + a] / weights[j]
        if change < 1e-6:
            break
    return u


@subroutine
def least_change(team, weights, surroundings, parameters):
    """Wanted velocities, changed as little as clearances and braking distances ask for.

    Args:
        team: A `TeamState`.
        weights: `(N,)` how dear a change is; very large for a robot that cannot be commanded.
        surroundings: Map and dynamic obstacles.
        parameters: The `FilterParameters`.

    Returns:
        `(N, 3)` velocities in the map frame: m/s, m/s, rad/s.
    """
    poses, frozen, keep = team.poses, team.frozen, team.clearances
    footprint, margins, horizon = parameters.footprint, parameters.aimed, parameters.horizon
    half = footprint.half
    grid = DistanceMap(surroundings.distances, surroundings.cell)
    boxes = ObstacleBoxes(surroundings.poses, surroundings.half, surroundings.velocities)
    n, m = poses.shape[0], boxes.poses.shape[0]
    most = n * (footprint.discs.shape[0] + 1) + n * (n - 1) + n * m
    constraints = Constraints(
        np.zeros((most, 6)), np.zeros(most), np.empty((most, 2), np.int64), np.zeros(1, np.int64)
    )
    for k in range(n):
        if not frozen[k]:
            gap = margins.obstacle
            obstacle_rows(k, poses[k], keep[k], footprint, grid, gap, horizon, constraints)
    for i in range(n):
        for j in range(i + 1, n):
            both = not (frozen[i] or frozen[j])
            pair_rows(i, j, poses, both, half, margins, horizon, constraints)
    for k in range(n):
        if not frozen[k]:
            box_rows(k, poses[k], half, boxes, margins.footprint, horizon, constraints)
    u = team.wanted.copy()
    for i in range(n):
        u[i, 2] *= ARM
    u = project(u, weights, constraints)
    for i in range(n):
        u[i, 2] /= ARM
    return u


@kernel
def to_body(velocities, yaw, limits):
    """Map-frame velocities `(N, 3)` as body-frame commands inside the velocity ellipse."""
    out = np.empty_like(velocities)
    most = limits.max_yaw_rate
    for k in range(velocities.shape[0]):
        c, s = math.cos(yaw[k]), math.sin(yaw[k])
        vx = c * velocities[k, 0] + s * velocities[k, 1]
        vy = -s * velocities[k, 0] + c * velocities[k, 1]
        scale = ellipse_scale(vx, vy, limits.max_speed_x, limits.max_speed_y)
        out[k, 0], out[k, 1] = vx * scale, vy * scale
        out[k, 2] = min(max(velocities[k, 2], -most), most)
    return out
