"""Angles, planar poses and rectangles. Radians, metres, counter-clockwise (REP-103)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
"""Acceleration of free fall, m/s²."""

CLEARANCE = 0.001
"""What bodies keep at starts and goals from obstacles, borders and each other, m; whatever stands
nearer touches. On their ways they never touch: the checker counts 1 µm as contact."""


def beyond_a_turn(yaw: float) -> bool:
    """Whether a heading is more than a turn: it may well be in degrees."""
    return abs(yaw) > 2.0 * np.pi + 0.02  # 6.3 is a turn, too


def wrap_angle(angle: ArrayLike) -> Array:
    """Angles `(...)` mapped to [-pi, pi)."""
    return (np.asarray(angle, dtype=float) + np.pi) % (2.0 * np.pi) - np.pi


def rotation(yaw: float) -> Array:
    """Rotation matrix `(2, 2)` that turns vectors counter-clockwise by `yaw`."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


def transform_points(pose: ArrayLike, points: ArrayLike) -> Array:
    """Points `(N, 2)` given in the frame of `pose` (x, y, yaw), expressed in its parent frame."""
    x, y, yaw = np.asarray(pose, dtype=float)
    return np.asarray(points, dtype=float) @ rotation(yaw).T + (x, y)


def inverse_transform_points(pose: ArrayLike, points: ArrayLike) -> Array:
    """Points `(N, 2)` given in the parent frame, expressed in the frame of `pose` (x, y, yaw)."""
    x, y, yaw = np.asarray(pose, dtype=float)
    return (np.asarray(points, dtype=float) - (x, y)) @ rotation(yaw)


def rectangle_corners(pose: ArrayLike, length: float, width: float) -> Array:
    """Corners `(4, 2)`, counter-clockwise, of a rectangle centred on `pose` (x, y, yaw).

    `length` lies along the pose's x axis, `width` along its y axis.
    """
    half = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) / 2.0
    return transform_points(pose, half * (length, width))
