"""The scene: ground, robots and what they are up to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from cavalcade.robots import RobotModel
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.studio.snapshot import Snapshot

Pose = tuple[float, float, float]
"""x, y in m, yaw in rad, map frame."""


class Stage:
    """All that is seen besides the panels; any thread may call it.

    Args:
        server: The page's `viser.ViserServer`.
    """

    def __init__(self, server: Any) -> None:
        self._server = server

    def set_world(self, scenario: ResolvedScenario, world: World) -> None:
        """Show the ground and all obstacles that are always there."""

    def set_team(self, models: Sequence[RobotModel], poses: Sequence[Pose]) -> None:
        """Show these robots, standing at these poses, in the place of those so far."""

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment; what has not changed is not sent again."""

    def frame_team(self) -> None:
        """Look at the whole team and its goals from above, a little from behind."""

    def clear(self) -> None:
        """Show nothing."""

    def on_ground_click(self, act: Callable[[Any, float, float], None] | None) -> None:
        """Call `act(event, x, y)` for a click on the ground, m; None: clicks are nothing."""
