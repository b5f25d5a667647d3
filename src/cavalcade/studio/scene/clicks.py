"""Clicks into the scene: what they hit, a thing or the ground."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np

from cavalcade.geometry import Array

Pick = Callable[[Any, str, int], None]
"""What is called for a click on something: event, kind, index."""

GroundClick = Callable[[Any, float, float], None]
"""What is called for a click on the ground: event, x, y in m, map frame."""

_SAME = 1e-3
"""Clicks whose places on the screen (0 to 1) differ by less are one."""


class Clicks:
    """Passes clicks on; the page tells one on a thing twice, first of it, then of the scene.

    Args:
        scene: `viser.SceneApi`.
        meet: Where a ray, given by origin and direction, meets the ground; None for nowhere.
    """

    def __init__(
        self, scene: Any, meet: Callable[[Array, Array], tuple[float, float] | None]
    ) -> None:
        self._scene, self._meet = scene, meet
        self._ground: GroundClick | None = None
        self._last: tuple[int, tuple[float, float]] | None = None
        self.pick: Pick | None = None

    def on_ground(self, act: GroundClick | None) -> None:
        """Call this for clicks on the ground; None: they are nothing."""
        before, self._ground = self._ground, act
        if act is None and before is not None:
            self._scene.remove_click_callback(self._clicked)
        elif act is not None and before is None:
            self._scene.on_click()(self._clicked)

    def on_thing(self, kind: str, index: Callable[[int], int]) -> Callable[[Any], Awaitable[None]]:
        """A callback of a node of that kind; `index` tells instances' indices."""

        # Callbacks of this sort are called in the order of the page's messages; what they lead to
        # runs in a thread, as it may take its time.
        async def clicked(event: Any) -> None:
            self._last = (event.client_id, event.screen_pos)
            act = self.pick
            if act is not None:
                _aside(act, event, kind, index(event.instance_index or 0))

        return clicked

    async def _clicked(self, event: Any) -> None:
        last, self._last = self._last, None
        act = self._ground
        if act is None or (last is not None and self._same(last, event)):
            return
        place = self._meet(np.array(event.ray_origin), np.array(event.ray_direction))
        if place is not None:
            _aside(act, event, *place)

    @staticmethod
    def _same(last: tuple[int, tuple[float, float]], event: Any) -> bool:
        client, place = last
        away = np.abs(np.subtract(place, event.screen_pos)).max()
        return bool(client == event.client_id and away < _SAME)


def _aside(act: Callable[..., None], *arguments: Any) -> None:
    asyncio.get_running_loop().run_in_executor(None, lambda: act(*arguments))
