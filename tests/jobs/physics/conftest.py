"""A made-up trot: feet that stay where they stand under bodies that go where they are told."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.robots import robot_model
from cavalcade.robots.description import QuadrupedDescription

PERIOD, DUTY, SWING = 0.5, 0.55, 0.06
OFFSETS = (0.0, 0.5, 0.5, 0.0)


def go1() -> QuadrupedDescription:
    description = robot_model("go1").description
    assert description is not None
    return description


@pytest.fixture(name="trot")
def trot_fixture():
    return trot


def trot(
    when: np.ndarray,
    poses: np.ndarray,
    heights=None,
    rate: float = 50.0,
    description: QuadrupedDescription | None = None,
) -> PhysicsTrack:
    """A track at `rate` Hz of robots that go through `poses` `(K, N, 3)` at times `when` `(K,)`."""
    robot = description or go1()
    ground = heights or (lambda points: np.zeros(len(points)))
    time = np.arange(0.0, when[-1] + 1e-9, 1.0 / rate)
    shape = (len(time), poses.shape[1])
    base, joints = np.zeros((*shape, 7)), np.zeros((*shape, 12))
    forces = np.zeros((*shape, 4, 3))
    for k in range(shape[1]):
        yaw = np.unwrap(poses[:, k, 2])

        def at(t, k=k, yaw=yaw):
            return np.column_stack(
                [np.interp(t, when, poses[:, k, 0]), np.interp(t, when, poses[:, k, 1]),
                 np.interp(t, when, yaw)]
            )  # fmt: skip

        base[:, k], joints[:, k], forces[:, k] = _one(time, at, ground, robot, 0.07 * k)
    rates = np.gradient(joints, time, axis=0)
    torques = 0.25 * robot.torque_limits * np.sin(3.0 * joints + 9.0 * rates / 20.0)
    return PhysicsTrack(time, base, joints, rates, torques, forces)


def _one(time, at, ground, robot, lag):
    pose = at(time)
    sway = 0.006 * np.sin(4.0 * np.pi * (time + lag) / PERIOD)
    base = np.zeros((len(time), 7))
    base[:, :2] = pose[:, :2]
    base[:, 2] = ground(pose[:, :2]) + robot.stand_height + sway
    roll = 0.02 * np.sin(2.0 * np.pi * (time + lag) / PERIOD)
    cr, sr, cy, sy = (f(a / 2) for a in (roll, pose[:, 2]) for f in (np.cos, np.sin))
    base[:, 3:] = np.column_stack([cr * cy, sr * cy, sr * sy, cr * sy])
    moving = np.linalg.norm(np.gradient(pose, time, axis=0), axis=1) > 0.02
    joints, forces = np.zeros((len(time), 12)), np.zeros((len(time), 4, 3))
    for leg in range(4):
        beat = (time + lag) / PERIOD + OFFSETS[leg]
        cycle, share = np.floor(beat), beat % 1.0
        here = _spot(at, ground, robot, leg, (cycle + 0.5 * DUTY - OFFSETS[leg]) * PERIOD - lag)
        there = _spot(
            at, ground, robot, leg, (cycle + 1.0 + 0.5 * DUTY - OFFSETS[leg]) * PERIOD - lag
        )
        u = np.clip((share - DUTY) / (1.0 - DUTY), 0.0, 1.0)
        smooth = u * u * (3.0 - 2.0 * u)
        foot = here + smooth[:, None] * (there - here)
        lift = np.where(moving, SWING * np.sin(np.pi * u), 0.0)
        foot[:, 2] += lift
        stands = lift < 1e-9
        forces[:, leg, 2] = stands
        joints[:, 3 * leg : 3 * leg + 3] = _inverse(robot, leg, base, foot)
    forces[:, :, 2] *= 9.81 * robot.mass / np.maximum(forces[:, :, 2].sum(axis=1), 1.0)[:, None]
    forces[:, :, 0] = 0.1 * forces[:, :, 2]
    return base, joints, forces


def _spot(at, ground, robot, leg, when):
    """The foot's centre below the thigh joint's nominal place at these times."""
    pose = at(when)
    hip, thigh = (np.array(joint.offset) for joint in robot.legs[leg].joints[:2])
    x, y = (hip + thigh)[:2]
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    place = np.column_stack([pose[:, 0] + c * x - s * y, pose[:, 1] + s * x + c * y])
    return np.column_stack([place, ground(place) + robot.foot_radius])


def _inverse(robot, leg, base, foot):
    from .link_frames import rotations

    hip, thigh, calf = robot.legs[leg].joints
    local = np.einsum("tji,tj->ti", rotations(base[:, 3:]), foot - base[:, :3]) - hip.offset
    side, upper, lower = thigh.offset[1], abs(calf.offset[2]), abs(robot.legs[leg].foot[2])
    x, y, z = local.T
    down = -np.sqrt(np.maximum(y * y + z * z - side * side, 1e-6))
    q0 = np.arctan2(z, y) - np.arctan2(down, side)
    q0 = (q0 + np.pi) % (2.0 * np.pi) - np.pi
    span = np.clip(x * x + down * down, 1e-4, (0.999 * (upper + lower)) ** 2)
    q2 = -np.arccos((span - upper**2 - lower**2) / (2.0 * upper * lower))
    q1 = np.arctan2(-x, -down) - np.arctan2(lower * np.sin(q2), upper + lower * np.cos(q2))
    return np.column_stack([q0, q1, q2])
