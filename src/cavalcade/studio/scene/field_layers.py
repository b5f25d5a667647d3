"""Pictures of the planner's fields under the scene, made in a thread of their own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from cavalcade.geometry import rotation
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.studio.scene import rotations
from cavalcade.studio.scene.ground_fields import ARRIVAL, VELOCITY, field_picture
from cavalcade.studio.scene.palette import Palette
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import shape_from_mapping

_HEIGHTS = {VELOCITY: 0.002, ARRIVAL: 0.003}
"""Over the ground, m."""

_PERIOD = 0.5
"""At least so long between two pictures, s: they are costly, and obstacles may move on and on."""


class FieldLayers:
    """The fields that are shown; another one is made once what it depends on has changed.

    Args:
        server: The page's server.
        palette: Colours.
    """

    LAYERS = (VELOCITY, ARRIVAL)

    def __init__(self, server: Any, palette: Palette) -> None:
        self._server, self._palette = server, palette
        self._lock = threading.Lock()
        self._wanted: dict[str, tuple[Any, Callable[[], None]]] = {}
        self._shown: dict[str, Any] = {}
        self._nodes: dict[str, Any] = {}
        self._busy = False

    def recolor(self, palette: Palette) -> None:
        """Other colours from the next time on that they are shown."""
        self._palette = palette
        with self._lock:
            self._shown.clear()

    def show(
        self, layer: str, scenario: ResolvedScenario, world: World, snapshot: Snapshot
    ) -> None:
        """Show a layer of a moment; it may come a little later."""
        goal = None if snapshot.status is None else snapshot.status.goal
        place = None if goal is None else tuple(np.round(goal[:2], 3).tolist())
        # Worlds by identity: to compare their maps ten times a second is too much.
        key = (scenario.planner, id(world), snapshot.obstacles, place if layer == ARRIVAL else None)
        palette = self._palette

        def make() -> None:
            movers = [shape_from_mapping(one.to_dict()) for one in snapshot.obstacles]
            shapes = (*world.shapes, *movers)
            picture = field_picture(layer, scenario, world, shapes, goal, palette)
            self._put(layer, key, picture, world)

        with self._lock:
            before = self._wanted.get(layer, (self._shown.get(layer),))[0]
            if before == key:
                return
            self._wanted[layer] = (key, make)
            if self._busy:
                return
            self._busy = True
        threading.Thread(target=self._work, name="studio-fields", daemon=True).start()

    def hide(self, layer: str) -> None:
        """Take a layer away."""
        with self._lock:
            self._wanted.pop(layer, None)
            self._shown.pop(layer, None)
            node = self._nodes.pop(layer, None)
        if node is not None:
            node.remove()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._wanted:
                    self._busy = False
                    return
                layer = next(iter(self._wanted))
                key, make = self._wanted[layer]
            try:
                make()
            finally:
                with self._lock:
                    if self._wanted.get(layer, (None,))[0] is key:
                        del self._wanted[layer]
            time.sleep(_PERIOD)

    def _put(self, layer: str, key: Any, picture: Any, world: World) -> None:
        """Show a picture unless the layer is to show another one by now."""
        with self._lock:
            if self._wanted.get(layer, (None,))[0] is not key:
                return
            self._shown[layer] = key
            before = self._nodes.pop(layer, None)
            if picture is None:
                if before is not None:
                    before.remove()
                return
            grid = world.base
            x, y, yaw = grid.origin
            middle = rotation(yaw) @ np.array(grid.size) / 2.0 + (x, y)
            low = 0.0 if world.terrain is None else float(world.terrain.height.max())
            self._nodes[layer] = self._server.scene.add_image(
                f"/fields/{layer.replace(' ', '_')}",
                picture,
                *grid.size,
                format="png",
                position=(float(middle[0]), float(middle[1]), low + _HEIGHTS[layer]),
                wxyz=tuple(float(part) for part in rotations.about_z(yaw)),
            )
