"""Poses on the ground that can be dragged and turned by hand."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from cavalcade.geometry import Array
from cavalcade.studio.scene import rotations

Pose = tuple[float, float, float]
"""x, y in m, yaw in rad, map frame."""

Moved = Callable[[Any, Pose], None]
"""What is called when a pose has been moved: event, pose."""

_SIZE = 0.9
"""Of the handles, m."""


class PoseGizmo:
    """Handles to move a pose along x and y and to turn it about the vertical.

    Args:
        scene: `viser.SceneApi`.
        name: Of its node.
        pose: Where it stands first.
        heights: Of the ground `(N,)` at points `(N, 2)`, m.
        on_change: Called again and again while it is moved.
        on_end: Called when it is let go.
    """

    def __init__(
        self,
        scene: Any,
        name: str,
        pose: Pose,
        heights: Callable[[Array], Array],
        on_change: Moved | None = None,
        on_end: Moved | None = None,
    ) -> None:
        self._heights = heights
        self._node = scene.add_transform_controls(
            f"/gizmo/{name}",
            scale=_SIZE,
            line_width=3.0,
            active_axes=(True, True, False),
            depth_test=False,
            opacity=0.9,
        )
        self.pose = pose
        self._on_change, self._on_end = on_change, on_end
        # One after the other: a pose that comes late would be taken for the last one.
        self._aside = ThreadPoolExecutor(1, thread_name_prefix="studio-gizmo")
        self._newest: tuple[Any, Pose] | None = None
        self._node.on_update(self._moved)

    @property
    def pose(self) -> Pose:
        """Where it is."""
        (x, y, _), (w, *_, z) = self._node.position, self._node.wxyz
        yaw = 2.0 * np.arctan2(z, w)
        return float(x), float(y), float((yaw + np.pi) % (2.0 * np.pi) - np.pi)

    @pose.setter
    def pose(self, pose: Pose) -> None:
        x, y, yaw = pose
        height = float(self._heights(np.array([[x, y]]))[0]) + 0.06
        self._node.position = (x, y, height)
        self._node.wxyz = tuple(float(part) for part in rotations.about_z(yaw))

    def remove(self) -> None:
        """Take it away."""
        self._node.remove()
        self._aside.shutdown(wait=False)

    async def _moved(self, event: Any) -> None:
        """Events come in their order here; what they lead to may take its time."""
        if event.phase == "update" and self._on_change is not None:
            waits, self._newest = self._newest is not None, (event, self.pose)
            if not waits:
                self._aside.submit(self._tell, self._on_change)
        elif event.phase == "end" and self._on_end is not None:
            self._aside.submit(self._on_end, event, self.pose)

    def _tell(self, act: Moved) -> None:
        """Only the newest pose counts."""
        newest, self._newest = self._newest, None
        if newest is not None:
            act(*newest)
