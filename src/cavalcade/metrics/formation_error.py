"""How well the team holds its shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.frames import Recording


def placement_errors(positions: Array, slots: Array, taking_part: NDArray[np.bool_]) -> Array:
    """Distance of each robot to its own slot of the best-fit placement of the shape.

    The placement is the rotation and translation (no scaling, no reflection) with the least sum
    of squared distances.

    Args:
        positions: `(T, N, 2)` of the robots, m.
        slots: `(T, N, 2)` each robot's slot in the formation's frame, m.
        taking_part: `(T, N)` whether the robot has a slot.

    Returns:
        `(T, N)` m; 0 for robots that take no part.
    """
    weight = taking_part[..., None].astype(float)
    count = np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    p = (positions - (positions * weight).sum(axis=1, keepdims=True) / count) * weight
    q = (slots - (slots * weight).sum(axis=1, keepdims=True) / count) * weight
    along = (p * q).sum(axis=(1, 2))
    across = (q[..., 0] * p[..., 1] - q[..., 1] * p[..., 0]).sum(axis=1)
    turn = np.arctan2(across, along)[:, None]
    c, s = np.cos(turn), np.sin(turn)
    dx = p[..., 0] - (c * q[..., 0] - s * q[..., 1])
    dy = p[..., 1] - (s * q[..., 0] + c * q[..., 1])
    return np.asarray(np.hypot(dx, dy))


def formation_errors(recording: Recording) -> tuple[Array, NDArray[np.bool_]]:
    """The errors of a whole run, for true poses and the roles of each cycle.

    Returns:
        `(T, N)` distances in m and `(T, N)` whether the robot had a slot then.
    """
    cycles, robots = recording.poses.shape[:2]
    slots = np.zeros((cycles, robots, 2))
    taking_part = np.zeros((cycles, robots), dtype=bool)
    for k, status in enumerate(recording.status):
        has_slot = (status.roles >= 0) & (status.roles < len(status.slots))
        taking_part[k] = has_slot
        slots[k, has_slot] = status.slots[status.roles[has_slot]]
    return placement_errors(recording.poses[..., :2], slots, taking_part), taking_part
