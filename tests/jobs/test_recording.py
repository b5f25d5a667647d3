from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import Reader

from cavalcade.errors import OutputError, RecordingError
from cavalcade.recording.frames import (
    PATH_POINTS,
    Frame,
    ObstacleTrack,
    Recorder,
    Recording,
    thinned,
)
from cavalcade.recording.mcap_reader import read_recording
from cavalcade.recording.mcap_writer import write_recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

ROBOTS, CYCLES = 3, 60
MODELS = (robot_model("go1"),) * ROBOTS


def a_status(k: int) -> PlannerStatus:
    return PlannerStatus(
        state="partial" if k < 40 else "final",
        leader=k // 20,
        roles=np.roll(np.arange(ROBOTS), k // 20),
        slots=np.array([(1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]) * (1 + (k >= 30)),
        goals=np.full((ROBOTS, 2), 0.123456789 * k),
        goal=None if k < 5 else np.array([9.0, 1.0, 0.25]),
        paths=tuple(np.linspace((0, robot), (k, 1), 30) for robot in range(ROBOTS)),
        connections=np.array([(0, 1), (1, 2)])[: 1 + (k >= 30)],
        eta=np.array([1.0, np.inf, 0.5 * k]),
        arrived=k == CYCLES - 1,
        waypoint=int(k >= 50),
        goal_moved=0.25 if k >= 50 else 0.0,
        involved=(1,) if k == 33 else (),
        message="held up – 1" if k == 33 else "",
    )


@pytest.fixture
def recording() -> Recording:
    random = np.random.default_rng(0)
    recorder = Recorder()
    for k in range(CYCLES):
        poses, seen, commands = random.uniform(-3, 3, (3, ROBOTS, 3))
        if k == 10:
            seen[1] = np.nan
        notes = ("robot 1 lost", "obstacle added") if k == 20 else ()
        recorder(Frame(0.05 * k, poses, seen, commands, a_status(k), notes=notes))
    box = {"box": {"center": [1.0, 2.0], "size": [0.5, 0.4], "yaw": 0.1}}
    circle = {"circle": {"center": [4.0, 2.0], "radius": 0.3}}
    return recorder.recording(
        (
            ObstacleTrack(box, 0.0, 1.0, np.array([0.0]), np.zeros((1, 2))),
            ObstacleTrack(
                circle, 1.0, np.inf, np.array([1.0, 2.0]), np.array([(0.0, 0.0), (1.0, 0.5)])
            ),
        )
    )


def test_everything_comes_back(recording: Recording, tmp_path: Path) -> None:
    write_recording(tmp_path / "recording.mcap", recording, MODELS)
    back = read_recording(tmp_path)
    assert np.array_equal(back.time, recording.time)
    for name in ("poses", "estimated"):
        one, other = getattr(back, name), getattr(recording, name)
        assert np.array_equal(one[..., :2], other[..., :2], equal_nan=True)
        assert np.allclose(one[..., 2], other[..., 2], atol=1e-12, equal_nan=True)
    assert np.array_equal(back.commands, recording.commands)
    assert np.array_equal(back.roles, recording.roles)
    assert back.notes == recording.notes
    for one, other in zip(back.obstacles, recording.obstacles, strict=True):
        assert (one.shape, one.start, one.end) == (other.shape, other.start, other.end)
        assert np.array_equal(one.time, other.time)
        assert np.array_equal(one.offset, other.offset)


def test_every_status_comes_back(recording: Recording, tmp_path: Path) -> None:
    file = write_recording(tmp_path / "recording.mcap", recording, MODELS)
    for k, (one, other) in enumerate(
        zip(read_recording(file).status, recording.status, strict=True)
    ):
        for name in ("state", "leader", "arrived", "waypoint", "goal_moved", "involved", "message"):
            assert getattr(one, name) == getattr(other, name), (k, name)
        for name in ("roles", "connections", "slots", "goals", "eta"):
            assert np.allclose(getattr(one, name), getattr(other, name), atol=1e-6), (k, name)
        assert (one.goal is None) == (other.goal is None)
        assert len(one.paths) == len(other.paths) == ROBOTS
        for a, b in zip(one.paths, other.paths, strict=True):
            assert np.array_equal(a, b)


def test_humble_could_not_read_the_quality_of_service(recording: Recording, tmp_path: Path) -> None:
    """Numbers stand for its policies, which all distributions read if the version says so."""
    file = write_recording(tmp_path / "r.mcap", recording, MODELS)
    with Reader(file) as reader:
        offered = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
    assert {topic for topic, profiles in offered.items() if profiles} == {
        "/map",
        "/tf_static",
        "/cavalcade/obstacles",
        *(f"/robot_{robot}/robot_description" for robot in range(ROBOTS)),
    }
    data = file.read_bytes()
    said = yaml.safe_load(next(strings_after(data, "serialized_metadata")))
    assert said["version"] == 8
    topics = [entry["topic_metadata"] for entry in said["topics_with_message_count"]]
    (latched,) = [t["offered_qos_profiles"] for t in topics if t["name"] == "/map"]
    channels = list(strings_after(data, "offered_qos_profiles"))
    assert latched in channels
    for text in {text for text in channels if text}:
        (profile,) = yaml.safe_load(text)
        policies = ("history", "depth", "reliability", "durability", "liveliness")
        assert [profile[name] for name in policies] == [1, 1, 1, 1, 1]


def strings_after(data: bytes, key: str) -> Iterator[str]:
    """What follows a key in MCAP's maps of strings, wherever the file is not compressed."""
    for found in re.finditer(key.encode(), data):
        end = found.end() + 4
        if data[found.start() - 4 : found.start()] == struct.pack("<I", len(key)):
            yield data[end : end + int.from_bytes(data[found.end() : end], "little")].decode()


def test_the_contract_s_topics_are_there(recording: Recording, tmp_path: Path) -> None:
    area = OccupancyMap.empty((2.0, 1.0), 0.5)
    file = write_recording(tmp_path / "r.mcap", recording, MODELS, [(0.0, area), (1.0, area)])
    with Reader(file) as reader:
        found = {c.topic: (c.msgtype, c.msgcount) for c in reader.connections}
        times: dict[str, list[int]] = {}
        for connection, time, _ in reader.messages():
            times.setdefault(connection.topic, []).append(time)
    assert found["/map"] == ("nav_msgs/msg/OccupancyGrid", 2)
    assert found["/tf"] == ("tf2_msgs/msg/TFMessage", CYCLES)
    assert found["/markers"] == ("visualization_msgs/msg/MarkerArray", CYCLES / 2)
    for robot in range(ROBOTS):
        name = f"/robot_{robot}"
        assert found[f"{name}/pose"] == ("geometry_msgs/msg/PoseStamped", CYCLES)
        assert found[f"{name}/pose_estimated"] == ("geometry_msgs/msg/PoseStamped", CYCLES)
        assert found[f"{name}/cmd_vel"] == ("geometry_msgs/msg/TwistStamped", CYCLES)
        assert found[f"{name}/path"][0] == "nav_msgs/msg/Path"
        assert times[f"{name}/pose"] == [round(t * 1e9) for t in recording.time]
    for stamps in times.values():
        assert stamps == sorted(stamps)


def test_same_recording_same_bytes(recording: Recording, tmp_path: Path) -> None:
    one = write_recording(tmp_path / "a.mcap", recording, MODELS).read_bytes()
    assert write_recording(tmp_path / "b.mcap", recording, MODELS).read_bytes() == one
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.mcap", "b.mcap"]


def test_an_empty_recording_can_be_kept(tmp_path: Path) -> None:
    write_recording(tmp_path / "recording.mcap", Recorder().recording(), ())
    assert len(read_recording(tmp_path).time) == 0


def test_a_folder_that_is_not_there(recording: Recording, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="missing"):
        write_recording(tmp_path / "missing" / "r.mcap", recording, MODELS)


@pytest.mark.parametrize("cut", [0, 5, 100, 4000])
def test_a_damaged_file_is_one_clear_error(recording: Recording, tmp_path: Path, cut: int) -> None:
    file = write_recording(tmp_path / "recording.mcap", recording, MODELS)
    file.write_bytes(file.read_bytes()[:cut])
    with pytest.raises(RecordingError, match=r"recording\.mcap") as caught:
        read_recording(tmp_path)
    assert "\n" not in str(caught.value)


def test_bytes_turned_over_never_end_in_a_traceback(recording: Recording, tmp_path: Path) -> None:
    file = write_recording(tmp_path / "recording.mcap", recording, MODELS)
    sound = file.read_bytes()
    random = np.random.default_rng(1)
    for _ in range(25):
        data = bytearray(sound)
        for place in random.integers(0, len(data), 8):
            data[place] ^= 0xFF
        file.write_bytes(bytes(data))
        try:
            read_recording(file)
        except RecordingError:
            continue


def test_no_recording_at_all(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no such recording"):
        read_recording(tmp_path)


def test_paths_are_kept_four_times_a_second_and_when_something_changes() -> None:
    recorder = Recorder()
    nothing = np.zeros((ROBOTS, 3))
    for k in range(40):
        recorder(Frame(0.05 * k, nothing, nothing, nothing, a_status(k)))
    kept = [status.paths for status in recorder.recording().status]
    new = [0.05 * k for k in range(40) if k == 0 or kept[k] is not kept[k - 1]]
    # The leader changes at 1.0 s, on which the quarters fall anyway.
    assert new == pytest.approx(np.arange(0, 2, 0.25))
    recorder(Frame(2.05, nothing, nothing, nothing, replace(a_status(39), state="stuck")))
    assert recorder.recording().status[-1].paths is not kept[-1]


@pytest.mark.parametrize("count", [0, 1, PATH_POINTS, 500])
def test_thinning_keeps_the_ends(count: int) -> None:
    path = np.column_stack([np.arange(count), np.zeros(count)]).astype(float)
    thin = thinned(path)
    assert len(thin) == min(count, PATH_POINTS)
    if count:
        assert np.array_equal(thin[[0, -1]], path[[0, -1]])
        assert np.all(np.diff(thin[:, 0]) > 0)


def test_a_run_s_recording_equals_what_its_file_says(
    make_scenario: Callable[..., Any], straight: Any, tmp_path: Path
) -> None:
    from cavalcade.jobs.running import run

    result = run(make_scenario(), tmp_path / "r", planner=straight, figures=False, replay=False)
    back = read_recording(tmp_path / "r")
    assert np.allclose(back.poses, result.recording.poses, atol=1e-12)
    assert [s.state for s in back.status] == [s.state for s in result.recording.status]
