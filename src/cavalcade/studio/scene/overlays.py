"""What a team is up to, drawn on the ground: goals, springs, paths, commands, clearances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.outlines import body_ring, simplified
from cavalcade.geometry import Array, transform_points
from cavalcade.recording.frames import PATH_PERIOD, thinned
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.studio.scene import meshes, rotations
from cavalcade.studio.scene.batch import Batch
from cavalcade.studio.scene.meshes import Mesh
from cavalcade.studio.scene.palette import Palette
from cavalcade.studio.snapshot import Snapshot

_FOOTPRINT, _RING, _SLOT, _PATH, _MARK = 0.010, 0.014, 0.018, 0.024, 0.030
"""Heights over the ground that keep what lies on it apart, m."""

_SPRING = 0.05  # m, likewise
_LINE = 0.028
"""How wide outlines and lines are, m."""

_VEIL = 0.3
"""How much of its colour the ground below a robot takes."""

_STRETCH = 0.30
"""Springs this much longer or shorter than their slots say have the full colour."""

_PATH_POINTS = 40
_PATH_TOLERANCE = 0.008
"""By how much a drawn path may miss the planner's, m."""

_LEAST_SPEED = 0.02
"""Slower commands are no arrows, m/s and rad/s."""

_SECOND = 1.0
"""Arrows of commands are as long as the way of so many seconds."""


