"""The robots of the scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.studio import meshes
from cavalcade.studio.palette import Palette
from cavalcade.studio.snapshot import Snapshot


class Robots:
    """A team in the scene."""

    def __init__(
        self, scene: Any, palette: Palette, heights: Callable[[Array], Array], pick: Any
    ) -> None:
        self._scene, self._palette, self._heights, self._pick = scene, palette, heights, pick
        self._models: tuple[RobotModel, ...] = ()
        self._nodes: list[Any] = []

    def set(self, models: Sequence[RobotModel]) -> None:
        """Show these."""
        self.clear()
        self._models = tuple(models)
        for index, model in enumerate(models):
            x, y = model.length / 2.0, model.width / 2.0
            body = meshes.prism(np.array([(x, 0), (0.6 * x, y), (-x, y), (-x, -y), (0.6 * x, -y)]),
                                0.0, model.height)  # fmt: skip
            node = self._scene.add_mesh_simple(
                f"/robot/{index}", body.vertices, body.faces, color=self._palette.robot(index),
                flat_shading=True,
            )  # fmt: skip
            node.on_click(lambda event, index=index: self._pick(event, "robot", index))
            self._nodes.append(node)

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment."""
        heights = self._heights(snapshot.poses[:, :2])
        for node, (x, y, yaw), z in zip(self._nodes, snapshot.poses, heights, strict=False):
            node.position = (float(x), float(y), float(z))
            node.wxyz = (float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2)))

    def clear(self) -> None:
        """Take them away."""
        for node in self._nodes:
            node.remove()
        self._nodes.clear()
        self._models = ()
