"""How each kind of robot moves in the plane: its limits, and the moves that a search tries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import Footprint
from cavalcade.kernels import subroutine
from cavalcade.lattice.primitives import DURATION, make_move
from cavalcade.robots import RobotModel

_GENTLE = (2.0, 4.0)
"""m/s² and rad/s² where a robot has no limits of its own, so that its speed does not jump."""

_BACKWARDS = (0.6, 0.3)
"""m at a stretch, and m/s: robots with legs step back only to get out of or into tight places."""

FROM_MOVING, TO_MOVING = 6, 7
"""Columns of a table of primitives, after those of a move: whether it begins and ends moving."""


class MotionLimits(NamedTuple):
    """What kernels of moves know of a robot.

    Attributes:
        speed: Forwards, m/s.
        acceleration: Along the path, m/s².
        yaw_rate: rad/s.
        yaw_acceleration: rad/s².
        radius: Least radius of arcs, m; 0: it drives none.
        backwards: How far it may go backwards at a stretch, m.
        backward_speed: m/s.
        free: Whether its heading is free: it turns in no time.
        half_length, half_width: Of the footprint, m; of a disc both are its radius.
        round: Whether the footprint is a disc.
    """

    speed: float
    acceleration: float
    yaw_rate: float
    yaw_acceleration: float
    radius: float
    backwards: float
    backward_speed: float
    free: bool
    half_length: float
    half_width: float
    round: bool


_FLAGS = ("free", "round")
_LIMITS = np.dtype(
    [(name, np.bool_ if name in _FLAGS else np.float64) for name in MotionLimits._fields],
    align=True,
)


def motion_limits(model: RobotModel) -> MotionLimits:
    """The limits that a robot is planned with."""
    acceleration = min(model.max_acceleration, _GENTLE[0])
    turning = min(model.max_yaw_acceleration, _GENTLE[1])
    speed, rate, radius = model.max_speed_x, model.max_yaw_rate, 0.0
    back, back_speed = 0.0, speed
    if model.drive == "legged" and model.legs is not None:
        legs = model.legs
        speed, rate = legs.v_nom, legs.yaw_rate
        acceleration, turning = legs.acceleration, _GENTLE[1]
        radius = speed / rate
        back, back_speed = _BACKWARDS
    elif model.drive == "unicycle":
        radius, back = speed / rate, math.inf
    elif model.drive == "unicycle-2":
        back = math.inf
    return MotionLimits(
        float(speed),
        float(acceleration),
        float(rate),
        float(turning),
        float(radius),
        float(back),
        float(back_speed),
        model.drive in ("integrator", "integrator-2"),
        *footprint(model),
    )


def metre_cost(speed: float) -> float:
    """What a metre costs a robot of this speed (m/s) where a second costs 1: twice its time."""
    return 2.0 / speed


def footprint(model: RobotModel) -> Footprint:
    """What a robot covers of the ground."""
    return Footprint(model.length / 2.0, model.width / 2.0, bool(model.round))


def team_limits(team: Sequence[MotionLimits]) -> NDArray[np.void]:
    """The limits of several robots `(N,)` as one structured array, see `member`."""
    return np.array([tuple(limits) for limits in team], dtype=_LIMITS)


@subroutine
def member(team: NDArray[np.void], k: int) -> MotionLimits:
    """The limits of robot `k` of a team."""
    row = team[k]
    return MotionLimits(
        row.speed,
        row.acceleration,
        row.yaw_rate,
        row.yaw_acceleration,
        row.radius,
        row.backwards,
        row.backward_speed,
        row.free,
        row.half_length,
        row.half_width,
        row.round,
    )


@subroutine
def footprint_of(limits: MotionLimits) -> Footprint:
    """What the robot covers of the ground."""
    return Footprint(limits.half_length, limits.half_width, limits.round)


@cache
def primitives_of(model: RobotModel, finer: int = 0) -> Array:
    """The moves `(P, 8)` that a search tries from every state, with steps halved `finer` times.

    All callers share the array; nobody may change it.
    """
    limits = motion_limits(model)
    speed, radius = limits.speed, limits.radius
    scale = 0.5**finer
    rows: list[tuple[float, float, float, float, int, int]] = []
    eighth = math.pi / 8.0
    turns = [k * s * eighth * scale for k in (1, 2) for s in (1, -1)]
    turns += [math.pi / 2.0, -math.pi / 2.0, math.pi]
    ramp = speed * speed / (2.0 * limits.acceleration)
    step = 0.4 * scale
    # Walking on, stopping, setting off, and a small step from rest to rest.
    rows += [(step, 0.0, speed, speed, 1, 1), (ramp, 0.0, speed, 0.0, 1, 0)]
    rows += [(max(ramp, 0.2 * scale), 0.0, 0.0, speed, 0, 1), (0.2 * scale, 0.0, 0.0, 0.0, 0, 0)]
    if radius > 0.0:
        for bend in (eighth * scale, 2.0 * eighth * scale):
            for sign in (1.0, -1.0):
                rows.append((radius * bend, sign * bend, speed, speed, 1, 1))
        for sign in (1.0, -1.0):
            bend = max(ramp / radius, 2.0 * eighth)
            rows.append((radius * bend, sign * bend, 0.0, speed, 0, 1))
    if limits.backwards > 0.0:
        rows += [(-length * scale, 0.0, 0.0, 0.0, 0, 0) for length in (0.2, 0.5)]
    if limits.backwards == math.inf and radius > 0.0:
        bend = 0.4 * scale / radius
        rows += [(-0.4 * scale, sign * bend, 0.0, 0.0, 0, 0) for sign in (1.0, -1.0)]
    if limits.free:
        turns = [k * math.pi / 4.0 for k in (1, -1, 2, -2, 3, -3, 4)]
    rows += [(0.0, turn, 0.0, 0.0, 0, 0) for turn in turns]
    table = np.zeros((len(rows) + 1, 8))
    for row, (length, turn, v0, v1, before, after) in zip(table, rows, strict=False):
        vmax = speed if length >= 0.0 else limits.backward_speed
        make_move(row[:FROM_MOVING], length, turn, v0, v1, vmax, limits)
        row[FROM_MOVING:] = before, after
    table[-1, DURATION] = 0.5 * scale  # standing still
    return table
