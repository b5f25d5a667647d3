"""A quadruped as a rigid-body mechanism: what physics, leg control and drawing need.

Legs are in the order front left, front right, rear left, rear right. A leg has the joints hip
(about x, abduction), thigh and calf (about y); joint `3 * leg + j`. All link frames are parallel to
the trunk's when all joint angles are zero; a link's origin lies on its joint's axis.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from cavalcade.geometry import Array

LEGS = ("FL", "FR", "RL", "RR")
"""Names of the legs in their order."""

JOINTS = ("hip", "thigh", "calf")
"""Names of a leg's joints, and of the links they move, in their order."""

JOINT_NAMES = tuple(f"{leg}_{joint}_joint" for leg in LEGS for joint in JOINTS)
"""Names of the 12 joints in their order, as robots' own descriptions and ROS call them."""

LINK_NAMES = ("body", *(f"{leg}_{joint}" for leg in LEGS for joint in JOINTS))
"""Names of the 13 links' frames: the trunk's, then what each joint moves."""

PartName = Literal["trunk", "hip", "thigh", "calf", "foot"]
PARTS: tuple[PartName, ...] = ("trunk", "hip", "thigh", "calf", "foot")
"""Names of a robot's parts; contacts are told apart by them."""

ShapeKind = Literal["box", "sphere", "capsule", "cylinder"]

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Inertial:
    """A rigid body's mass, seen in a frame fixed to it.

    Attributes:
        mass: kg.
        center: Centre of mass, m.
        inertia: xx, yy, zz, xy, xz, yz in kg m² about the centre of mass, along the frame's axes.
    """

    mass: float
    center: Vector
    inertia: tuple[float, float, float, float, float, float]

    @property
    def matrix(self) -> Array:
        """Inertia `(3, 3)` about the centre of mass, kg m²."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def moved(self, offset: Vector) -> Inertial:
        """The same body seen in a parallel frame in which this frame's origin is at `offset`."""
        x, y, z = (float(a + b) for a, b in zip(self.center, offset, strict=True))
        return Inertial(self.mass, (x, y, z), self.inertia)

    def turned(self, rotation: Array) -> Inertial:
        """The same body seen in a frame with the same origin, which `rotation` `(3, 3)` leads to.

        A point p of this frame is at rotation p in that one.
        """
        x, y, z = (float(value) for value in rotation @ np.array(self.center))
        return Inertial(self.mass, (x, y, z), _moments(rotation @ self.matrix @ rotation.T))

    def mirrored(self, x: bool = False, y: bool = False) -> Inertial:
        """The mirror image with x or y (or both) the other way round."""
        sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
        xx, yy, zz, xy, xz, yz = self.inertia
        center = (sx * self.center[0], sy * self.center[1], self.center[2])
        return Inertial(self.mass, center, (xx, yy, zz, sx * sy * xy, sx * xz, sy * yz))


def combined(bodies: Iterable[Inertial]) -> Inertial:
    """One body made of several that are seen in the same frame."""
    parts = tuple(bodies)
    mass = sum(part.mass for part in parts)
    center = sum((part.mass * np.array(part.center) for part in parts), np.zeros(3)) / mass
    total = np.zeros((3, 3))
    for part in parts:
        arm = np.array(part.center) - center
        total += part.matrix + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    x, y, z = (float(value) for value in center)
    return Inertial(float(mass), (x, y, z), _moments(total))


def _moments(matrix: Array) -> tuple[float, float, float, float, float, float]:
    """xx, yy, zz, xy, xz, yz of a symmetric matrix `(3, 3)`."""
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    xx, yy, zz, xy, xz, yz = (float(value) for value in matrix[rows, columns])
    return xx, yy, zz, xy, xz, yz


@dataclass(frozen=True)
class JointDescription:
    """A hinge between a link and its parent.

    Attributes:
        offset: Its place in the parent's frame, m.
        axis: Unit vector, the same in both frames.
        lower, upper: Range of the angle, rad.
        torque: Largest magnitude, N m.
        speed: Largest magnitude, rad/s.
        damping: N m s/rad.
        friction: Dry friction, N m.
        armature: Inertia of the motor's rotor as the joint feels it (times the gear squared),
            kg m².
        stall_torque, no_load_speed: Of the motor with its gear: the torque it has at rest and
            the speed at which it has none left, N m and rad/s.
    """

    offset: Vector
    axis: Vector
    lower: float
    upper: float
    torque: float
    speed: float
    damping: float
    friction: float
    armature: float
    stall_torque: float
    no_load_speed: float


