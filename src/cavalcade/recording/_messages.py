"""The messages of a recording, each kind with its layout on the wire.

`/robot_k/robot_description`, std_msgs/String, is the robot's URDF with the links `robot_k/body`,
`robot_k/FL_hip` and so on, which are frames of `/tf` and `/tf_static`: RViz and Foxglove draw links
where the frames of their names are. Robots of one link have `robot_k/base`. Joints, which nobody
looks up across robots, are called `FL_hip_joint` with all.

The tree is `map` > `robot_k/base`, put down on the plane > `robot_k/body`, the trunk > per leg hip,
thigh, calf > foot, which is fixed. Without physics legs stand, and only the base moves.

In physics there are also:

- `/robot_k/body`, geometry_msgs/PoseStamped: the trunk's frame in the map, three-dimensional.
- `/robot_k/joint_states`, sensor_msgs/JointState: joints `FL_hip_joint` to `RR_calf_joint`; the
  effort is the torque of largest magnitude since the message before.
- `/robot_k/foot_force/FL` and so on, geometry_msgs/WrenchStamped: mean contact force since the
  message before, in the frame `robot_k/FL_contact`, at the foot with the axes of the map.
- `/cavalcade/contacts`, std_msgs/String, JSON `{"time", "robot", "part", "other"}`: every contact
  but feet on the ground, said anew while it lasts.
- `/cavalcade/falls`, std_msgs/String, JSON `{"time", "robot"}`.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.geometry import Array
from cavalcade.recording.cdr import ENCAPSULATION, Layout, planar_poses, stamps_of
from cavalcade.recording.colors import NO_SLOT, SLOT_COLORS
from cavalcade.recording.physics_track import yaw_of
from cavalcade.robots import (
    JOINT_NAMES,
    LEGS,
    LINK_NAMES,
    QuadrupedDescription,
    RobotModel,
)
from cavalcade.world import OccupancyMap

Stamps = NDArray[np.int64]
"""Times `(M,)` in ns."""

Transform = tuple[str, str, Array]
"""Parent, child, and the child's poses in it `(M, 7)`: position, quaternion x, y, z, w."""

FRAME = "map"

STATUS_TOPIC = "/cavalcade/status"
"""std_msgs/String, JSON: the planner's status of every cycle (see `status.StatusEncoder`)."""

NOTES_TOPIC = "/cavalcade/notes"
"""std_msgs/String, JSON `{"time", "text"}`: events and faults."""

OBSTACLES_TOPIC = "/cavalcade/obstacles"
"""std_msgs/String, JSON: the obstacle tracks, once."""

CONTACTS_TOPIC, FALLS_TOPIC = "/cavalcade/contacts", "/cavalcade/falls"

JOINT_COLUMNS = {"position": "joints", "velocity": "joint_rates", "effort": "torques"}
"""Columns of sensor_msgs/JointState, and what they are called in a track."""

POSE = Layout().header(FRAME).numbers("pose", "f8", 7)
"""geometry_msgs/PoseStamped with columns `stamp` and `pose`, position and quaternion x to w."""

_CUBE, _SPHERE, _LINE_LIST = 1, 2, 5
_ADD, _DELETE = 0, 2


def topics_of(robots: int, bodies: int, described: int) -> dict[str, str]:
    """Topics of a recording of so many robots, and their types.

    `bodies` of them are in physics, `described` have a description.
    """
    kinds = {
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        "/markers": "visualization_msgs/msg/MarkerArray",
        **dict.fromkeys((STATUS_TOPIC, NOTES_TOPIC, OBSTACLES_TOPIC), "std_msgs/msg/String"),
    }
    for k in range(robots):
        kinds |= {
            f"/robot_{k}/pose": "geometry_msgs/msg/PoseStamped",
            f"/robot_{k}/pose_estimated": "geometry_msgs/msg/PoseStamped",
            f"/robot_{k}/cmd_vel": "geometry_msgs/msg/TwistStamped",
            f"/robot_{k}/path": "nav_msgs/msg/Path",
        }
    for k in range(described):
        kinds[f"/robot_{k}/robot_description"] = "std_msgs/msg/String"
    if bodies:
        kinds |= dict.fromkeys((CONTACTS_TOPIC, FALLS_TOPIC), "std_msgs/msg/String")
    for k in range(bodies):
        kinds |= {
            f"/robot_{k}/body": "geometry_msgs/msg/PoseStamped",
            f"/robot_{k}/joint_states": "sensor_msgs/msg/JointState",
            **{f"/robot_{k}/foot_force/{leg}": "geometry_msgs/msg/WrenchStamped" for leg in LEGS},
        }
    return kinds


