"""From where the scene is looked at first."""

from __future__ import annotations

from typing import Any

import numpy as np

from cavalcade.geometry import Array

_FIELD = np.radians(45.0)
"""Vertical field of view: little distortion at the edges."""

_ASPECT = 1.15
"""Width by height of the narrowest view: what panels leave of a small page."""

_RISE = np.radians(52.0)
"""How steeply one looks down."""

_SPARE = 1.12
_ROUNDS = 8
_NEAREST, _FARTHEST = 4.0, 2000.0
"""Of the camera from what it looks at, m."""


def view_of(points: Array, towards: float = np.pi / 2.0) -> tuple[Array, Array]:
    """Eye and target from which all of `points` `(N, 3)` are seen.

    Args:
        points: m.
        towards: Heading in which one looks, rad; north is up then.
    """
    flat = np.array([np.cos(towards), np.sin(towards), 0.0])
    away = np.sin(_RISE) * np.array([0.0, 0.0, 1.0]) - np.cos(_RISE) * flat
    right = np.array([flat[1], -flat[0], 0.0])
    up = np.cross(right, -away)
    tall = np.tan(_FIELD / 2.0)
    target = (points.min(axis=0) + points.max(axis=0)) / 2.0
    distance = _NEAREST
    for _ in range(_ROUNDS):
        arm = points - target
        # A point is seen if its sideways and upward shares of its depth are small enough.
        needed = [np.abs(arm @ right) / (tall * _ASPECT), np.abs(arm @ up) / tall]
        distance = float(np.clip(_SPARE * np.max(needed + arm @ away), _NEAREST, _FARTHEST))
        depth = distance - arm @ away
        # What is near takes more of the picture than what is far: bring its middle to the middle.
        for side in (right, up):
            share = (arm @ side) / depth
            target = target + 0.5 * distance * (share.min() + share.max()) * side
    return target + distance * away, target


def look(server: Any, eye: Array, target: Array) -> None:
    """Have all who look, and all who come, look from there."""
    eye_at, target_at = (tuple(float(part) for part in place) for place in (eye, target))
    first = server.initial_camera
    first.fov, first.near, first.far = float(_FIELD), 0.05, 5000.0
    first.position, first.look_at = eye_at, target_at
    for client in server.get_clients().values():
        with client.atomic():
            client.camera.fov = float(_FIELD)
            client.camera.position = eye_at
            client.camera.look_at = target_at
