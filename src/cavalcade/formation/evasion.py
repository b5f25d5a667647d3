"""Stepping aside in time for obstacles that move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.ground import Ground
from cavalcade.geometry import Array

_HORIZON = 5.0  # s
_CLEAR = 0.55  # m between a robot's centre and the swept way of an obstacle


def evade(
    wanted: Array,
    poses: Array,
    active: NDArray[np.int64],
    movers: Array,
    speeds: Array,
    ground: Ground,
    top: float,
    turn_rate: float = 1.2,
) -> None:
    """Replace the wanted velocities of robots that a moving obstacle is going to meet.

    Such a robot leaves the strip that the obstacle will sweep, on the side that takes less time
    and is free; one that would enter a strip in front of the obstacle waits.

    Args:
        wanted: `(N, 3)` velocities in the grid's frame, changed in place.
        poses: `(N, 3)`.
        active: Robots that take part.
        movers: `(M, 5)` pose, half length, half width.
        speeds: `(M, 2)` m/s.
        ground: The map.
        top: Robots' top speed, m/s.
        turn_rate: Their top yaw rate, rad/s.
    """
    for box, speed in zip(movers, speeds, strict=True):
        pace = float(np.hypot(*speed))
        if pace < 1e-6:
            continue
        along = speed / pace
        across = np.array([-along[1], along[0]])
        yaw = box[2]
        axes = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        half_across = float(np.abs(axes @ across) @ box[3:5])
        half_along = float(np.abs(axes @ along) @ box[3:5])
        for k in active:
            offset = poses[k, :2] - box[:2]
            ahead, beside = float(offset @ along), float(offset @ across)
            needed = half_across + _CLEAR
            reach = half_along + 0.4 + pace * _HORIZON
            if not -half_along - 0.4 < ahead < reach:
                continue
            if abs(beside) >= needed:
                closing = -np.sign(beside) * float(wanted[k, :2] @ across)
                if abs(beside) < needed + 0.3 and closing > 0.0:
                    wanted[k, :2] += np.sign(beside) * closing * across
                continue
            side = _better_side(poses[k, :2], beside, needed, across, ground)
            out = side * across
            wanted[k, :2] = top * out
            turn = np.arctan2(out[1], out[0]) - poses[k, 2]
            # Forwards or backwards is all the same: a body steps fastest along its own axis.
            turn = (turn + np.pi / 2.0) % np.pi - np.pi / 2.0
            wanted[k, 2] = np.clip(3.0 * turn, -turn_rate, turn_rate)


def _better_side(
    point: Array, beside: float, needed: float, across: Array, ground: Ground
) -> float:
    """+1 or -1: the side on which the strip is left sooner, unless an obstacle bars it."""
    first = 1.0 if beside >= 0.0 else -1.0
    for side in (first, -first):
        way = needed - side * beside
        steps = np.arange(0.1, way + 0.1, 0.1)
        places = point + np.outer(steps, side * across)
        if (ground.clearance(places) > 0.25).all():
            return side
    return first