@dataclass(frozen=True)
class LegDescription:
    """One leg.

    Attributes:
        joints: Hip, thigh, calf.
        links: What each joint moves, in the link's own frame; the calf's has the foot in it.
        foot: Centre of the foot's ball in the calf's frame, m.
    """

    joints: tuple[JointDescription, JointDescription, JointDescription]
    links: tuple[Inertial, Inertial, Inertial]
    foot: Vector


@dataclass(frozen=True)
class BodyShape:
    """A primitive fixed to the trunk or to a link of a leg.

    Attributes:
        part: What it belongs to; a `foot` is fixed to its leg's calf.
        leg: 0 to 3; -1 for the trunk.
        kind: Cylinders and capsules stand along their own z axis.
        size: Half lengths along x, y, z of a box; radius and half length of a cylinder or (without
            its caps) a capsule; radius of a sphere; zeros fill up. m.
        position: Of its centre in the link's frame, m.
        rotation: Quaternion w, x, y, z from its own frame to the link's.
        color: Red, green, blue from 0 to 1.
    """

    part: PartName
    leg: int
    kind: ShapeKind
    size: Vector
    position: Vector
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    color: Vector = (0.5, 0.5, 0.5)

    @property
    def link(self) -> int:
        """Index of the link it is fixed to: 0 the trunk, `1 + 3 * leg + j` those of the legs."""
        return 0 if self.leg < 0 else 1 + 3 * self.leg + min(PARTS.index(self.part) - 1, 2)

    @property
    def turn(self) -> Array:
        """`rotation` as a matrix `(3, 3)`."""
        w, x, y, z = np.array(self.rotation) / np.linalg.norm(self.rotation)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.asarray(np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross)


