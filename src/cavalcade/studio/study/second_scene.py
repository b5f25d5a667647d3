"""Another run in the same scene: beside the first one, or over it half-transparent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cavalcade.studio.scene.stage import Stage
from cavalcade.studio.snapshot import Snapshot
from cavalcade.studio.study.results import Result

_ROOT = "/second"
_GAP = 1.0
"""Between two grounds, m."""

_VEIL = 0.45
"""How much is seen of a robot over another one."""


class SecondScene:
    """What moves there is shown by a stage of its own, below a node that is put aside.

    Args:
        server: The page's.
        first, second: The runs.
        over: Whether the second is shown on the ground of the first, which it needs to share.
        dark: Whether the page is.
    """

    def __init__(
        self, server: Any, first: Result, second: Result, *, over: bool, dark: bool
    ) -> None:
        self.offset = (0.0, 0.0) if over else _beside(first, second)
        self._node = server.scene.add_frame(_ROOT, show_axes=False, position=(*self.offset, 0.0))
        self._stage = Stage(_Below(server, _ROOT, _VEIL if over else None))
        self._stage.set_dark(dark)
        if over:
            for layer in self._stage.layers:  # those of the first run are enough
                self._stage.set_layer(layer, False)
        else:
            self._stage.set_world(second.scenario, second.world)
        self._stage.set_team(second.scenario.models, second.scenario.starts)
        self._stage.set_trajectories(*second.planned)

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment."""
        self._stage.show(snapshot)

    def set_dark(self, dark: bool) -> None:
        """Follow the page's theme."""
        self._stage.set_dark(dark)

    def remove(self) -> None:
        """Take it away."""
        self._stage.clear()
        self._node.remove()


def may_lie_over(first: Result, second: Result) -> bool:
    """Whether both runs have the same level ground."""
    one, other = first.start, second.start
    return (
        one.terrain is None
        and other.terrain is None
        and one.base.origin == other.base.origin
        and np.array_equal(one.base.grid, other.base.grid)
        and one.shapes == other.shapes
    )


def _beside(first: Result, second: Result) -> tuple[float, float]:
    """By how much the second ground is moved, m: to the long side of the first one."""
    boxes = []
    for result in (first, second):
        base = result.start.base
        width, height = base.size
        corners = base.to_map([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)])
        boxes.append((corners.min(axis=0), corners.max(axis=0)))
    (low, high), (other_low, other_high) = boxes
    if high[0] - low[0] > high[1] - low[1]:
        return float(low[0] - other_low[0]), float(low[1] - _GAP - other_high[1])
    return float(high[0] + _GAP - other_low[0]), float(low[1] - other_low[1])


class _Below:
    """A server whose scene begins at a node; all else is the server's."""

    def __init__(self, server: Any, root: str, opacity: float | None) -> None:
        self._server = server
        self.scene = _SceneBelow(server.scene, root, opacity)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)


class _SceneBelow:
    """A scene whose nodes stand below one of another scene."""

    def __init__(self, scene: Any, root: str, opacity: float | None) -> None:
        self._scene, self._root, self._opacity = scene, root, opacity

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._scene, name)
        return self._below(found, name) if name.startswith("add_") else found

    def _below(self, add: Callable[..., Any], kind: str) -> Callable[..., Any]:
        def added(name: str, *arguments: Any, **options: Any) -> Any:
            if self._opacity is not None and "mesh" in kind and "trimesh" not in kind:
                options["opacity"] = self._opacity
            return add(f"{self._root}/{name.lstrip('/')}", *arguments, **options)

        return added
