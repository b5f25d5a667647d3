"""Turns as quaternions w, x, y, z, many at once; their last axis has the four numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.geometry import Array


def about_z(yaw: ArrayLike) -> Array:
    """Turns `(..., 4)` about the vertical by angles `(...)`, rad."""
    half = 0.5 * np.asarray(yaw, dtype=float)
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)


def product(a: Array, b: Array) -> Array:
    """First b, then a."""
    w, v, s, u = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    real = w * s - (v * u).sum(axis=-1, keepdims=True)
    return np.concatenate([real, w * u + s * v + np.cross(v, u)], axis=-1)


def turned(turn: Array, vectors: Array) -> Array:
    """Vectors `(..., 3)` turned."""
    w, v = turn[..., :1], turn[..., 1:]
    twice = 2.0 * np.cross(v, vectors)
    return np.asarray(vectors + w * twice + np.cross(v, twice))


def inverse(turn: Array) -> Array:
    """The way back."""
    return np.asarray(turn * (1.0, -1.0, -1.0, -1.0))


def along(ways: Array) -> Array:
    """Turns `(N, 4)` that bring x along ways `(N, 3)` and keep y level."""
    pitch = -np.arctan2(ways[:, 2], np.hypot(ways[:, 0], ways[:, 1]))
    return product(about_z(np.arctan2(ways[:, 1], ways[:, 0])), _about(pitch, 1))


def from_axes(forward: Array, left: Array) -> Array:
    """Turns `(N, 4)` whose x axes point along `forward` `(N, 3)`, y axes as near `left` as can be.

    For slopes, not for loops: x must not point straight up.
    """
    x = forward / np.linalg.norm(forward, axis=-1, keepdims=True)
    yaw = np.arctan2(x[:, 1], x[:, 0])
    pitch = -np.arcsin(np.clip(x[:, 2], -1.0, 1.0))
    level = turned(inverse(product(about_z(yaw), _about(pitch, 1))), left)
    roll = np.arctan2(level[:, 2], level[:, 1])
    return product(product(about_z(yaw), _about(pitch, 1)), _about(roll, 0))


def _about(angle: Array, axis: int) -> Array:
    half = 0.5 * angle
    turn = np.zeros((len(half), 4))
    turn[:, 0], turn[:, 1 + axis] = np.cos(half), np.sin(half)
    return turn