def latched(described: int) -> set[str]:
    """Topics whose last message late subscribers get, too."""
    descriptions = {f"/robot_{k}/robot_description" for k in range(described)}
    return {"/map", "/tf_static", OBSTACLES_TOPIC} | descriptions


def base_frame(robot: int) -> str:
    """The body frame of a robot."""
    return f"robot_{robot}/base"


def contact_frame(robot: int, leg: str) -> str:
    """The frame at a foot of a robot, with the axes of the map."""
    return f"robot_{robot}/{leg}_contact"


def twist_layout(robot: int) -> Layout:
    """geometry_msgs/TwistStamped with columns `stamp` and `twist`, linear and angular."""
    return Layout().header(base_frame(robot)).numbers("twist", "f8", 6)


def joints_layout(robot: int) -> Layout:
    """sensor_msgs/JointState with columns `stamp`, `position`, `velocity` and `effort`."""
    layout = Layout().header(base_frame(robot)).constant("u4", len(JOINT_NAMES))
    for name in JOINT_NAMES:
        layout.text(name)
    for column in JOINT_COLUMNS:
        layout.constant("u4", len(JOINT_NAMES)).numbers(column, "f8", len(JOINT_NAMES))
    return layout


def force_layout(robot: int, leg: str) -> Layout:
    """geometry_msgs/WrenchStamped with columns `stamp` and `wrench`, force and torque."""
    return Layout().header(contact_frame(robot, leg)).numbers("wrench", "f8", 6)


def string_message(text: str) -> memoryview:
    """std_msgs/String."""
    return Layout().text(text).pack(1)[0]


def string_of(data: bytes) -> str:
    """The text of a std_msgs/String.

    Raises:
        ValueError: It is not UTF-8.
    """
    return data[8:-1].decode()


def pose_messages(times: Stamps, poses: Array) -> list[memoryview]:
    """geometry_msgs/PoseStamped of one robot: times `(M,)` ns, poses `(M, 3)`."""
    return POSE.pack(len(times), stamp=stamps_of(times), pose=planar_poses(poses))


def twist_messages(times: Stamps, commands: Array, robot: int) -> list[memoryview]:
    """geometry_msgs/TwistStamped in the robot's body frame; commands `(M, 3)`."""
    twist = np.zeros((len(times), 6))
    twist[:, (0, 1, 5)] = commands
    return twist_layout(robot).pack(len(times), stamp=stamps_of(times), twist=twist)


def transform_messages(times: Stamps, frames: Sequence[Transform]) -> list[memoryview]:
    """tf2_msgs/TFMessage with all these frames at each of the times `(M,)` ns."""
    layout = Layout().constant("u4", len(frames))
    columns: dict[str, ArrayLike] = {}
    for number, (parent, child, poses) in enumerate(frames):
        layout.header(parent, f"stamp_{number}").text(child)
        layout.numbers(f"pose_{number}", "f8", 7)
        columns |= {f"stamp_{number}": stamps_of(times), f"pose_{number}": poses}
    return layout.pack(len(times), **columns)


def planar_frames(poses: Array) -> list[Transform]:
    """Every robot's base in the map; poses `(M, N, 3)`."""
    return [
        (FRAME, base_frame(robot), planar_poses(poses[:, robot])) for robot in range(poses.shape[1])
    ]


def body_frames(robot: int, base: Array) -> list[Transform]:
    """A robot's base in the map and its body in the base.

    `base` `(M, 7)` is the trunk's place and quaternion w, x, y, z in the map.
    """
    w, x, y, z = base[:, 3:].T
    yaw = yaw_of(base[:, 3:])
    c, s = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    body = np.zeros((len(base), 7))
    body[:, 2] = base[:, 2]
    body[:, 3:] = np.column_stack([c * x + s * y, c * y - s * x, c * z - s * w, c * w + s * z])
    ground = planar_poses(np.column_stack([base[:, :2], yaw]))
    return [
        (FRAME, base_frame(robot), ground),
        (base_frame(robot), f"robot_{robot}/{LINK_NAMES[0]}", body),
    ]


