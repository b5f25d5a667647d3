"""Conversions of messages; none of it needs ROS."""

from __future__ import annotations

import math
from types import SimpleNamespace as Fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.errors import MapError
from cavalcade.fleet.ros2 import messages
from cavalcade.fleet.ros2.messages import quaternion_of_yaw, yaw_of_quaternion
from cavalcade.world import OccupancyMap

ANGLES = st.floats(-math.pi, math.pi)


def pose_fields() -> Any:
    return Fields(position=Fields(), orientation=Fields())


def near(a: float, b: float) -> bool:
    return abs(math.remainder(a - b, 2.0 * math.pi)) < 1e-9


@given(ANGLES, st.sampled_from([1e-200, 1e-3, 1.0, -1.0, 7.0, 1e200]))
def test_a_quaternion_of_any_length_gives_its_yaw(yaw: float, length: float) -> None:
    x, y, z, w = (length * value for value in quaternion_of_yaw(yaw))
    assert near(yaw_of_quaternion(x, y, z, w), yaw)


@given(ANGLES, st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_a_tilted_body_heads_where_its_x_axis_points(yaw: float, pitch: float, roll: float) -> None:
    (cy, sy), (cp, sp), (cr, sr) = (
        (math.cos(0.5 * a), math.sin(0.5 * a)) for a in (yaw, pitch, roll)
    )
    x, y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    z, w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    assert near(yaw_of_quaternion(x, y, z, w), yaw)


@pytest.mark.parametrize(
    "quaternion",
    [
        (0.0, 0.0, 0.0, 0.0),
        (math.nan, 0.0, 0.0, 1.0),
        (0.0, 0.0, math.inf, 1.0),
        (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)),  # nose down
    ],
)
def test_what_has_no_heading_is_nan(quaternion: tuple[float, float, float, float]) -> None:
    assert math.isnan(yaw_of_quaternion(*quaternion))


@given(st.floats(0.0, 4e9))
def test_stamps_keep_a_microsecond(seconds: float) -> None:
    stamp = Fields()
    messages.fill_stamp(stamp, seconds)
    assert 0 <= stamp.nanosec < 1_000_000_000
    assert messages.seconds_of(stamp) == pytest.approx(seconds, abs=1e-6)


def test_a_pose_with_nan_is_nan_altogether() -> None:
    pose = pose_fields()
    messages.fill_pose(pose, (math.nan, 1.0, 0.0))
    assert all(map(math.isnan, messages.read_pose(pose)))


@pytest.mark.parametrize("beside", ["nothing", "a covariance"])
def test_a_report_has_its_stamp_its_frame_and_its_pose(beside: str) -> None:
    pose, header = pose_fields(), Fields(stamp=Fields(), frame_id="")
    messages.fill_pose(pose, (1.0, 2.0, 0.5))
    messages.fill_header(header, 12.5, "/map")
    held = pose if beside == "nothing" else Fields(pose=pose, covariance=np.zeros(36))
    report = messages.read_report(Fields(header=header, pose=held))
    assert (report.stamp, report.frame) == (12.5, "map")
    assert report.pose == pytest.approx((1.0, 2.0, 0.5))


def grid_message(area: OccupancyMap) -> Any:
    message = Fields(info=Fields(origin=pose_fields()))
    messages.fill_map(message, area)
    message.info.resolution = float(np.float32(message.info.resolution))
    return message


@given(st.floats(-3.1, 3.1), st.integers(1, 5), st.integers(1, 5), st.sampled_from([0.05, 0.1]))
def test_a_map_comes_back_with_its_origin_and_values(
    yaw: float, rows: int, cols: int, resolution: float
) -> None:
    values = np.random.default_rng(rows).choice([-1, 0, 64, 65, 100], (rows, cols))
    area = OccupancyMap(values, resolution, (1.0, -2.0, yaw))
    back = messages.read_map(grid_message(area))
    assert np.array_equal(back.grid, area.grid)
    assert np.array_equal(back.occupied, area.occupied)
    assert back.resolution == resolution
    assert back.origin == pytest.approx(area.origin)


def test_maps_that_cannot_be_are_refused() -> None:
    area = OccupancyMap(np.zeros((2, 3), dtype=bool), 0.05)
    short, tilted, nowhere, beyond = (grid_message(area) for _ in range(4))
    short.data = short.data[:-1]
    tilted.info.origin.orientation.x = 0.5
    nowhere.info.origin.position.x = math.nan
    beyond.data[0] = 101
    for message in (short, tilted, nowhere, beyond):
        with pytest.raises(MapError):
            messages.read_map(message)


def test_points_of_a_path_look_ahead() -> None:
    message = Fields(header=Fields())
    messages.fill_path(
        message, [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)], lambda: Fields(pose=pose_fields())
    )
    yaws = [messages.read_pose(stamped.pose)[2] for stamped in message.poses]
    assert yaws == pytest.approx([0.0, np.pi / 2, np.pi / 2])
    messages.fill_path(message, np.zeros((0, 2)), None)
    assert message.poses == []
