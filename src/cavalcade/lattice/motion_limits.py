"""How each kind of robot moves in the plane, as the arrays that the kernels of moves take."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import Array
from cavalcade.lattice.primitives import make_move
from cavalcade.robots import RobotModel

_GENTLE = (2.0, 4.0)
"""m/s² and rad/s² where a robot has no limits of its own, so that its speed does not jump."""

_BACKWARDS = (0.6, 0.3)
"""m at a stretch, and m/s: robots with legs step back only to get out of or into tight places."""


def mover_of(model: RobotModel) -> Array:
    """The array `(11,)` that kernels of moves call a mover, see `_moves`."""
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
    free = model.drive in ("integrator", "integrator-2")
    return np.array(
        [
            speed,
            acceleration,
            rate,
            turning,
            radius,
            back,
            float(free),
            model.length / 2.0,
            model.width / 2.0,
            float(model.round),
            back_speed,
        ]
    )


def primitives_of(model: RobotModel, finer: int = 0) -> Array:
    """The moves `(P, 8)` that a search in space and time tries from every state.

    Args:
        model: Of the robot.
        finer: How often to halve the steps.
    """
    mover = mover_of(model)
    speed, acceleration = mover[0], mover[1]
    scale = 0.5**finer
    rows: list[tuple[float, float, float, float, int, int]] = []
    eighth = math.pi / 8.0
    turns = [k * s * eighth * scale for k in (1, 2) for s in (1, -1)]
    turns += [math.pi / 2.0, -math.pi / 2.0, math.pi]
    ramp = speed * speed / (2.0 * acceleration)
    radius, free = mover[4], mover[6] > 0.0
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
    if mover[5] > 0.0:
        rows += [(-length * scale, 0.0, 0.0, 0.0, 0, 0) for length in (0.2, 0.5)]
    if mover[5] == math.inf and radius > 0.0:
        bend = 0.4 * scale / radius
        rows += [(-0.4 * scale, sign * bend, 0.0, 0.0, 0, 0) for sign in (1.0, -1.0)]
    if free:
        turns = [k * math.pi / 4.0 for k in (1, -1, 2, -2, 3, -3, 4)]
    rows += [(0.0, turn, 0.0, 0.0, 0, 0) for turn in turns]
    table = np.zeros((len(rows) + 1, 8))
    for row, (length, turn, v0, v1, before, after) in zip(table, rows, strict=False):
        make_move(row[:6], length, turn, v0, v1, speed if length >= 0.0 else mover[10], mover)
        row[6:] = before, after
    table[-1, 5] = 0.5 * scale  # standing still
    return table