def link_frames(robot: int, poses: Array) -> list[Transform]:
    """The legs' links, each in the one before it; poses `(M, 12, 7)` as of `link_poses`."""
    names = [f"robot_{robot}/{link}" for link in LINK_NAMES]
    return [
        (names[number if number % 3 else 0], names[number + 1], poses[:, number])
        for number in range(len(JOINT_NAMES))
    ]


def foot_frames(robot: int, feet: Array) -> list[Transform]:
    """The feet in their calves, with the axes of these; `feet` `(M, 4, 3)`."""
    level = np.tile((0.0, 0.0, 0.0, 1.0), (len(feet), 1))
    return [
        (f"robot_{robot}/{leg}_calf", f"robot_{robot}/{leg}_foot", np.hstack([feet[:, k], level]))
        for k, leg in enumerate(LEGS)
    ]


def standing_frames(robot: int, body: QuadrupedDescription) -> list[Transform]:
    """The body in the base and the legs' links, of a robot that stands."""
    trunk = np.array([[0.0, 0.0, body.stand_height, 0.0, 0.0, 0.0, 1.0]])
    return [
        (base_frame(robot), f"robot_{robot}/{LINK_NAMES[0]}", trunk),
        *link_frames(robot, body.link_poses(body.standing[None])),
    ]


def contact_frames(robot: int, base: Array, feet: Array) -> list[Transform]:
    """At the feet, with the axes of the map, in the body.

    `base` as of `body_frames`, `feet` `(M, 4, 3)` in the trunk's frame.
    """
    level = np.column_stack([-base[:, 4:], base[:, 3]])
    return [
        (
            f"robot_{robot}/{LINK_NAMES[0]}",
            contact_frame(robot, leg),
            np.hstack([feet[:, k], level]),
        )
        for k, leg in enumerate(LEGS)
    ]


def path_message(time: int, path: Array) -> bytes:
    """nav_msgs/Path of points `(K, 2)`, each turned along the path; `time` in ns."""
    header = struct.pack("<III4s", *divmod(time, 1_000_000_000), 4, FRAME.encode() + b"\x00")
    start = ENCAPSULATION + header + struct.pack("<I", len(path))
    if not len(path):
        return start
    ahead = np.diff(path, axis=0, append=path[-1:])
    yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
    if len(path) > 1:
        yaw[-1] = yaw[-2]
    # On the wire 56 bytes of pose and 16 of the next point's header follow each other.
    rows = np.empty((len(path), 72), dtype=np.uint8)
    rows[:, :56] = planar_poses(np.column_stack([path, yaw])).view(np.uint8)
    rows[:, 56:] = np.frombuffer(header, dtype=np.uint8)
    return start + header + bytes(4) + rows.tobytes()[:-16]


def points_of(data: bytes) -> Array:
    """The points `(K, 2)` of a message that `path_message` made.

    Raises:
        ValueError: It is another one.
    """
    count = int.from_bytes(data[20:24], "little")
    rows = np.frombuffer(data[44:] + bytes(16), dtype=np.uint8)
    if len(rows) != max(72 * count, 16):
        raise ValueError(f"expected a path of {count} points")
    return rows[: 72 * count].reshape(count, 72)[:, :16].copy().view(float).reshape(count, 2)


def grid_message(time: int, grid: OccupancyMap) -> memoryview:
    """nav_msgs/OccupancyGrid; `time` in ns."""
    stamp = stamps_of(np.array([time]))
    layout = Layout().header(FRAME).numbers("loaded", "u4", 2)
    layout.constant("f4", grid.resolution).constant("u4", grid.cols, grid.rows)
    layout.numbers("origin", "f8", 7).constant("u4", grid.rows * grid.cols)
    layout.numbers("data", "i1", grid.rows * grid.cols)
    origin = planar_poses(np.array([grid.origin]))
    data = grid.grid.reshape(1, -1)
    return layout.pack(1, stamp=stamp, loaded=stamp, origin=origin, data=data)[0]


