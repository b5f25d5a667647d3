"""Many of one mesh in the scene, moved together: two messages, however many there are."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np

from cavalcade.geometry import Array
from cavalcade.studio.scene.meshes import Mesh
from cavalcade.studio.scene.palette import linear

_UPRIGHT = (1.0, 0.0, 0.0, 0.0)


class Batch:
    """Instances of one mesh; what has not changed is not sent again.

    Args:
        scene: `viser.SceneApi`.
        name: Of its node.
        mesh: What each of them looks like, in its own frame.
        on_click: What is called for a click while it is `clickable`.
        options: As `SceneApi.add_batched_meshes_simple` takes them.
    """

    def __init__(
        self,
        scene: Any,
        name: str,
        mesh: Mesh,
        on_click: Callable[[Any], Awaitable[None]] | None = None,
        **options: Any,
    ) -> None:
        self._scene, self._name, self._mesh = scene, name, mesh
        self._on_click, self._options = on_click, options
        self._node: Any = None
        self._room = 0
        self._told: dict[str, Array] = {}
        self._clickable = False

    def show(
        self, places: Array, turns: Array | None, colors: Array, scales: Array | None = None
    ) -> None:
        """Have K of them at `places` `(K, 3)`, turned by `turns` `(K, 4)`.

        Colours are `(K, 3)` from 0 to 255, scales `(K, 3)`.
        """
        count = len(places)
        if count == 0 and self._node is None:
            return
        if turns is None:
            turns = np.tile(_UPRIGHT, (count, 1))
        if scales is None:
            scales = np.ones((count, 3))
        if self._node is None:
            self._add(places, turns, colors, scales)
            return
        # Those that there is room for beyond `count` shrink to nothing, which is cheaper than to
        # make all of them anew.
        grows = count > self._room
        spare = count // 2 + 8 if grows else self._room - count
        if spare:
            places = np.pad(places, ((0, spare), (0, 0)))
            turns = np.concatenate([turns, np.tile(_UPRIGHT, (spare, 1))])
            scales = np.pad(scales, ((0, spare), (0, 0)))
            colors = np.pad(np.reshape(colors, (-1, 3)), ((0, spare), (0, 0)))
        if grows:
            self._add(places, turns, colors, scales)
            return
        self._set("batched_positions", places)
        self._set("batched_wxyzs", turns)
        self._set("batched_scales", scales)
        if self._is_new("batched_colors", colors):
            self._node.batched_colors = linear(colors)

    def _set(self, name: str, value: Array) -> None:
        if self._is_new(name, value):
            setattr(self._node, name, value.astype(np.float32))

    def _is_new(self, name: str, value: Array) -> bool:
        """Whether it is another one than last time; to ask is cheaper than to set it."""
        before = self._told.get(name)
        if before is not None and np.array_equal(before, value):
            return False
        self._told[name] = np.array(value)
        return True

    def remove(self) -> None:
        """Have none."""
        if self._node is not None:
            self._node.remove()
            self._node = None

    @property
    def clickable(self) -> bool:
        """Whether clicks are told; the page shows that by an outline under the pointer."""
        return self._clickable

    @clickable.setter
    def clickable(self, value: bool) -> None:
        if value == self._clickable or self._on_click is None:
            return
        self._clickable = value
        if self._node is not None and value:
            self._node.on_click(self._on_click)
        elif self._node is not None:
            self._node.remove_click_callback("all")

    def _add(self, places: Array, turns: Array, colors: Array, scales: Array) -> None:
        self.remove()
        self._room = len(places)
        self._told = {}
        self._node = self._scene.add_batched_meshes_simple(
            self._name,
            self._mesh.vertices,
            self._mesh.faces,
            batched_wxyzs=turns,
            batched_positions=places,
            batched_scales=np.asarray(scales, dtype=np.float32),
            batched_colors=linear(colors),
            lod="off",
            **self._options,
        )
        if self._clickable:
            self._node.on_click(self._on_click)
