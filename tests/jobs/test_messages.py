"""Hand-packed messages, read back by rosbags' own deserialiser."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rosbags.typesys import Stores, get_typestore

from cavalcade.recording import _messages
from cavalcade.recording.cdr import Layout
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

STORE = get_typestore(Stores.ROS2_HUMBLE)
TIMES = np.array([0, 50_000_000, 12_345_678_901])
POSES = np.array([(1.0, 2.0, 0.5), (-3.0, 4.0, -3.0), (0.0, 0.0, np.pi)])


def decoded(data: Any, kind: str) -> Any:
    message = STORE.deserialize_cdr(bytes(data), kind)
    # The same content must give the same bytes, so nothing is missing at the end.
    assert bytes(STORE.serialize_cdr(message, kind)) == bytes(data)
    return message


def yaw_of(turn: Any) -> float:
    assert turn.x == turn.y == 0.0
    return float(2.0 * np.arctan2(turn.z, turn.w))


@settings(max_examples=30, deadline=None)
@given(arrays(float, (4, 3), elements=st.floats(-3.0, 3.0)), st.integers(0, 2**40))
def test_poses_survive(poses: np.ndarray, start: int) -> None:
    times = start + np.arange(4) * 50_000_000
    for k, data in enumerate(_messages.pose_messages(times, poses)):
        message = decoded(data, "geometry_msgs/msg/PoseStamped")
        stamp = message.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == times[k]
        assert message.header.frame_id == "map"
        place = message.pose.position
        assert (place.x, place.y, place.z) == (poses[k, 0], poses[k, 1], 0.0)
        assert yaw_of(message.pose.orientation) == pytest.approx(poses[k, 2], abs=1e-12)


@pytest.mark.parametrize("robot", [0, 7, 12, 345])
def test_commands_stand_in_the_body_frame(robot: int) -> None:
    for k, data in enumerate(_messages.twist_messages(TIMES, POSES, robot)):
        message = decoded(data, "geometry_msgs/msg/TwistStamped")
        assert message.header.frame_id == f"robot_{robot}/base"
        linear, angular = message.twist.linear, message.twist.angular
        assert (linear.x, linear.y, angular.z) == tuple(POSES[k])
        assert linear.z == angular.x == angular.y == 0.0


@pytest.mark.parametrize("robots", [1, 2, 12])
def test_transforms_name_every_body(robots: int) -> None:
    poses = np.repeat(POSES[:, None], robots, axis=1) + np.arange(robots)[None, :, None] * 0.01
    packed = _messages.transform_messages(TIMES, _messages.planar_frames(poses))
    for k, data in enumerate(packed):
        message = decoded(data, "tf2_msgs/msg/TFMessage")
        assert len(message.transforms) == robots
        for robot, item in enumerate(message.transforms):
            assert item.header.frame_id == "map"
            assert item.child_frame_id == f"robot_{robot}/base"
            assert item.transform.translation.x == poses[k, robot, 0]
            turn = yaw_of(item.transform.rotation)
            assert np.cos(turn - poses[k, robot, 2]) == pytest.approx(1.0)


@pytest.mark.parametrize("points", [0, 1, 2, 5])
def test_paths_point_along_themselves(points: int) -> None:
    path = np.column_stack([np.arange(points), 2.0 * np.arange(points)]).astype(float)
    message = decoded(_messages.path_message(12_345_678_901, path), "nav_msgs/msg/Path")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 345678901)
    assert [[p.pose.position.x, p.pose.position.y] for p in message.poses] == path.tolist()
    if points > 1:
        for item in message.poses:
            assert item.header.frame_id == "map"
            assert yaw_of(item.pose.orientation) == pytest.approx(np.arctan2(2.0, 1.0))


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (7, 2)])
def test_maps_keep_values_and_place(shape: tuple[int, int]) -> None:
    grid = np.resize(np.array([0, 100, -1, 37], dtype=np.int8), shape)
    area = OccupancyMap(grid, 0.05, (1.0, -2.0, 0.3))
    message = decoded(_messages.grid_message(5, area), "nav_msgs/msg/OccupancyGrid")
    assert (message.info.height, message.info.width) == shape
    assert message.info.resolution == pytest.approx(0.05)
    assert np.array_equal(message.data.reshape(shape), grid)
    origin = message.info.origin
    assert (origin.position.x, origin.position.y) == (1.0, -2.0)
    assert yaw_of(origin.orientation) == pytest.approx(0.3)


@pytest.mark.parametrize("springs", [0, 1, 3])
def test_markers_show_roles_leader_goals_and_springs(springs: int) -> None:
    models = (robot_model("go1"), robot_model("spirit"))
    poses = np.stack([POSES, POSES + 1.0], axis=1)
    ends = np.arange(3 * springs * 4, dtype=float).reshape(3, springs, 2, 2)
    packed = _messages.marker_messages(
        TIMES,
        poses,
        models,
        roles=np.array([(0, 1), (1, 0), (-1, 0)]),
        leaders=np.array([0, 1, -1]),
        goals=poses[..., :2] + 2.0,
        springs=ends,
    )
    arrays_of_markers = [decoded(data, "visualization_msgs/msg/MarkerArray") for data in packed]
    for k, message in enumerate(arrays_of_markers):
        by_name = {(marker.ns, marker.id): marker for marker in message.markers}
        assert len(by_name) == len(message.markers) == 6
        for robot, model in enumerate(models):
            body = by_name["roles", robot]
            assert (body.scale.x, body.scale.y, body.scale.z) == (
                model.length,
                model.width,
                model.height,
            )
            assert body.pose.position.x == poses[k, robot, 0]
            goal = by_name["goals", robot]
            assert goal.pose.position.y == poses[k, robot, 1] + 2.0
            assert (goal.color.r, goal.color.g) == (body.color.r, body.color.g)
        lines = by_name["springs", 0]
        assert [[p.x, p.y] for p in lines.points] == ends[k].reshape(-1, 2).tolist()
        assert lines.action == (0 if springs else 2)
    leaders = [message.markers[4] for message in arrays_of_markers]
    assert [marker.action for marker in leaders] == [0, 0, 2]
    assert leaders[1].pose.position.x == poses[1, 1, 0]


def test_a_column_that_is_missing_is_an_error() -> None:
    with pytest.raises(KeyError):
        Layout().numbers("value", "f8").pack(1)
