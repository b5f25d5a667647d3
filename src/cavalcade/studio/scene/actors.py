"""The robots of the scene: bodies with legs, what they cover of the ground, who leads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cavalcade.drawing.outlines import body_ring
from cavalcade.geometry import Array
from cavalcade.robots import BodyShape, QuadrupedDescription, RobotModel, body_of
from cavalcade.studio.scene import meshes, rotations
from cavalcade.studio.scene.batch import Batch
from cavalcade.studio.scene.clicks import Clicks
from cavalcade.studio.scene.gait import Trot
from cavalcade.studio.scene.meshes import Mesh
from cavalcade.studio.scene.palette import Palette
from cavalcade.studio.snapshot import Snapshot

_BRIGHT = 0.4
"""What is brighter than this on a robot is painted in its colour."""

_SWING = 0.06
"""How high feet are lifted by robots without figures for it, m."""


class Robots:
    """A team in the scene.

    Args:
        scene: `viser.SceneApi`.
        palette: Its colours.
        heights: Of the ground `(N,)` at points `(N, 2)`, m.
        clicks: Where clicks on robots go.
    """

    def __init__(
        self, scene: Any, palette: Palette, heights: Callable[[Array], Array], clicks: Clicks
    ) -> None:
        self._scene, self._palette, self._heights, self._clicks = scene, palette, heights, clicks
        self._clickable = False
        self._kinds: list[_Kind] = []
        self._star = Batch(scene, "/leader", meshes.star(0.17, 0.03), flat_shading=True)
        self._models: tuple[RobotModel, ...] = ()

    @property
    def models(self) -> tuple[RobotModel, ...]:
        """Who they are."""
        return self._models

    def set(self, models: Sequence[RobotModel]) -> None:
        """Show these from the next moment on."""
        self.clear()
        self._models = tuple(models)
        for number, model in enumerate(dict.fromkeys(models)):
            members = np.array([k for k, other in enumerate(models) if other == model])
            name, heights = f"/robots/{number}", self._heights
            kind = _Kind(self._scene, name, model, members, heights, self._clicks)
            kind.set_clickable(self._clickable)
            self._kinds.append(kind)

    def set_clickable(self, clickable: bool) -> None:
        """Whether clicks on them are told."""
        self._clickable = clickable
        for kind in self._kinds:
            kind.set_clickable(clickable)

    def rest(self) -> None:
        """Have them stand with the next moment, wherever they have been."""
        for kind in self._kinds:
            kind.rest()

    def recolor(self, palette: Palette) -> None:
        """Other colours from the next moment on."""
        self._palette = palette

    def show(self, snapshot: Snapshot) -> None:
        """Show a moment."""
        tops = np.zeros((len(self._models), 3))
        for kind in self._kinds:
            tops[kind.members] = kind.show(snapshot, self._palette)
        leader = -1 if snapshot.status is None else snapshot.status.leader
        led = [leader] if 0 <= leader < len(tops) and leader not in snapshot.lost else []
        self._star.show(
            tops[led] + (0.0, 0.0, 0.12),
            rotations.about_z(snapshot.poses[led, 2]),
            np.tile(self._palette.star, (len(led), 1)),
        )

    def clear(self) -> None:
        """Take them away."""
        for kind in self._kinds:
            kind.remove()
        self._kinds.clear()
        self._star.remove()
        self._models = ()


class _Kind:
    """All robots of one model; each of their parts is one batch."""

    def __init__(
        self,
        scene: Any,
        name: str,
        model: RobotModel,
        members: Array,
        heights: Callable[[Array], Array],
        clicks: Clicks,
    ) -> None:
        self.members = members
        self._model, self._heights = model, heights
        self._body = body_of(model)
        self._parts: list[tuple[Batch, Array, bool]] = []
        self._trot: Trot | None = None
        self.rest()
        for number, (mesh, links, painted) in enumerate(_parts(model, self._body)):
            robots = np.repeat(members, len(links))
            clicked = clicks.on_thing("robot", robots.__getitem__)
            batch = Batch(scene, f"{name}/{number}", mesh, clicked)
            self._parts.append((batch, np.array(links), painted))

    def show(self, snapshot: Snapshot, palette: Palette) -> Array:
        """Show a moment; returns where the bodies' tops are, `(N, 3)`."""
        poses = snapshot.poses[self.members]
        if self._body is None:
            ground = self._heights(poses[:, :2])
            places = np.column_stack([poses[:, :2], ground])[:, None]
            turns = rotations.about_z(poses[:, 2])[:, None]
            top = self._model.height
        else:
            places, turns = self._links(snapshot, poses, self._body)
            top = 0.5 * (self._model.legs.trunk_height if self._model.legs else 0.1)
        gone = np.isin(self.members, snapshot.lost)
        paints = np.array([palette.robot(int(k)) for k in self.members], dtype=float)
        dark = np.tile(np.array(palette.leg, dtype=float), (len(paints), 1))
        # Those that are no part of the team are pale.
        paints[gone] = 0.35 * paints[gone] + 0.65 * np.array(palette.soft)
        for batch, links, painted in self._parts:
            colors = np.repeat(paints if painted else dark, len(links), axis=0)
            batch.show(places[:, links].reshape(-1, 3), turns[:, links].reshape(-1, 4), colors)
        return np.asarray(places[:, 0] + (0.0, 0.0, top))

    def rest(self) -> None:
        if self._body is not None:
            places = self._body.foot_places(self._body.standing)[:, :2]
            legs = self._model.legs
            self._trot = Trot(places, _SWING if legs is None else legs.swing_height)

    def set_clickable(self, clickable: bool) -> None:
        for batch, _, _ in self._parts:
            batch.clickable = clickable

    def remove(self) -> None:
        for batch, _, _ in self._parts:
            batch.remove()

    def _links(
        self, snapshot: Snapshot, poses: Array, body: QuadrupedDescription
    ) -> tuple[Array, Array]:
        """Places `(N, 13, 3)` and turns `(N, 13, 4)` of all links."""
        if snapshot.trunks is None:
            trunk, turn = self._standing(poses, body)
        else:
            said = snapshot.trunks[self.members]
            trunk, turn = said[:, :3], said[:, [6, 3, 4, 5]]
        joints = self._joints(snapshot, poses, body, trunk, turn)
        local = body.link_poses(joints).reshape(len(poses), 4, 3, 7)
        place, way = trunk[:, None], turn[:, None]
        places, turns = [], []
        for joint in range(3):
            place = place + rotations.turned(way, local[:, :, joint, :3])
            way = rotations.product(way, local[:, :, joint][..., [6, 3, 4, 5]])
            places.append(place)
            turns.append(way)
        legs = np.stack(places, axis=2).reshape(len(poses), 12, 3)
        ways = np.stack(turns, axis=2).reshape(len(poses), 12, 4)
        return (
            np.concatenate([trunk[:, None], legs], axis=1),
            np.concatenate([turn[:, None], ways], axis=1),
        )

    def _standing(self, poses: Array, body: QuadrupedDescription) -> tuple[Array, Array]:
        """Trunks as they stand on the ground below, along its slope."""
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = np.abs(body.foot_places(body.standing)[0, :2])
        corners = np.array([(x, y), (x, -y), (-x, y), (-x, -y)])
        around = poses[:, None, :2] + np.stack(
            [
                c[:, None] * corners[:, 0] - s[:, None] * corners[:, 1],
                s[:, None] * corners[:, 0] + c[:, None] * corners[:, 1],
            ],
            axis=-1,
        )
        ground = self._heights(around.reshape(-1, 2)).reshape(-1, 4)
        place = np.column_stack([poses[:, :2], ground.mean(axis=1) + body.stand_height])
        rise = (ground[:, 0] + ground[:, 1] - ground[:, 2] - ground[:, 3]) / (4.0 * x)
        bank = (ground[:, 0] + ground[:, 2] - ground[:, 1] - ground[:, 3]) / (4.0 * y)
        return place, rotations.from_axes(
            np.column_stack([c, s, rise]), np.column_stack([-s, c, bank])
        )

    def _joints(
        self,
        snapshot: Snapshot,
        poses: Array,
        body: QuadrupedDescription,
        trunk: Array,
        turn: Array,
    ) -> Array:
        """Angles `(N, 12)`: those that are told, else what a trot asks for."""
        told = [None if snapshot.joints is None else snapshot.joints[k] for k in self.members]
        if any(joints is None for joints in told):
            assert self._trot is not None
            feet, lifted = self._trot.step(snapshot.time, poses)
            ground = self._heights(feet.reshape(-1, 2)).reshape(-1, 4)
            height = ground + lifted + body.foot_radius
            arm = np.concatenate([feet, height[..., None]], axis=-1) - trunk[:, None]
            angles = body.joints_at(rotations.turned(rotations.inverse(turn)[:, None], arm))
        else:
            angles = np.zeros((len(poses), 12))
        for k, joints in enumerate(told):
            if joints is not None:
                angles[k] = joints
        return angles


