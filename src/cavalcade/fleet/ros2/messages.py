"""Between ROS messages and plain values: poses, velocities, stamps, paths and maps.

Functions that read take messages as they come; functions that fill set the fields of a message
that somebody made. Neither needs ROS, only objects with these fields. Poses are x, y in m and yaw
in rad, in the frame that the message names.
"""

from __future__ import annotations

import array
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import MapError
from cavalcade.geometry import Array
from cavalcade.world import OccupancyMap

Pose = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w, as messages have it."""

POSE_TYPES = {
    "PoseStamped": "geometry_msgs/msg/PoseStamped",
    "PoseWithCovarianceStamped": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "Odometry": "nav_msgs/msg/Odometry",
}
"""Messages that say where a robot is."""

VELOCITY_TYPES = {
    "Twist": "geometry_msgs/msg/Twist",
    "TwistStamped": "geometry_msgs/msg/TwistStamped",
}
"""Messages that command a robot."""

_UPRIGHT = 1e-3
"""Sine of a tilt, or length of a heading's projection, below which there is none."""

_NOWHERE = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class PoseReport:
    """Where a robot says that it is.

    Attributes:
        stamp: When that was measured, s.
        frame: In which it is given, without a leading slash.
        pose: x, y in m, yaw in rad; nan where the message has no sound number.
    """

    stamp: float
    frame: str
    pose: Pose


def yaw_of_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Heading in [-pi, pi] of the body's x axis seen from above, rad.

    The quaternion may be of any length, and the body tilted. It is nan where there is no heading:
    for the zero quaternion, numbers that are not finite, and an x axis that points straight up or
    down.
    """
    largest = max(abs(x), abs(y), abs(z), abs(w))
    if not (0.0 < largest < math.inf):  # false for nan, too
        return math.nan
    x, y, z, w = x / largest, y / largest, z / largest, w / largest
    square = x * x + y * y + z * z + w * w
    if not math.isfinite(square):
        return math.nan
    along, across = w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)
    if math.hypot(along, across) < _UPRIGHT * square:
        return math.nan
    return math.atan2(across, along)


def quaternion_of_yaw(yaw: float) -> Quaternion:
    """The unit quaternion x, y, z, w of a level body."""
    return 0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)


def seconds_of(stamp: Any) -> float:
    """A `builtin_interfaces/Time` in s."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def fill_stamp(stamp: Any, seconds: float) -> None:
    """Set a `builtin_interfaces/Time`; times before 1970 are 0, as the message has no others."""
    total = max(round(seconds * 1e9), 0)
    stamp.sec, stamp.nanosec = divmod(total, 1_000_000_000)


def read_pose(pose: Any) -> Pose:
    """A `geometry_msgs/Pose` seen from above; all of it is nan where anything of it is not."""
    place, turn = pose.position, pose.orientation
    yaw = yaw_of_quaternion(turn.x, turn.y, turn.z, turn.w)
    found = float(place.x), float(place.y), yaw
    return found if all(map(math.isfinite, found)) else _NOWHERE


def fill_pose(pose: Any, planar: Array | Pose, height: float = 0.0) -> None:
    """Set a `geometry_msgs/Pose` to x, y, yaw at a height in m."""
    x, y, yaw = (float(value) for value in planar)
    pose.position.x, pose.position.y, pose.position.z = x, y, float(height)
    turn = pose.orientation
    turn.x, turn.y, turn.z, turn.w = quaternion_of_yaw(yaw)


def fill_place(position: Any, turn: Any, place: Array) -> None:
    """Set a `geometry_msgs/Point` or `Vector3` and a `Quaternion` to x, y, z and x, y, z, w."""
    x, y, z, *quaternion = place.tolist()
    position.x, position.y, position.z = x, y, z
    turn.x, turn.y, turn.z, turn.w = quaternion


def fill_transforms(
    message: Any, seconds: float, places: Sequence[tuple[str, str, Array]], transform_type: Any
) -> None:
    """Set a `tf2_msgs/TFMessage` to parents, children and the places `(7,)` of these in those.

    `transform_type` makes a TransformStamped; those of as many frames as before are used again.
    """
    if len(message.transforms) != len(places):
        message.transforms = [transform_type() for _ in places]
    for transform, (parent, child, place) in zip(message.transforms, places, strict=True):
        fill_header(transform.header, seconds, parent)
        transform.child_frame_id = child
        fill_place(transform.transform.translation, transform.transform.rotation, place)