@dataclass(frozen=True)
class QuadrupedDescription:
    """Masses, joints, limits and shapes of a robot with four legs.

    Attributes:
        name: Of the robot.
        trunk: With everything that is fixed to it, in the trunk's frame.
        legs: Front left, front right, rear left, rear right.
        foot_radius: m.
        stand_height: Of the trunk's origin over the ground when the robot stands, m.
        looks: What it looks like.
        solids: What touches: fewer and simpler than `looks`.
        source: Where the figures come from.
        file: A MuJoCo model that physics takes instead of making its own; "" for none.
    """

    name: str
    trunk: Inertial
    legs: tuple[LegDescription, ...]
    foot_radius: float
    stand_height: float
    looks: tuple[BodyShape, ...]
    solids: tuple[BodyShape, ...]
    source: str
    file: str = ""

    @cached_property
    def mass(self) -> float:
        """Of everything, kg."""
        return self.trunk.mass + sum(link.mass for leg in self.legs for link in leg.links)

    @cached_property
    def joints(self) -> tuple[JointDescription, ...]:
        """All 12 in their order."""
        return tuple(joint for leg in self.legs for joint in leg.joints)

    @cached_property
    def joint_offsets(self) -> Array:
        """`(4, 4, 3)` m: per leg hip, thigh, calf and foot, each in its parent's frame."""
        return _frozen([[*(joint.offset for joint in leg.joints), leg.foot] for leg in self.legs])

    @cached_property
    def torque_limits(self) -> Array:
        """`(12,)` N m."""
        return _frozen([joint.torque for joint in self.joints])

    @cached_property
    def speed_limits(self) -> Array:
        """`(12,)` rad/s."""
        return _frozen([joint.speed for joint in self.joints])

    @cached_property
    def joint_range(self) -> Array:
        """`(12, 2)` rad: lower and upper ends."""
        return _frozen([(joint.lower, joint.upper) for joint in self.joints])

    @cached_property
    def standing(self) -> Array:
        """`(12,)` rad: joint angles with the feet below the thighs' joints at `stand_height`."""
        drop = self.stand_height - self.foot_radius
        return _frozen([angle for leg in range(4) for angle in self.leg_angles(leg, drop)])

    def foot_places(self, joints: Array) -> Array:
        """Centres `(..., 4, 3)` of the feet's balls in the trunk's frame, m, at `(..., 12)` rad."""
        angles = np.reshape(joints, (*np.shape(joints)[:-1], 4, 3))
        cosines, sines = np.cos(angles), np.sin(angles)
        hip, thigh, calf, foot = np.moveaxis(self.joint_offsets, 1, 0)
        place = np.broadcast_to(foot, angles.shape)
        for joint, offset in ((2, calf), (1, thigh), (0, hip)):
            c, s = cosines[..., joint], sines[..., joint]
            x, y, z = np.moveaxis(place, -1, 0)
            about_x = (x, c * y - s * z, s * y + c * z)
            about_y = (c * x + s * z, y, c * z - s * x)
            place = offset + np.stack(about_y if joint else about_x, axis=-1)
        return np.asarray(place)

    def joints_at(self, feet: Array) -> Array:
        """Angles `(..., 12)`, rad, with the feet's centres at `(..., 4, 3)`, trunk frame, m.

        The way back from `foot_places`. Knees bend as in `standing`. A leg that does not reach
        points there as long as it can be; ranges of joints are not looked at.
        """
        hip, thigh, calf, foot = np.moveaxis(self.joint_offsets, 1, 0)
        side = thigh[:, 1] + calf[:, 1] + foot[:, 1]
        x, y, z = np.moveaxis(np.asarray(feet, dtype=float) - hip, -1, 0)
        # The hip turns the leg's plane; `down` is the foot's height in it.
        down = -np.sqrt(np.maximum(y * y + z * z - side * side, 1e-12))
        turn = np.arctan2(z, y) - np.arctan2(down, side)
        x, down = x - thigh[:, 0], down - thigh[:, 2]
        upper, lower = np.hypot(calf[:, 0], calf[:, 2]), np.hypot(foot[:, 0], foot[:, 2])
        reach = np.clip(np.hypot(x, down), np.abs(upper - lower) + 1e-6, upper + lower - 1e-6)
        bend = np.arccos((reach**2 - upper**2 - lower**2) / (2.0 * upper * lower))
        bend = np.where(np.array([leg.joints[2].lower >= 0.0 for leg in self.legs]), bend, -bend)
        lean = np.arctan2(-x, -down) - np.arctan2(
            lower * np.sin(bend), upper + lower * np.cos(bend)
        )
        # How far the bones hang from straight down when all angles are zero.
        first, second = np.arctan2(-calf[:, 0], -calf[:, 2]), np.arctan2(-foot[:, 0], -foot[:, 2])
        turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
        angles = np.stack([turn, lean - first, bend + first - second], axis=-1)
        return angles.reshape(*angles.shape[:-2], 12)

    def link_poses(self, joints: Array) -> Array:
        """Each joint's link in the link before it, `(..., 12, 7)`, at `(..., 12)` rad.

        Place in m and quaternion x, y, z, w. The link before a hip is the trunk.
        """
        half = 0.5 * np.asarray(joints, dtype=float)[..., None]
        poses = np.empty((*half.shape[:-1], 7))
        poses[..., :3] = [joint.offset for joint in self.joints]
        poses[..., 3:6] = np.sin(half) * np.array([joint.axis for joint in self.joints])
        poses[..., 6:] = np.cos(half)
        return poses

    def leg_angles(self, leg: int, drop: float) -> tuple[float, float, float]:
        """Hip, thigh and calf angles with the foot's centre straight below the thigh's joint.

        The knee points backwards unless it can only bend the other way.

        Args:
            leg: 0 to 3.
            drop: Of the foot's centre below the trunk's origin, m; cut to what the leg reaches.
        """
        foot = self.legs[leg].foot
        hip, thigh, calf = self.legs[leg].joints
        drop = drop + hip.offset[2] + thigh.offset[2]
        upper, lower = np.hypot(*calf.offset[::2]), np.hypot(*foot[::2])
        reach = min(max(drop, abs(upper - lower) + 1e-3), upper + lower - 1e-3)
        knee = np.arccos((reach**2 - upper**2 - lower**2) / (2.0 * upper * lower))
        bend = float(knee) if calf.lower >= 0.0 else -float(knee)
        bend = min(max(bend, calf.lower), calf.upper)
        lean = np.arctan2(-lower * np.sin(bend), upper + lower * np.cos(bend))
        return 0.0, float(lean), bend


def _frozen(values: object) -> Array:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
