"""Where a robot's parts are, from its recorded trunk and joints: forward kinematics of our own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.ground import Floor
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import about, turns
from cavalcade.geometry import Array
from cavalcade.robots.description import QuadrupedDescription

CALVES = np.array([3, 6, 9, 12])
"""Links that have the feet."""


@dataclass(frozen=True, eq=False)
class Posture:
    """All links of one robot over its samples; link 0 is the trunk, `1 + 3 * leg + j` a leg's.

    Attributes:
        time: `(T,)` s.
        place: `(T, 13, 3)` origins of the links in the map frame, m.
        turn: `(T, 13, 3, 3)` their rotations, link to map.
        axes: `(T, 12, 3)` of the joints in the map frame; a joint's place is its link's origin.
        feet: `(T, 4, 3)` centres of the feet's balls, m.
        radius: Of these, m.
        normals: `(T, 4, 3)` of the ground below the feet.
        even: `(T, 4)` whether that has one normal there.
        mass: `(13,)` kg.
        centers: `(T, 13, 3)` centres of mass, m.
        inertia: `(13, 3, 3)` about them, in the links' frames, kg m².
    """

    time: Array
    place: Array
    turn: Array
    axes: Array
    feet: Array
    radius: float
    normals: Array
    even: NDArray[np.bool_]
    mass: Array
    centers: Array
    inertia: Array

    @cached_property
    def soles(self) -> Array:
        """Where the feet touch the ground, or would, `(T, 4, 3)` m."""
        return self.feet - self.radius * self.normals

    @cached_property
    def weight(self) -> float:
        """Mass of everything, kg."""
        return float(self.mass.sum())

    @cached_property
    def center(self) -> Array:
        """Centre of mass `(T, 3)` of the whole robot, m."""
        return np.einsum("l,tlx->tx", self.mass, self.centers) / self.weight

    @cached_property
    def velocity(self) -> Array:
        """Mean velocity `(T - 1, 3)` of the centre of mass between samples, m/s."""
        return np.diff(self.center, axis=0) / np.diff(self.time)[:, None]

    @cached_property
    def spin(self) -> Array:
        """Mean angular momentum `(T - 1, 3)` about the centre of mass between samples, N m s."""
        step = np.diff(self.time)[:, None, None]
        speed = np.diff(self.centers, axis=0) / step - self.velocity[:, None]
        arm = middles(self.centers) - middles(self.center)[:, None]
        orbit = np.einsum("l,tlx->tx", self.mass, np.cross(arm, speed))
        # A rotation in the middle of an interval, near enough: the inertia of one of its ends.
        own = np.zeros_like(orbit)
        rate = turns(self.turn) / step
        for turn in (self.turn[:-1], self.turn[1:]):
            local = np.einsum("tlyx,tly->tlx", turn, rate)
            own += 0.5 * np.einsum("tlxy,lyz,tlz->tx", turn, self.inertia, local)
        return orbit + own


def posture(
    record: RobotRecord,
    description: QuadrupedDescription,
    mass_scale: float = 1.0,
    floor: Floor | None = None,
) -> Posture:
    """The links of a robot at its samples, on level ground by default.

    Masses and inertias are `mass_scale` times those of the description.
    """
    floor = floor or Floor()
    count = len(record.time)
    place = np.empty((count, 13, 3))
    turn = np.empty((count, 13, 3, 3))
    axes = np.empty((count, 12, 3))
    feet = np.empty((count, 4, 3))
    place[:, 0], turn[:, 0] = record.base[:, :3], record.turn
    links = [description.trunk]
    for number, leg in enumerate(description.legs):
        parent = 0
        for j, joint in enumerate(leg.joints):
            link = 1 + 3 * number + j
            axis = np.array(joint.axis, dtype=float)
            place[:, link] = place[:, parent] + turn[:, parent] @ np.array(joint.offset)
            turn[:, link] = turn[:, parent] @ about(axis, record.joints[:, link - 1])
            axes[:, link - 1] = turn[:, link] @ axis
            parent = link
        feet[:, number] = place[:, parent] + turn[:, parent] @ np.array(leg.foot)
        links += leg.links
    local = np.array([link.center for link in links])
    return Posture(
        record.time,
        place,
        turn,
        axes,
        feet,
        description.foot_radius,
        floor.normals_at(feet[..., :2], description.foot_radius),
        floor.even_at(feet[..., :2], description.foot_radius),
        mass_scale * np.array([link.mass for link in links]),
        place + np.einsum("tlxy,ly->tlx", turn, local),
        mass_scale * np.array([link.matrix for link in links]),
    )


def middles(values: Array) -> Array:
    """Values `(T - 1, ...)` in the middle of each interval between `(T, ...)`."""
    return 0.5 * (values[1:] + values[:-1])
