"""Planned trajectories over time with their footholds, as lines and dots that stay."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cavalcade.drawing.outlines import fewest_points
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, Trajectory
from cavalcade.studio.scene import meshes
from cavalcade.studio.scene.batch import Batch
from cavalcade.studio.scene.palette import Palette, linear

TRAJECTORIES, FOOTHOLDS = "trajectories", "footholds"

_TOLERANCE = 0.01
"""By how much a drawn line may miss the trajectory, m."""

_DOT = 0.022
_OVER = 0.012
"""Footholds' radius and height over the ground, m."""


class Planned:
    """Where robots will be, in the scene.

    Args:
        scene: `viser.SceneApi`.
        palette: Its colours.
    """

    LAYERS = (TRAJECTORIES, FOOTHOLDS)

    def __init__(self, scene: Any, palette: Palette) -> None:
        self._scene, self._palette = scene, palette
        self._lines: Any = None
        dot = meshes.turned_profile(np.array([(_DOT, 0.0), (0.0, 0.0)]), 10)
        self._dots = Batch(scene, "/footholds", dot, cast_shadow=False, receive_shadow=False)
        self._trajectories: tuple[Trajectory | None, ...] = ()
        self._footholds: tuple[Array, ...] = ()

    def set(self, trajectories: Sequence[Trajectory | None], footholds: Sequence[Array]) -> None:
        """Have these, one per robot; footholds `(M, 6)` are as `plan_footholds` gives them."""
        self._trajectories, self._footholds = tuple(trajectories), tuple(footholds)

    def recolor(self, palette: Palette) -> None:
        """Other colours from the next time on that it is shown."""
        self._palette = palette

    def show(self, layer: str) -> None:
        """Show a layer."""
        if layer == FOOTHOLDS:
            self._show_footholds()
        else:
            self._show_lines()

    def hide(self, layer: str) -> None:
        """Take a layer away."""
        if layer == FOOTHOLDS:
            self._dots.remove()
        elif self._lines is not None:
            self._lines.remove()
            self._lines = None

    def clear(self) -> None:
        """Forget them all."""
        self._trajectories = self._footholds = ()
        for layer in self.LAYERS:
            self.hide(layer)

    def _show_lines(self) -> None:
        segments, colors = [np.zeros((0, 2, 3))], [np.zeros((0, 2, 3))]
        for robot, trajectory in enumerate(self._trajectories):
            if trajectory is None:
                continue
            color = np.array(self._palette.robot(robot), dtype=float)
            for flying, line in _stretches(trajectory):
                # Flight stands out: brighter than the walk on both sides of it.
                shade = 0.5 * color + 127.5 if flying else color
                segments.append(np.stack([line[:-1], line[1:]], axis=1))
                colors.append(np.tile(shade, (len(line) - 1, 2, 1)))
        lines = np.concatenate(segments)
        if not len(lines):
            self.hide(TRAJECTORIES)
            return
        self._lines = self._scene.add_line_segments(
            "/trajectories", lines, linear(np.concatenate(colors)), thickness=0.03
        )

    def _show_footholds(self) -> None:
        places, colors = [np.zeros((0, 3))], [np.zeros((0, 3))]
        for robot, feet in enumerate(self._footholds):
            if len(feet):
                places.append(feet[:, 3:6] + (0.0, 0.0, _OVER))
                colors.append(np.tile(np.array(self._palette.robot(robot), float), (len(feet), 1)))
        self._dots.show(np.concatenate(places), None, np.concatenate(colors))


def _stretches(trajectory: Trajectory) -> list[tuple[bool, Array]]:
    """Whether it flies, and the line `(K, 3)`, stretch by stretch."""
    flying = trajectory.phase == FLIGHT
    ends = np.flatnonzero(np.diff(flying.astype(np.int8)))
    edges = [0, *(ends + 1).tolist(), len(flying) - 1]
    found = []
    for first, last in pairwise(edges):
        line = trajectory.position[first : last + 1]
        if len(line) > 1:
            found.append((bool(flying[first]), _thinner(line)))
    return found


def _thinner(line: Array) -> Array:
    """The fewest points of a line `(K, 3)` that stay near all of it."""

    def errors(first: int, last: int) -> Array:
        chord = line[last] - line[first]
        between = line[first + 1 : last] - line[first]
        along = between @ chord / max(float(chord @ chord), 1e-24)
        return np.linalg.norm(between - np.clip(along, 0.0, 1.0)[:, None] * chord, axis=1)

    return line[fewest_points([0, len(line) - 1], errors, _TOLERANCE)]
