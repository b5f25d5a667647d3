"""Where a robot's links are, from its trunk and joints: the reference for the page's own script."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cavalcade.geometry import Array

LINKS = 13
"""The trunk, then per leg hip, thigh and calf."""


def link_frames(skeleton: Mapping[str, Any], base: Array, joints: Array) -> tuple[Array, Array]:
    """Places `(T, 13, 3)` and rotations `(T, 13, 3, 3)`, link to map, of all links.

    Args:
        skeleton: What `skeleton_of` made.
        base: `(T, 7)` the trunk's position and unit quaternion w, x, y, z.
        joints: `(T, 12)` rad.
    """
    place = np.empty((len(base), LINKS, 3))
    turn = np.empty((len(base), LINKS, 3, 3))
    place[:, 0], turn[:, 0] = base[:, :3], rotations(base[:, 3:])
    for k, link in enumerate(skeleton["links"]):
        parent, axis = link["parent"], np.array(link["axis"])
        half = joints[:, k] / 2.0
        spin = np.column_stack([np.cos(half), np.sin(half)[:, None] * axis])
        place[:, k + 1] = place[:, parent] + turn[:, parent] @ np.array(link["offset"])
        turn[:, k + 1] = turn[:, parent] @ rotations(spin)
    return place, turn


def foot_places(skeleton: Mapping[str, Any], base: Array, joints: Array) -> Array:
    """Centres `(T, 4, 3)` of the feet's balls in the map frame, m; arguments of `link_frames`."""
    place, turn = link_frames(skeleton, base, joints)
    return np.stack(
        [
            place[:, foot["link"]] + turn[:, foot["link"]] @ np.array(foot["offset"])
            for foot in skeleton["feet"]
        ],
        axis=1,
    )


def rotations(quaternions: Array) -> Array:
    """Rotations `(..., 3, 3)`, body to map, of unit quaternions `(..., 4)` w, x, y, z."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, dtype=float), -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
