"""Whole result folders: sound ones, tampered ones and unreadable ones."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pytest
import yaml
from PIL import Image

from cavalcade.checking import check
from cavalcade.errors import RecordingError

PATH = [(0, 3, 5, 0), (4, 4, 5, 0)]


@pytest.fixture
def folder(make_folder, scenario_words, knot_path):
    track = knot_path(PATH)
    return make_folder([track], scenario_words([[3, 5, 0]]), {"success": False, "sim_time_s": 4.0})


def test_a_sound_folder(folder):
    report = check(folder)
    assert report.ok
    assert report.figures.robots == 1
    assert report.figures.duration_s == pytest.approx(4.0)
    assert report.figures.max_speed_ratio == pytest.approx(0.5)


def test_a_false_claim_of_success(folder):
    (folder / "summary.json").write_text(json.dumps({"success": True, "goal_moved_m": None}))
    report = check(folder)
    assert {violation.kind for violation in report.violations} == {"arrival"}


def test_an_obstacle_written_into_the_scenario_afterwards(folder):
    file = folder / "scenario.yaml"
    content = yaml.safe_load(file.read_text())
    content["world"]["obstacles"] = [{"circle": {"center": [4.0, 5.0], "radius": 0.1}}]
    file.write_text(yaml.safe_dump(content))
    (violation,) = check(folder).violations
    assert violation.kind == "robot-obstacle"
    assert "world.obstacles[0]" in violation.message


def test_violations_come_in_order_of_time(make_folder, scenario_words, knot_path):
    jumpy = knot_path(
        [(0, 3, 5, 0), (1, 3, 5, 0), (1.05, 3, 8, 0), (2, 3, 8, 0), (2.05, 3, 9.95, 0)]
    )
    report = check(make_folder([jumpy], scenario_words([[3, 5, 0]])))
    times = [violation.time for violation in report.violations]
    assert len(times) > 3
    assert times == sorted(times)


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_an_occupied_cell_of_a_map_with_turned_origin(make_folder, scenario_words, knot_path, yaw):
    """A robot drives along the map's own x axis into a wall 2 m from its corner."""
    corner = np.array([1.0, -2.0])
    along = np.array([np.cos(yaw), np.sin(yaw)])
    across = np.array([-np.sin(yaw), np.cos(yaw)])
    start, end = (corner + 1.0 * across + s * along for s in (0.5, 1.9))
    track = knot_path([(0, *start, yaw), (4, *end, yaw)])
    content = scenario_words([[*start.tolist(), yaw]], world={"map": "map.yaml"})
    folder = make_folder([track], content)
    picture = np.full((40, 80), 254, dtype=np.uint8)
    picture[:, 40:42] = 0
    Image.fromarray(picture).save(folder / "map.png")
    words = {"image": "map.png", "resolution": 0.05, "origin": [*corner.tolist(), yaw]}
    words |= {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196}
    (folder / "map.yaml").write_text(yaml.safe_dump(words))
    (violation,) = check(folder).violations
    assert violation.kind == "robot-map"
    assert violation.obstacle == "map"
    assert violation.time == pytest.approx((2.0 - 0.325 - 0.5) / 0.35, abs=0.01)


@pytest.mark.parametrize("name", ["scenario.yaml", "summary.json", "recording.mcap"])
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    with pytest.raises(RecordingError, match=name):
        check(folder)


@pytest.mark.parametrize("name", ["scenario.yaml", "summary.json", "recording.mcap"])
@pytest.mark.parametrize("content", [b"", b"\x00\xff rubbish", b"- 1\n", b"[1, 2]"])
def test_rubbish_is_named(folder, name, content):
    (folder / name).write_bytes(content)
    with pytest.raises(RecordingError, match=name):
        check(folder)


@pytest.mark.parametrize("part", [0.1, 0.5])
def test_a_truncated_recording(folder, part):
    file = folder / "recording.mcap"
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    with pytest.raises(RecordingError, match=r"recording\.mcap"):
        check(folder)


@pytest.mark.parametrize("part", [0.9, 0.99])
def test_a_recording_without_its_end_is_judged_as_far_as_it_goes(folder, part):
    file = folder / "recording.mcap"
    assert check(folder).ok
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    for _ in range(2):
        (violation,) = check(folder).violations
        assert violation.kind == "samples"
        assert "breaks off" in violation.message
        (folder / "summary.json").unlink(missing_ok=True)  # whoever died has written none


def test_a_damaged_recording_is_no_traceback(folder):
    file = folder / "recording.mcap"
    content = bytearray(file.read_bytes())
    rng = np.random.default_rng(0)
    for _ in range(30):
        damaged = bytearray(content)
        for place in rng.integers(0, len(content), 5):
            damaged[place] = rng.integers(256)
        file.write_bytes(damaged)
        with contextlib.suppress(RecordingError):
            check(folder)


def test_missing_folder(tmp_path):
    with pytest.raises(RecordingError, match="no such folder"):
        check(tmp_path / "nothing")


def test_a_robot_without_poses(make_folder, scenario_words, knot_path):
    content = scenario_words([[3, 5, 0], [3, 7, 0]])
    with pytest.raises(RecordingError, match="/robot_1/pose"):
        check(make_folder([knot_path(PATH)], content))


def test_a_robot_too_many(make_folder, scenario_words, knot_path):
    tracks = [knot_path(PATH), knot_path([(0, 3, 7, 0), (1, 3, 7, 0)])]
    with pytest.raises(RecordingError, match="/robot_1/pose"):
        check(make_folder(tracks, scenario_words([[3, 5, 0]])))


def test_a_pose_that_is_not_a_number(make_folder, scenario_words, knot_path):
    track = knot_path(PATH)
    track.pose[7, 0] = np.nan
    with pytest.raises(RecordingError, match="not finite"):
        check(make_folder([track], scenario_words([[3, 5, 0]])))


def test_poses_of_another_type(folder, recorder, knot_path):
    recorder(folder / "recording.mcap", [knot_path(PATH)], pose_type=False)
    with pytest.raises(RecordingError, match="PoseStamped"):
        check(folder)


def test_crossing_the_date_line_of_yaw_is_no_spin(make_folder, scenario_words, knot_path):
    track = knot_path([(0, 5, 5, 3.0), (1, 5, 5, 3.0), (2, 5, 5, 3.3)])
    report = check(make_folder([track], scenario_words([[5, 5, 3.0]])))
    assert report.figures.max_yaw_rate < 0.4
