"""Robots put on the ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cavalcade.fleet.mujoco.ground import PhysicsGround
from cavalcade.geometry import Array, transform_points
from cavalcade.robots.description import QuadrupedDescription


def standing_states(
    descriptions: Sequence[QuadrupedDescription], poses: Array, ground: PhysicsGround
) -> Array:
    """Generalised positions `(N, 19)` of robots that stand level with their feet on the ground.

    A foot stands below its thigh's joint; the trunk is as high over the mean of the four as the
    description says, or lower where a leg would not reach.

    Args:
        descriptions: One per robot.
        poses: `(N, 3)` x, y, yaw in the map frame, m and rad.
        ground: What they stand on.
    """
    return np.array(
        [_standing(robot, pose, ground) for robot, pose in zip(descriptions, poses, strict=True)]
    )


def _standing(robot: QuadrupedDescription, pose: Array, ground: PhysicsGround) -> Array:
    offsets = robot.joint_offsets
    places = transform_points(pose, offsets[:, 0, :2] + offsets[:, 1, :2])
    heights = ground.heights_at(places)
    trunk = min(float(heights.mean()), float(heights.min()) + 0.08) + robot.stand_height
    angles = [
        angle
        for leg in range(4)
        for angle in robot.leg_angles(leg, trunk - float(heights[leg]) - robot.foot_radius)
    ]
    half = pose[2] / 2.0
    return np.array([pose[0], pose[1], trunk, np.cos(half), 0.0, 0.0, np.sin(half), *angles])