class Overlays:
    """Marks on the ground around a team; each kind is a layer.

    Args:
        scene: `viser.SceneApi`.
        palette: Its colours.
        heights: Of the ground `(N,)` at points `(N, 2)`, m.
    """

    LAYERS = ("footprints", "slots", "springs", "paths", "velocities", "clearances", "names")

    def __init__(self, scene: Any, palette: Palette, heights: Callable[[Array], Array]) -> None:
        self._scene, self._palette, self._heights = scene, palette, heights
        self._models: tuple[RobotModel, ...] = ()
        self._keep = 0.0
        self._prints: list[tuple[Batch, Batch, Array]] = []
        self._rings: Batch | None = None
        self._paths: tuple[Array, ...] = ()
        self._paths_time = 0.0
        self._followed: tuple[int, int, str] | None = None
        self._labels: list[Any] = []
        self._slots: list[tuple[Batch, Array]] = []
        unlit: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
        stick = meshes.box((0.5, 0.5, 0.5))
        self._lines = Batch(scene, "/paths", _line(), **unlit)
        self._springs = Batch(scene, "/springs", stick, flat_shading=True, **unlit)
        self._arrows = Batch(scene, "/velocities/shaft", _shaft(), **unlit)
        self._heads = Batch(scene, "/velocities/head", _head(), **unlit)
        self._dots = Batch(scene, "/slots/partial", meshes.turned_profile(
            np.array([(0.07, 0.0), (0.0, 0.0)]), 20), **unlit)  # fmt: skip
        self._goal = Batch(scene, "/slots/goal", _goal_arrow(), **unlit)

    def set(self, models: Sequence[RobotModel], clearance: float) -> None:
        """Draw for these robots; their centres keep twice the `clearance` from each other, m."""
        self.clear()
        self._models, self._keep = tuple(models), clearance
        for number, model in enumerate(dict.fromkeys(models)):
            members = np.array([k for k, other in enumerate(models) if other == model])
            ring = body_ring(np.zeros(3), model)
            options: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
            filled = Batch(
                self._scene,
                f"/footprints/{number}/area",
                meshes.flat(ring),
                **options,
            )
            edge = Batch(self._scene, f"/footprints/{number}/edge", _edge(ring, _LINE), **options)
            slot = Batch(self._scene, f"/slots/{number}", _ghost(ring), **options)
            self._prints.append((filled, edge, members))
            self._slots.append((slot, members))
        if clearance > 0.0:
            ring_mesh = meshes.ring(clearance, 0.012, 48)
            self._rings = Batch(
                self._scene, "/clearances", ring_mesh, cast_shadow=False, receive_shadow=False
            )

    def recolor(self, palette: Palette) -> None:
        """Other colours from the next moment on."""
        self._palette = palette
        self._followed = None

    def clear(self) -> None:
        """Take everything away."""
        for name in self.LAYERS:
            self.hide(name)
        self._prints.clear()
        self._slots.clear()
        self._rings = None
        self._models = ()

    def hide(self, layer: str) -> None:
        """Take one layer away."""
        match layer:
            case "footprints":
                for filled, edge, _ in self._prints:
                    filled.remove()
                    edge.remove()
            case "slots":
                for batch in (*(slot for slot, _ in self._slots), self._dots, self._goal):
                    batch.remove()
            case "springs":
                self._springs.remove()
            case "paths":
                self._followed = None
                self._lines.remove()
            case "velocities":
                self._arrows.remove()
                self._heads.remove()
            case "clearances":
                if self._rings is not None:
                    self._rings.remove()
            case "names":
                for label in self._labels:
                    label.remove()
                self._labels.clear()

    def show(self, layer: str, snapshot: Snapshot) -> None:
        """Show a layer of a moment."""
        status = snapshot.status
        match layer:
            case "footprints":
                self._show_footprints(snapshot)
            case "clearances":
                self._show_clearances(snapshot)
            case "velocities":
                self._show_velocities(snapshot)
            case "names":
                self._show_names(snapshot)
            case "slots" if status is not None:
                self._show_slots(snapshot, status)
            case "springs" if status is not None:
                self._show_springs(snapshot, status)
            case "paths" if status is not None:
                self._show_paths(snapshot.time, status)
            case _:
                self.hide(layer)

    def _on_ground(self, points: Array, height: float) -> Array:
        return np.column_stack([points, self._heights(points) + height])

    def _colors(self, robots: Sequence[int] | NDArray[Any]) -> Array:
        return np.array([self._palette.robot(int(k)) for k in robots], dtype=float).reshape(-1, 3)

    def _show_footprints(self, snapshot: Snapshot) -> None:
        for filled, edge, members in self._prints:
            poses = snapshot.poses[members]
            places, turns = (
                self._on_ground(poses[:, :2], _FOOTPRINT),
                rotations.about_z(poses[:, 2]),
            )
            colors = self._colors(members)
            colors[np.isin(members, snapshot.lost)] = self._palette.soft
            # A veil over the floor; truly clear ones would have to be sorted for each picture.
            veil = _VEIL * colors + (1.0 - _VEIL) * np.array(self._palette.floor)
            filled.show(places, turns, veil)
            edge.show(places, turns, colors)

    def _show_clearances(self, snapshot: Snapshot) -> None:
        if self._rings is None:
            return
        points = snapshot.poses[:, :2]
        gaps = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
        np.fill_diagonal(gaps, np.inf)
        near = gaps.min(axis=1, initial=np.inf) < 2.0 * self._keep
        colors = np.where(near[:, None], self._palette.limit, self._palette.soft)
        self._rings.show(self._on_ground(points, _RING), None, colors)

    def _show_velocities(self, snapshot: Snapshot) -> None:
        if snapshot.commands is None:
            self.hide("velocities")
            return
        commands = np.nan_to_num(snapshot.commands)
        speed = np.hypot(commands[:, 0], commands[:, 1])
        moving = np.flatnonzero(speed > _LEAST_SPEED)
        poses, length = snapshot.poses[moving], _SECOND * speed[moving]
        yaw = poses[:, 2] + np.arctan2(commands[moving, 1], commands[moving, 0])
        turns, places = rotations.about_z(yaw), self._on_ground(poses[:, :2], _MARK)
        bodies = np.array([0.5 * self._models[k].length for k in moving])
        # They begin where the body ends, or they would not be seen.
        ahead = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=-1)
        start = places + bodies[:, None] * ahead
        one = np.ones(len(moving))
        colors = np.tile(self._palette.ink, (len(moving), 1))
        self._arrows.show(start, turns, colors, np.column_stack([length, one, one]))
        self._heads.show(start + length[:, None] * ahead, turns, colors)

    def _show_names(self, snapshot: Snapshot) -> None:
        if len(self._labels) != len(snapshot.poses):
            self.hide("names")
            self._labels = [
                self._scene.add_label(
                    f"/names/{k}", str(k), anchor="center-center", font_screen_scale=0.8
                )
                for k in range(len(snapshot.poses))
            ]
        heights = self._heights(snapshot.poses[:, :2])
        for label, model, (x, y, _), z in zip(
            self._labels, self._models, snapshot.poses, heights, strict=True
        ):
            label.position = (float(x), float(y), float(z) + model.height + 0.22)

    def _show_slots(self, snapshot: Snapshot, status: PlannerStatus) -> None:
        poses, owners = final_places(status)
        soft = np.tile(np.array(self._palette.soft, dtype=float), (len(poses), 1))
        colors = np.where((owners >= 0)[:, None], self._colors(np.maximum(owners, 0)), soft)
        for number, (batch, members) in enumerate(self._slots):
            # Places that are nobody's yet are shown for robots of the first kind.
            ours = np.isin(owners, members) | ((owners < 0) & (number == 0))
            places = self._on_ground(poses[ours, :2], _SLOT)
            batch.show(places, rotations.about_z(poses[ours, 2]), colors[ours])
        busy = np.flatnonzero(np.asarray(status.roles) >= 0)
        if status.targets is not None or status.state in ("inactive", "final"):
            busy = busy[:0]
        places = self._on_ground(np.reshape(status.goals, (-1, 2))[busy], _SLOT)
        self._dots.show(places, None, self._colors(busy))
        goal = np.zeros((0, 3)) if status.goal is None else np.reshape(status.goal, (1, 3))
        self._goal.show(
            self._on_ground(goal[:, :2], _SLOT),
            rotations.about_z(goal[:, 2]),
            np.tile(self._palette.ink, (len(goal), 1)),
        )

    def _show_springs(self, snapshot: Snapshot, status: PlannerStatus) -> None:
        pairs = np.asarray(status.connections, dtype=int).reshape(-1, 2)
        roles = np.asarray(status.roles)
        pairs = pairs[(roles[pairs] >= 0).all(axis=1) & (roles[pairs] < len(status.slots)).all(1)]
        a, b = snapshot.poses[pairs[:, 0], :2], snapshot.poses[pairs[:, 1], :2]
        across = b - a
        length = np.hypot(across[:, 0], across[:, 1])
        places = np.asarray(status.slots)[roles[pairs]]
        rest = np.hypot(*(places[:, 1] - places[:, 0]).T)
        middle = self._on_ground((a + b) / 2.0, _SPRING)
        ones = np.full(len(pairs), 1.0)
        self._springs.show(
            middle,
            rotations.about_z(np.arctan2(across[:, 1], across[:, 0])),
            _spring_colors(length / np.maximum(rest, 1e-6) - 1.0, self._palette),
            np.column_stack([np.maximum(length, 1e-3), 0.03 * ones, 0.012 * ones]),
        )

    def _show_paths(self, time: float, status: PlannerStatus) -> None:
        told = (status.leader, status.waypoint, status.state)
        if self._followed == told and 0.0 <= time - self._paths_time < PATH_PERIOD:
            return
        if time == self._paths_time and self._paths is status.paths:
            return
        self._paths, self._paths_time, self._followed = status.paths, time, told
        starts, ends, robots = [np.zeros((0, 3))], [np.zeros((0, 3))], []
        for robot, path in enumerate(status.paths):
            points = simplified(thinned(np.asarray(path), _PATH_POINTS), _PATH_TOLERANCE)
            if len(points) > 1:
                line = self._on_ground(points, _PATH)
                starts.append(line[:-1])
                ends.append(line[1:])
                robots += [robot] * (len(line) - 1)
        first = np.concatenate(starts)
        across = np.concatenate(ends) - first
        length = np.linalg.norm(across, axis=1)
        self._lines.show(
            first + across / 2.0,
            rotations.along(across),
            self._colors(robots),
            np.column_stack([length + _LINE, np.full((len(length), 2), _LINE)]),
        )


