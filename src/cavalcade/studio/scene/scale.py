"""A grid of metres on the ground, with figures at its edge."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.studio.scene.figures import written
from cavalcade.studio.scene.meshes import Mesh, quads
from cavalcade.studio.scene.palette import Color, Palette

_HEIGHT = 0.004
"""Over the ground, m."""

_WIDTH = 0.014
"""Of a line, in units of the distance between two."""

_MOST_LINES = 60
_SAMPLE = 0.25
"""Lines over terrain bend this often, m."""


def spacing(extent: float) -> int:
    """Metres between two lines of a map that is so long, m: 1, 2, 5 or ten times as many."""
    for step in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000):
        if extent / step <= _MOST_LINES:
            return step
    return 10 ** int(np.ceil(np.log10(extent / _MOST_LINES)))


def grid_lines(corners: Array, step: float) -> tuple[Array, NDArray[np.bool_]]:
    """Lines at multiples of `step` in a convex outline `(4, 2)` of the map frame.

    Returns:
        `(K, 2, 2)` their ends, m; `(K,)` which of them are multiples of five steps.
    """
    found, strong = [], []
    for axis in (0, 1):
        low, high = corners[:, axis].min(), corners[:, axis].max()
        for count in range(int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9)) + 1):
            across = _crossings(corners, axis, count * step)
            if across is not None:
                ends = np.empty((2, 2))
                ends[:, axis], ends[:, 1 - axis] = count * step, across
                found.append(ends)
                strong.append(count % 5 == 0)
    return np.array(found).reshape(-1, 2, 2), np.array(strong, dtype=bool)


def _crossings(corners: Array, axis: int, value: float) -> tuple[float, float] | None:
    """Between which coordinates of the other axis a line runs inside the outline."""
    places = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        low, high = sorted((a[axis], b[axis]))
        if high - low > 1e-9 and low - 1e-9 <= value <= high + 1e-9:
            share = (value - a[axis]) / (b[axis] - a[axis])
            places.append(a[1 - axis] + share * (b[1 - axis] - a[1 - axis]))
    if not places or max(places) - min(places) < 1e-9:
        return None
    return float(min(places)), float(max(places))


class Scale:
    """The grid in the scene."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._nodes: list[Any] = []

    def show(
        self, corners: Array, palette: Palette, heights: Callable[[Array], Array] | None
    ) -> None:
        """Draw it over a map with these corners `(4, 2)`; `heights` where the ground has some."""
        self.clear()
        step = spacing(float(np.ptp(corners, axis=0).max()))
        lines, strong = grid_lines(corners, step)
        for name, chosen, color in (
            ("fine", ~strong, palette.cell),
            ("strong", strong, palette.section),
        ):
            if chosen.any():
                self._add(name, _draped(lines[chosen], heights), color, _WIDTH * step)
        figures = _figures(lines[strong], step)
        if len(figures):
            self._add("figures", _draped(figures, heights), palette.figures, 1.6 * _WIDTH * step)

    def clear(self) -> None:
        """Take it away."""
        for node in self._nodes:
            node.remove()
        self._nodes.clear()

    def _add(self, name: str, segments: Array, color: Color, width: float) -> None:
        mesh = _strips(segments, width)
        self._nodes.append(
            self._scene.add_mesh_simple(
                f"/scale/{name}",
                mesh.vertices,
                mesh.faces,
                color=color,
                cast_shadow=False,
                receive_shadow=False,
            )
        )


def _strips(segments: Array, width: float) -> Mesh:
    """Segments `(K, 2, 3)` as wide as that, m, seen from above."""
    start, end = segments[:, 0], segments[:, 1]
    way = (end - start)[:, :2]
    way = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    half = 0.5 * width * np.column_stack([-way[:, 1], way[:, 0], np.zeros(len(way))])
    ahead = np.column_stack([0.5 * width * way, np.zeros(len(way))])  # corners have no gaps
    low, high = start - ahead, end + ahead
    return quads(np.stack([low - half, high - half, high + half, low + half], axis=1))


def _figures(lines: Array, step: float) -> Array:
    """Segments `(K, 2, 2)` of how many metres each line stands for, before its beginning."""
    size = 0.26 * step
    found = [np.zeros((0, 2, 2))]
    corners = {tuple(first) for first, last in lines if first[0] == last[0]}
    for first, last in lines:
        upright = first[0] == last[0]
        if not upright and tuple(first) in corners:
            continue  # two figures would lie on each other
        text = f"{first[0] if upright else first[1]:.0f} m"
        gap = (0.0, -0.5 * size) if upright else (-0.5 * size, 0.5 * size)
        found.append(written(text, first + gap, size, 0.5 if upright else 1.0))
    return np.concatenate(found)


def _draped(lines: Array, heights: Callable[[Array], Array] | None) -> Array:
    """Segments `(K, 2, 3)` of lines `(L, 2, 2)`, over the ground."""
    if heights is None:
        return np.concatenate([lines, np.full((len(lines), 2, 1), _HEIGHT)], axis=-1)
    parts = []
    for first, last in lines:
        count = max(int(np.ceil(np.hypot(*(last - first)) / _SAMPLE)), 1)
        points = first + np.linspace(0.0, 1.0, count + 1)[:, None] * (last - first)
        line = np.column_stack([points, heights(points) + 2.0 * _HEIGHT])
        parts.append(np.stack([line[:-1], line[1:]], axis=1))
    return np.concatenate(parts)
