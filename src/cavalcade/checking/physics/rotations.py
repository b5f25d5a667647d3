"""Rotations of many samples at once: quaternions, turns about an axis, turns between samples."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array


def matrices(quaternions: Array) -> Array:
    """Rotations `(..., 3, 3)`, body to world, of unit quaternions `(..., 4)` w, x, y, z."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def about(axis: Array, angles: Array) -> Array:
    """Rotations `(..., 3, 3)` by `angles` `(...)` about the unit vector `axis` `(3,)`."""
    half = angles / 2.0
    vector = np.sin(half)[..., None] * axis
    return matrices(np.concatenate((np.cos(half)[..., None], vector), axis=-1))


def turns(rotation: Array) -> Array:
    """Rotation vectors `(T - 1, ..., 3)`, world frame, from each of `(T, ..., 3, 3)` to the next.

    They are right to second order in the angle's third power, and below a right angle: what a body
    turns by between samples.
    """
    change = rotation[1:] @ np.swapaxes(rotation[:-1], -1, -2)
    sine = 0.5 * np.stack(
        (
            change[..., 2, 1] - change[..., 1, 2],
            change[..., 0, 2] - change[..., 2, 0],
            change[..., 1, 0] - change[..., 0, 1],
        ),
        axis=-1,
    )
    size = np.linalg.norm(sine, axis=-1)
    angle = np.arctan2(size, (np.trace(change, axis1=-2, axis2=-1) - 1.0) / 2.0)
    scale = np.where(size > 1e-9, angle / np.maximum(size, 1e-9), 1.0)
    return sine * scale[..., None]


def roll_pitch_yaw(rotation: Array) -> Array:
    """Roll, pitch and yaw `(..., 3)` of rotations `(..., 3, 3)`: yaw about z, then y, then x."""
    roll = np.arctan2(rotation[..., 2, 1], rotation[..., 2, 2])
    pitch = -np.arcsin(np.clip(rotation[..., 2, 0], -1.0, 1.0))
    yaw = np.arctan2(rotation[..., 1, 0], rotation[..., 0, 0])
    return np.stack((roll, pitch, yaw), axis=-1)