def _parts(
    model: RobotModel, body: QuadrupedDescription | None
) -> list[tuple[Mesh, tuple[int, ...], bool]]:
    """What robots of a model consist of: a mesh, the links it is fixed to, whether it is painted.

    The same mesh on several links is one part: there are the fewer messages.
    """
    if body is None:
        return [(_base(model), (0,), True), (_nose(model), (0,), False)]
    shapes: dict[tuple[int, bool], list[BodyShape]] = {}
    for shape in body.looks or body.solids:
        painted = max(shape.color) > _BRIGHT and not _is_tinted(shape)
        shapes.setdefault((shape.link, painted), []).append(shape)
    found: dict[tuple[bytes, bool], tuple[Mesh, list[int]]] = {}
    for (link, painted), those in shapes.items():
        mesh = meshes.joined(meshes.body_shape(shape) for shape in those)
        key = (np.round(mesh.vertices, 4).tobytes(), painted)
        found.setdefault(key, (mesh, []))[1].append(link)
    return [(mesh, tuple(links), painted) for (_, painted), (mesh, links) in found.items()]


def _is_tinted(shape: BodyShape) -> bool:
    """Whether it has a colour of its own, as a face has."""
    return max(shape.color) - min(shape.color) > 0.25


def _base(model: RobotModel) -> Mesh:
    """A robot without legs."""
    outline = body_ring(np.zeros(3), model)
    return meshes.prism(outline, 0.03, model.height)


def _nose(model: RobotModel) -> Mesh:
    """Where its front is."""
    x, y = 0.45 * model.length, 0.4 * model.width
    outline = np.array([(x, 0.0), (0.4 * x, y), (0.4 * x, -y)])
    return meshes.prism(outline, model.height, model.height + 0.015)
