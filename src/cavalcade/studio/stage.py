"""The scene: ground, robots and what they are up to."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cavalcade.robots import RobotModel
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.studio.actors import Robots
from cavalcade.studio.ground import Ground, Pick
from cavalcade.studio.palette import DARK
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import shape_from_mapping

Pose = tuple[float, float, float]
"""x, y in m, yaw in rad, map frame."""


class Stage:
    """All that is seen besides the panels; any thread may call it.

    Args:
        server: The page's `viser.ViserServer`.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        self._lock = threading.RLock()
        self._ground = Ground(server.scene, DARK, self._picked)
        self._robots = Robots(server.scene, DARK, self._ground.heights_at, self._picked)
        self._on_pick: Pick | None = None
        self._on_ground: Callable[[Any, float, float], None] | None = None
        self._ground_callback: Callable[[Any], None] | None = None
        self._looked_at = np.zeros((1, 2))
        server.scene.set_up_direction("+z")

    def set_world(self, scenario: ResolvedScenario, world: World) -> None:
        """Show the ground and all obstacles that are always there."""
        with self._lock, self._server.atomic():
            self._ground.show(world)
            self._ground.show_obstacles("obstacle", world.shapes)

    def set_team(self, models: Sequence[RobotModel], poses: Sequence[Pose]) -> None:
        """Show these robots, standing at these poses, in the place of those so far."""
        with self._lock, self._server.atomic():
            self._robots.set(models)
            self.show(Snapshot(0.0, np.array(poses, dtype=float).reshape(-1, 3)))

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment; what has not changed is not sent again."""
        shapes = [shape_from_mapping(obstacle.to_dict()) for obstacle in snapshot.obstacles]
        with self._lock, self._server.atomic():
            self._robots.show(snapshot)
            self._ground.show_obstacles("mover", shapes)
            self._looked_at = snapshot.poses[:, :2]

    def frame_team(self) -> None:
        """Look at the whole team and its goals from above, a little from behind."""
        with self._lock:
            points = self._looked_at if len(self._looked_at) else np.zeros((1, 2))
            middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
            far = 1.4 * max(4.0, float(np.ptp(points, axis=0).max()))
            eye = (float(middle[0]), float(middle[1] - 0.7 * far), 0.8 * far)
            target = (float(middle[0]), float(middle[1]), 0.0)
            camera = self._server.initial_camera
            camera.position, camera.look_at = eye, target
            for client in self._server.get_clients().values():
                client.camera.position, client.camera.look_at = eye, target

    def clear(self) -> None:
        """Show nothing."""
        with self._lock, self._server.atomic():
            self._robots.clear()
            self._ground.clear()

    def on_pick(self, act: Pick | None) -> None:
        """Call `act(event, kind, index)` for a click on something; None: such clicks are nothing.

        Kinds are `robot`, `obstacle` (index as in `World.shapes`) and `mover` (as in
        `Snapshot.obstacles`).
        """
        self._on_pick = act

    def on_ground_click(self, act: Callable[[Any, float, float], None] | None) -> None:
        """Call `act(event, x, y)` for a click on the ground, m; None: clicks are nothing."""
        with self._lock:
            self._on_ground = act
            if act is None and self._ground_callback is not None:
                self._server.scene.remove_click_callback(self._ground_callback)
                self._ground_callback = None
            elif act is not None and self._ground_callback is None:
                self._ground_callback = self._server.scene.on_click()(self._clicked)

    def _clicked(self, event: Any) -> None:
        place = self._ground.meet(np.array(event.ray_origin), np.array(event.ray_direction))
        if self._on_ground is not None and place is not None:
            self._on_ground(event, *place)

    def _picked(self, event: Any, kind: str, index: int) -> None:
        if self._on_pick is not None:
            self._on_pick(event, kind, index)
