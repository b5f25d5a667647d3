"""The ground that feet stand on: level, or heights as their source says them."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.heights import Ground, Heights, ground_around
from cavalcade.geometry import Array

_AROUND = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]], dtype=float)

STEEP, BENT = 0.8, 0.2
"""Steeper ground, and ground whose slope changes by more within a foot's width, is an edge."""


ROUNDING = 0.05
"""Of a force recorded as a mean while its foot rolls: rad."""


class Floor(Protocol):
    """Heights of the ground in the map frame."""

    @property
    def doubt(self) -> float:
        """How far a force may be turned against the ground's normal as it is known here, rad."""

    def range_at(self, places: Array, reach: float) -> tuple[Array, Array]:
        """Lowest and highest ground `(...)` within `reach` m of places `(..., 2)`, m.

        Between the heights that its source gives, the ground may lie anywhere: whoever makes
        triangles or boxes of them stays within this range.
        """

    def normals_at(self, places: Array, reach: float) -> Array:
        """Unit vectors `(..., 3)` across the ground at places `(..., 2)`, seen `reach` m around."""

    def even_at(self, places: Array, reach: float) -> NDArray[np.bool_]:
        """Whether the ground around places `(..., 2)` has one normal: no edge and no wall."""


class LevelFloor:
    """Ground at height 0 everywhere."""

    doubt = ROUNDING

    def range_at(self, places: Array, reach: float) -> tuple[Array, Array]:
        """Zeros."""
        zero = np.zeros(places.shape[:-1])
        return zero, zero

    def normals_at(self, places: Array, reach: float) -> Array:
        """All upright."""
        return np.broadcast_to((0.0, 0.0, 1.0), (*places.shape[:-1], 3))

    def even_at(self, places: Array, reach: float) -> NDArray[np.bool_]:
        """Everywhere."""
        return np.ones(places.shape[:-1], dtype=bool)


class HeightFloor:
    """Ground from a grid of heights."""

    # What counts as even has slopes that differ by so much below one foot.
    doubt = ROUNDING + BENT

    def __init__(self, ground: Ground) -> None:
        self._ground = ground

    def range_at(self, places: Array, reach: float) -> tuple[Array, Array]:
        """Of the grid's values around the place and around four others `reach` away."""
        low, high = self._ground.range_at(places[..., None, :] + reach * _AROUND)
        return low.min(axis=-1), high.max(axis=-1)

    def normals_at(self, places: Array, reach: float) -> Array:
        """From the heights before, behind, left and right; on an edge half way between."""
        slope = np.clip(self._slope_at(places, reach), -STEEP, STEEP)
        normals = np.concatenate((-slope, np.ones((*slope.shape[:-1], 1))), axis=-1)
        return normals / np.linalg.norm(normals, axis=-1, keepdims=True)

    def even_at(self, places: Array, reach: float) -> NDArray[np.bool_]:
        """Where slopes seen nearby and from three times as far are gentle and about the same.

        They are so, too, before and behind, left and right of the place itself: a foot beside an
        edge sees half of it from near and from far.
        """
        near, far = self._slope_at(places, reach), self._slope_at(places, 3.0 * reach)
        size = np.maximum(np.abs(near), np.abs(far)).max(axis=-1)
        bend = np.maximum(self._bend_at(places, reach), self._bend_at(places, 2.0 * reach))
        bend = np.maximum(bend, np.abs(near - far).max(axis=-1))
        return (size < STEEP) & (bend < BENT)

    def _bend_at(self, places: Array, reach: float) -> Array:
        """Largest change `(...)` of the slope from one side of a place to the other."""
        heights = self._ground.heights_at(places[..., None, :] + reach * _AROUND)
        sides = heights[..., 1::2] + heights[..., 2::2] - 2.0 * heights[..., :1]
        return np.abs(sides / reach).max(axis=-1)

    def _slope_at(self, places: Array, reach: float) -> Array:
        heights = self._ground.heights_at(places[..., None, :] + reach * _AROUND[1:])
        return (heights[..., ::2] - heights[..., 1::2]) / (2.0 * reach)


def floor_of(heights: Heights | None, places: Array) -> Floor:
    """The ground around places `(N, 2)` that are walked on."""
    return LevelFloor() if heights is None else HeightFloor(ground_around(heights, places))