def final_places(status: PlannerStatus) -> tuple[Array, NDArray[np.int64]]:
    """Poses `(K, 3)` where robots are to stand in the end, and which robot; -1 for nobody yet."""
    if status.targets is not None:
        return np.asarray(status.targets, dtype=float), np.arange(len(status.targets))
    if status.goal is None or not len(status.slots):
        return np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    places = transform_points(status.goal, status.slots)
    owners = np.full(len(places), -1, dtype=np.int64)
    roles = np.asarray(status.roles)
    taken = np.flatnonzero((roles >= 0) & (roles < len(places)))
    owners[roles[taken]] = taken
    return np.column_stack([places, np.full(len(places), status.goal[2])]), owners


def _spring_colors(stretch: Array, palette: Palette) -> Array:
    """`(C, 3)`: from short over as long as it should be to long."""
    share = np.clip(stretch / _STRETCH, -1.0, 1.0)[:, None]
    short, rest, long = (np.array(c, dtype=float) for c in palette.springs)
    return np.where(share < 0.0, rest - share * (short - rest), rest + share * (long - rest))


def _edge(ring: Array, width: float) -> Mesh:
    """An outline around a body, drawn inside of it."""
    reach = np.abs(ring).max(axis=0)
    return meshes.frame(ring, ring * (1.0 - width / reach))


def _ghost(ring: Array) -> Mesh:
    """A body's outline at its goal, with a mark where its front is."""
    x, y = np.abs(ring).max(axis=0)
    nose = np.array([(0.78 * x, 0.0), (0.35 * x, 0.55 * y), (0.35 * x, -0.55 * y)])
    return meshes.joined([_edge(ring, 1.4 * _LINE), meshes.flat(nose)])


def _line() -> Mesh:
    """One metre along x around the origin, one metre wide."""
    return meshes.flat(np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]))


def _shaft() -> Mesh:
    """One metre along x."""
    half = 0.7 * _LINE
    return meshes.flat(np.array([(0.0, -half), (1.0, -half), (1.0, half), (0.0, half)]))


def _head() -> Mesh:
    return meshes.flat(np.array([(0.14, 0.0), (0.0, 0.06), (0.0, -0.06)]))


def _goal_arrow() -> Mesh:
    """Where the middle of a formation goes, and which way it looks then."""
    shaft = np.array([(0.16, -0.02), (0.55, -0.02), (0.55, 0.02), (0.16, 0.02)])
    head = np.array([(0.75, 0.0), (0.55, 0.09), (0.55, -0.09)])
    return meshes.joined([meshes.ring(0.16, 0.035, 32), meshes.flat(shaft), meshes.flat(head)])
