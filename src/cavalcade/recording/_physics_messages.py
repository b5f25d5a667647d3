"""The messages of a recording in physics: joints, bodies and forces on feet.

- `/robot_k/body`, geometry_msgs/PoseStamped: the trunk's frame in the map, three-dimensional.
- `/robot_k/joint_states`, sensor_msgs/JointState: joints `FL_hip` to `RR_calf`; the effort is the
  torque of largest magnitude since the message before.
- `/robot_k/foot_force/FL` and so on, geometry_msgs/WrenchStamped: mean contact force since the
  message before, in the frame `robot_k/FL_foot`, at the foot with the axes of the map.
- `/cavalcade/contacts`, std_msgs/String, JSON `{"time", "robot", "part", "other"}`: every contact
  but feet on the ground, said anew while it lasts.
- `/cavalcade/falls`, std_msgs/String, JSON `{"time", "robot"}`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.recording.cdr import Layout, spatial_poses, stamps_of
from cavalcade.robots import JOINTS, LEGS

Stamps = NDArray[np.int64]
"""Times `(M,)` in ns."""

JOINT_NAMES = tuple(f"{leg}_{joint}" for leg in LEGS for joint in JOINTS)

CONTACTS_TOPIC = "/cavalcade/contacts"
FALLS_TOPIC = "/cavalcade/falls"


def body_topic(robot: int) -> str:
    """Of a trunk's poses."""
    return f"/robot_{robot}/body"


def joints_topic(robot: int) -> str:
    """Of a robot's joints."""
    return f"/robot_{robot}/joint_states"


def force_topic(robot: int, leg: int) -> str:
    """Of the forces on a foot."""
    return f"/robot_{robot}/foot_force/{LEGS[leg]}"


def body_layout() -> Layout:
    """geometry_msgs/PoseStamped with columns `stamp` and `pose`, position and quaternion x to w."""
    return Layout().header("map").numbers("pose", "f8", 7)


def joints_layout(robot: int) -> Layout:
    """sensor_msgs/JointState with columns `stamp`, `position`, `velocity` and `effort`."""
    layout = Layout().header(f"robot_{robot}/base").constant("u4", len(JOINT_NAMES))
    for name in JOINT_NAMES:
        layout.text(name)
    for column in ("position", "velocity", "effort"):
        layout.constant("u4", len(JOINT_NAMES)).numbers(column, "f8", len(JOINT_NAMES))
    return layout


def force_layout(robot: int, leg: int) -> Layout:
    """geometry_msgs/WrenchStamped with columns `stamp` and `wrench`, force and torque."""
    return Layout().header(f"robot_{robot}/{LEGS[leg]}_foot").numbers("wrench", "f8", 6)


def body_messages(times: Stamps, base: Array) -> list[memoryview]:
    """Trunks `(M, 7)`: position and quaternion w, x, y, z."""
    return body_layout().pack(len(times), stamp=stamps_of(times), pose=spatial_poses(base))


def joints_messages(
    times: Stamps, joints: Array, rates: Array, torques: Array, robot: int
) -> list[memoryview]:
    """Joints of one robot, each `(M, 12)`: rad, rad/s, N m."""
    return joints_layout(robot).pack(
        len(times), stamp=stamps_of(times), position=joints, velocity=rates, effort=torques
    )


def force_messages(times: Stamps, forces: Array, robot: int, leg: int) -> list[memoryview]:
    """Forces `(M, 3)` on a foot, N, along the map's axes."""
    wrench = np.zeros((len(times), 6))
    wrench[:, :3] = forces
    return force_layout(robot, leg).pack(len(times), stamp=stamps_of(times), wrench=wrench)
