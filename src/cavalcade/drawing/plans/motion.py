"""What a robot does along its trajectory: stretches of standing, walking, turning and flight."""

from __future__ import annotations

import numpy as np

from cavalcade.drawing.scene import runs
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK, Trajectory

STILL = 0.01
"""A body slower than this stands, m/s and rad/s."""

STANDS, WALKS, FLIES, TURNS = 0, 1, 2, 3


def activities(path: Trajectory) -> list[int]:
    """What the robot does in each of the `T - 1` intervals: `STANDS`, `WALKS` (or drives), ..."""
    steps = np.diff(path.time)
    moved = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    turned = np.abs(np.diff(path.yaw))
    phase = path.phase[:-1]
    there = (phase == WALK) & (moved < STILL * steps + 1e-6)
    still = there & (turned < STILL * steps + 1e-6)
    kinds = np.where(still, STANDS, np.where(there, TURNS, WALKS))
    return np.where(phase == FLIGHT, FLIES, kinds).tolist()


def leaps(path: Trajectory) -> list[tuple[int, int]]:
    """First and last sample of each leap, from the start of its take-off to its landing's end."""
    leaping = np.isin(path.phase[:-1], (TAKE_OFF, FLIGHT, LANDING))
    return [(first, last) for value, first, last in runs(leaping.tolist()) if value]


def along(path: Trajectory) -> Array:
    """`(T,)` m travelled by each sample, horizontally."""
    steps = np.hypot(*np.diff(path.position[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])