def marker_messages(
    times: Stamps,
    poses: Array,
    models: tuple[RobotModel, ...],
    roles: NDArray[np.int64],
    leaders: NDArray[np.int64],
    goals: Array,
    springs: Array,
) -> list[memoryview]:
    """visualization_msgs/MarkerArray: bodies coloured by role, the leader, goals and springs.

    Times `(M,)` in ns, poses `(M, N, 3)`, slots `(M, N)` and leaders `(M,)`, -1 without, goals
    `(M, N, 2)`, and the ends `(M, C, 2, 2)` of the springs; models for the size of the bodies.
    """
    count, robots = roles.shape
    markers = _Markers(times, 2 * robots + 2)
    colours = np.ones((count, robots, 4))
    colours[..., :3] = np.where(
        roles[..., None] < 0,
        np.array(NO_SLOT),
        np.array(SLOT_COLORS)[np.maximum(roles, 0) % len(np.array(SLOT_COLORS))],
    )
    bodies = planar_poses(poses)
    targets = planar_poses(np.concatenate([goals, np.zeros((count, robots, 1))], axis=2))
    top = np.max([model.height for model in models])
    for robot, model in enumerate(models):
        bodies[:, robot, 2] = model.height / 2.0
        size = (model.length, model.width, model.height)
        colour = colours[:, robot]
        markers.add("roles", robot, _CUBE, size, bodies[:, robot], colour)
        markers.add("goals", robot, _SPHERE, (0.12, 0.12, 0.12), targets[:, robot], colour)
    above = planar_poses(poses[np.arange(count), np.maximum(leaders, 0)])
    above[:, 2] = top + 0.15
    red, shown = np.array((*SLOT_COLORS[0], 1.0)), np.where(leaders >= 0, _ADD, _DELETE)
    markers.add("leader", 0, _SPHERE, (0.2, 0.2, 0.2), above, red, shown)
    ends = np.zeros((count, springs.shape[1] * 2, 3))
    ends[..., :2] = springs.reshape(count, -1, 2)
    ends[..., 2] = top / 2.0
    origin, grey = planar_poses(np.zeros((count, 3))), np.array((0.3, 0.3, 0.3, 0.9))
    markers.add("springs", 0, _LINE_LIST, (0.03, 0.0, 0.0), origin, grey, points=ends)
    return markers.layout.pack(count, **markers.columns)


class _Markers:
    """A visualization_msgs/MarkerArray: its layout and the columns that it is packed with."""

    def __init__(self, times: Stamps, count: int) -> None:
        self.layout = Layout().constant("u4", count)
        self.columns: dict[str, ArrayLike] = {}
        self._stamp = stamps_of(times)

    def add(
        self,
        space: str,
        number: int,
        kind: int,
        size: tuple[float, float, float],
        pose: Array,
        colour: Array,
        action: ArrayLike = _ADD,
        points: Array | None = None,
    ) -> None:
        """One marker: poses `(M, 7)`, a colour or `(M, 4)`, actions `(M,)`, points `(M, K, 3)`."""
        name, count = f"{space}_{number}", 0 if points is None else points.shape[1]
        self.columns |= {
            f"{name}_stamp": self._stamp,
            f"{name}_action": action if points is None or count else _DELETE,
            f"{name}_pose": pose,
            f"{name}_colour": colour,
        }
        layout = self.layout.header(FRAME, f"{name}_stamp").text(space)
        layout.constant("i4", number, kind)
        layout.numbers(f"{name}_action", "i4").numbers(f"{name}_pose", "f8", 7)
        layout.constant("f8", *size).numbers(f"{name}_colour", "f4", 4)
        layout.constant("u4", 0, 0).constant("u1", 0)  # lifetime for ever, frame not locked
        layout.constant("u4", count)
        if points is not None and count:
            layout.numbers(f"{name}_points", "f8", 3 * count)
            self.columns[f"{name}_points"] = points.reshape(len(points), -1)
        layout.constant("u4", 0)  # colours of single points
        layout.text("").constant("u4", 0, 0).text("").text("").constant("u4", 0)  # texture
        layout.constant("u4", 0).text("").text("").text("").constant("u4", 0)  # uv, text, mesh
        layout.constant("u1", 0)