def fill_header(header: Any, seconds: float, frame: str) -> None:
    """Set a `std_msgs/Header`."""
    fill_stamp(header.stamp, seconds)
    header.frame_id = frame


def read_report(message: Any) -> PoseReport:
    """Of a PoseStamped, a PoseWithCovarianceStamped or an Odometry."""
    header, held = message.header, message.pose
    held = getattr(held, "pose", held)  # beside a covariance
    frame = header.frame_id.removeprefix("/")
    return PoseReport(seconds_of(header.stamp), frame, read_pose(held))


def read_transform(message: Any) -> PoseReport:
    """Of a TransformStamped: where its child is."""
    place, turn = message.transform.translation, message.transform.rotation
    pose = place.x, place.y, yaw_of_quaternion(turn.x, turn.y, turn.z, turn.w)
    return PoseReport(
        seconds_of(message.header.stamp),
        message.header.frame_id.removeprefix("/"),
        pose if all(map(math.isfinite, pose)) else _NOWHERE,
    )


def read_twist(twist: Any) -> Pose:
    """A `geometry_msgs/Twist` as vx, vy, yaw rate: m/s, m/s, rad/s."""
    return float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)


def fill_twist(twist: Any, velocity: Array | Pose) -> None:
    """Set a `geometry_msgs/Twist` to vx, vy, yaw rate."""
    vx, vy, rate = (float(value) for value in velocity)
    twist.linear.x, twist.linear.y, twist.angular.z = vx, vy, rate


def fill_path(message: Any, points: ArrayLike, pose_type: Any) -> None:
    """Set the poses of a `nav_msgs/Path` to points `(K, 2)` or poses `(K, 3)`.

    Points look ahead to the next one. Its header is set before; `pose_type` makes a PoseStamped.
    """
    poses = np.asarray(points, dtype=float)
    if poses.ndim == 2 and poses.shape[1] == 2:
        ahead = np.diff(poses, axis=0) if len(poses) > 1 else np.array([[1.0, 0.0]])
        yaws = np.arctan2(ahead[:, 1], ahead[:, 0])
        poses = np.column_stack([poses, np.append(yaws, yaws[-1:])[: len(poses)]])
    message.poses = [_stamped(message.header, pose, pose_type()) for pose in poses]


def _stamped(header: Any, pose: Array, stamped: Any) -> Any:
    stamped.header = header
    fill_pose(stamped.pose, pose)
    return stamped


def read_map(message: Any, unknown: str = "occupied") -> OccupancyMap:
    """The map that a `nav_msgs/OccupancyGrid` holds.

    Values of 65 and more are obstacles, -1 is unknown and counts as `unknown` says.

    Raises:
        MapError: It has no cells, another number of values than cells, values beyond -1 to 100,
            an origin that is tilted or not finite, or cells of no size.
    """
    info = message.info
    cells = np.array(message.data, dtype=np.int8)
    if cells.size != info.width * info.height:
        raise MapError(
            f"{cells.size} values for {info.width} x {info.height} cells", key="OccupancyGrid.data"
        )
    turn = info.origin.orientation
    tilt = math.hypot(turn.x, turn.y)
    origin = read_pose(info.origin)
    if not all(map(math.isfinite, origin)) or tilt > _UPRIGHT * math.hypot(tilt, turn.z, turn.w):
        raise MapError(
            "expected an origin with finite x and y that is turned about z alone",
            key="OccupancyGrid.info.origin",
        )
    # The message has a float of 32 bits: 0.05 is meant, not 0.0500000007.
    resolution = float(str(np.float32(info.resolution)))
    grid = cells.reshape(info.height, info.width)
    return OccupancyMap(grid, resolution, origin, unknown)  # type: ignore[arg-type]


def fill_map(message: Any, area: OccupancyMap) -> None:
    """Set a `nav_msgs/OccupancyGrid`, without its header.

    Unknown cells that count as free are written as free: the message cannot say how they count.
    """
    info = message.info
    info.resolution = area.resolution
    info.width, info.height = area.cols, area.rows
    fill_pose(info.origin, area.origin)
    grid = area.grid if area.unknown == "occupied" else np.where(area.grid < 0, 0, area.grid)
    message.data = array.array("b", np.ascontiguousarray(grid, dtype=np.int8).tobytes())
