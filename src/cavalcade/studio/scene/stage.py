"""The scene: ground, robots and what they are up to."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.studio.scene import camera
from cavalcade.studio.scene.actors import Robots
from cavalcade.studio.scene.clearances import clearance_of
from cavalcade.studio.scene.clicks import GroundClick, Pick
from cavalcade.studio.scene.field_layers import FieldLayers
from cavalcade.studio.scene.gizmos import Moved, Pose, PoseGizmo
from cavalcade.studio.scene.ground import Ground
from cavalcade.studio.scene.intent import first_intent
from cavalcade.studio.scene.overlays import Overlays, final_places
from cavalcade.studio.scene.palette import DARK, LIGHT
from cavalcade.studio.scene.planned import Planned
from cavalcade.studio.scene.scale import Scale
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import shape_from_mapping

_SHOWN_FIRST = ("footprints", "slots", "springs", "paths", *Planned.LAYERS)
_FARTHEST_GOAL = 30.0
"""Goals farther off than this are not part of the first view, m."""


class Stage:
    """All that is seen besides the panels; any thread may call it.

    Args:
        server: The page's `viser.ViserServer`.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        self._lock = threading.RLock()
        self._palette = DARK
        scene = server.scene
        self._ground = Ground(scene, DARK)
        self._clicks = self._ground.clicks
        self._scale = Scale(scene)
        self._robots = Robots(scene, DARK, self._ground.heights_at, self._clicks)
        self._overlays = Overlays(scene, DARK, self._ground.heights_at)
        self._planned = Planned(scene, DARK)
        self._fields = FieldLayers(server, DARK)
        names = (*Overlays.LAYERS, *FieldLayers.LAYERS, *Planned.LAYERS)
        self._layers = {name: name in _SHOWN_FIRST for name in names}
        self._intent: PlannerStatus | None = None
        self._keep = 0.0
        self._scenario: ResolvedScenario | None = None
        self._world: World | None = None
        self._snapshot: Snapshot | None = None
        scene.set_up_direction("+z")

    def set_world(self, scenario: ResolvedScenario, world: World) -> None:
        """Show the ground and all obstacles that are always there."""
        with self._lock, self._server.atomic():
            self._scenario, self._world = scenario, world
            if self._ground.show(world) and self._ground.corners is not None:
                level = self._ground.terrain is None
                heights = None if level else self._ground.heights_at
                self._scale.show(self._ground.corners, self._palette, heights)
            self._ground.show_obstacles("obstacle", world.shapes)
            self._intent = first_intent(scenario)
            self._show_layers()

    def set_team(self, models: Sequence[RobotModel], poses: Sequence[Pose]) -> None:
        """Show these robots, standing at these poses, in the place of those so far."""
        keep = clearance_of(self._scenario)
        with self._lock, self._server.atomic():
            if (tuple(models), keep) != (self._robots.models, self._keep):
                self._keep = keep
                self._robots.set(models)
                self._overlays.set(models, keep)
            self._planned.clear()
            self._robots.rest()
            self.show(Snapshot(0.0, np.array(poses, dtype=float).reshape(-1, 3)))

    def set_trajectories(
        self, trajectories: Sequence[Trajectory | None], footholds: Sequence[Array] = ()
    ) -> None:
        """Show where each robot will go, and its feet, until there is another team.

        Footholds are `(M, 6)` per robot, as `PlanResult` has them.
        """
        with self._lock, self._server.atomic():
            self._planned.set(trajectories, footholds)
            self._show_layers(Planned.LAYERS)

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment; what has not changed is not sent again."""
        shapes = [shape_from_mapping(obstacle.to_dict()) for obstacle in snapshot.obstacles]
        with self._lock, self._server.atomic():
            self._snapshot = snapshot
            self._robots.show(snapshot)
            self._ground.show_obstacles("mover", shapes)
            self._show_layers((*Overlays.LAYERS, *FieldLayers.LAYERS))

    @property
    def layers(self) -> Mapping[str, bool]:
        """What may be shown besides ground and robots, and whether it is."""
        return dict(self._layers)

    def set_layer(self, name: str, visible: bool) -> None:
        """Show a layer or hide it.

        Raises:
            InputError: There is none of that name.
        """
        if name not in self._layers:
            raise InputError("there is no such layer", key="layer", choices=self._layers)
        with self._lock, self._server.atomic():
            self._layers[name] = visible
            for part in (self._overlays, self._fields, self._planned):
                if name in part.LAYERS and not visible:
                    part.hide(name)
            self._show_layers((name,))

    def set_dark(self, dark: bool) -> None:
        """Use colours for a dark page or for a light one."""
        with self._lock, self._server.atomic():
            palette = DARK if dark else LIGHT
            if palette is self._palette:
                return
            self._palette = palette
            for part in (self._ground, self._robots, self._overlays, self._planned, self._fields):
                part.recolor(palette)
            if self._scenario is not None and self._world is not None:
                self._ground.clear()
                self.set_world(self._scenario, self._world)
            if self._snapshot is not None:
                self.show(self._snapshot)
                self._show_layers(Planned.LAYERS)

    def frame_team(self) -> None:
        """Look at the whole team and its goals from above, a little from behind."""
        with self._lock:
            points = self._worth_seeing()
            height = self._ground.heights_at(points)
            low = np.column_stack([points, height])
            high = np.column_stack([points, height + 0.5])
            camera.look(self._server, *camera.view_of(np.concatenate([low, high])))

    def clear(self) -> None:
        """Show nothing."""
        with self._lock, self._server.atomic():
            for part in (self._robots, self._overlays, self._planned, self._ground, self._scale):
                part.clear()
            for name in FieldLayers.LAYERS:
                self._fields.hide(name)
            self._scenario = self._world = self._snapshot = self._intent = None

    def goal_gizmo(
        self,
        name: str,
        pose: Pose,
        on_change: Moved | None = None,
        on_end: Moved | None = None,
    ) -> PoseGizmo:
        """Handles on the ground by which a pose is moved and turned.

        `on_change(event, pose)` is called while that goes on, `on_end(event, pose)` at its end.
        """
        with self._lock:
            scene, heights = self._server.scene, self._ground.heights_at
            return PoseGizmo(scene, name, pose, heights, on_change, on_end)

    def on_pick(self, act: Pick | None) -> None:
        """Call `act(event, kind, index)` for a click on something; None: such clicks are nothing.

        Kinds are `robot`, `obstacle` (index as in `World.shapes`) and `mover` (as in
        `Snapshot.obstacles`).
        """
        with self._lock:
            self._clicks.pick = act
            self._robots.set_clickable(act is not None)
            self._ground.set_clickable(act is not None)

    def on_ground_click(self, act: GroundClick | None) -> None:
        """Call `act(event, x, y)` for a click on the ground, m; None: clicks are nothing."""
        with self._lock:
            self._clicks.on_ground(act)

    def _worth_seeing(self) -> Array:
        """Points `(N, 2)` that the first view holds."""
        bounds = self._ground.bounds
        if self._snapshot is None or not len(self._snapshot.poses):
            return np.zeros((1, 2)) if bounds is None else bounds
        team = self._snapshot.poses[:, :2]
        margin = np.array([(0.6, 0.6), (-0.6, 0.6), (0.6, -0.6), (-0.6, -0.6)])
        around = (team[:, None] + margin).reshape(-1, 2)
        status = self._snapshot.status or self._intent
        goals = np.zeros((0, 2)) if status is None else final_places(status)[0][:, :2]
        near = np.hypot(*(goals - team.mean(axis=0)).T) < _FARTHEST_GOAL
        return np.concatenate([around, goals[near]])

    def _show_layers(self, names: Sequence[str] | None = None) -> None:
        """Show what is visible of these layers, of all without any."""
        moment = self._snapshot
        if moment is not None and moment.status is None and self._intent is not None:
            moment = replace(moment, status=self._intent)
        for name in self._layers if names is None else names:
            if not self._layers[name]:
                continue
            if name in Planned.LAYERS:
                self._planned.show(name)
            elif moment is None:
                continue
            elif name in Overlays.LAYERS:
                self._overlays.show(name, moment)
            elif self._scenario is not None and self._world is not None:
                self._fields.show(name, self._scenario, self._world, moment)
