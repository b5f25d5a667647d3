"""Folders of results: found, told apart, read, and turned into moments by time."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

import cavalcade as cv
from cavalcade.errors import InputError
from cavalcade.recording import Recording, read_recording, write_recording
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack
from cavalcade.scenario import parse_scenario
from cavalcade.studio.study.curves import curves_of
from cavalcade.studio.study.facts import compared, facts
from cavalcade.studio.study.results import folder_of, kind_of, read_result, results_in

FORMATION = {
    "version": 1,
    "name": "pair",
    "world": {
        "empty": {"size": [6.0, 4.0]},
        "obstacles": [
            {"circle": {"center": [5.0, 3.5], "radius": 0.2}},
            {"box": {"center": [0.6, 3.4], "size": [0.4, 0.4]}},
        ],
    },
    "robots": [
        {"model": "go1", "start": [1.0, 1.4, 0.0]},
        {"model": "go1", "start": [1.0, 2.4, 0.0]},
    ],
    "task": {"formation": {"shape": "line", "spacing": 1.0}, "goals": [[2.0, 1.9, 0.0]]},
    "execution": {
        "timeout": 12,
        "events": [
            {"at": 1.0, "add": {"circle": {"center": [4.6, 0.6], "radius": 0.2}}},
            {"at": 1.5, "remove": {"box": {"center": [0.6, 3.4], "size": [0.4, 0.4]}}},
        ],
    },
}
SWAP = {
    "version": 1,
    "name": "swap",
    "world": {"empty": {"size": [5.0, 3.0]}},
    "robots": [
        {"model": "go1", "start": [1.0, 1.0, 0.0], "goal": [3.0, 1.0, 0.0]},
        {"model": "go1", "start": [1.0, 2.0, 0.0], "goal": [3.0, 2.0, 0.0]},
    ],
    "task": {"goals": "individual"},
}
COMMANDS = {
    "version": 1,
    "name": "told",
    "world": {"empty": {"size": [5.0, 3.0]}},
    "robots": [{"model": "go1", "start": [1.0, 1.0, 0.0]}],
    "task": {"commands": [{"at": 0.0, "robot": 0, "velocity": [0.3, 0.0, 0.2]}], "duration": 1.0},
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the folders of a run in formation, one of commands, and a plan."""
    place = tmp_path_factory.mktemp("runs")
    quick = {"figures": False, "replay": False}
    cv.run(parse_scenario(FORMATION), place / "pair", **quick)
    cv.run(parse_scenario(COMMANDS), place / "told", **quick)
    cv.plan(parse_scenario(SWAP), place / "swap", **quick)
    return place


@pytest.fixture
def pair(runs: Path, tmp_path: Path) -> Path:
    """A copy to break."""
    return Path(shutil.copytree(runs / "pair", tmp_path / "pair"))


def test_moments_of_a_run_are_those_of_its_cycles(runs: Path) -> None:
    result = read_result(runs / "pair")
    recording = read_recording(runs / "pair")
    assert (result.player.begin, result.player.end) == (0.0, recording.time[-1])
    for cycle in (0, 7, len(recording.time) - 1):
        moment = result.player.at(float(recording.time[cycle]))
        assert np.allclose(moment.poses, recording.poses[cycle])
        assert moment.status is not None
        assert moment.status.state == recording.status[cycle].state
        assert np.array_equal(moment.commands, recording.commands[cycle])
    between = result.player.at(float(recording.time[7] + recording.time[8]) / 2.0)
    assert np.allclose(between.poses, recording.poses[7:9].mean(axis=0))
    assert np.array_equal(result.player.at(-5.0).poses, recording.poses[0])
    assert np.array_equal(result.player.at(1e9).poses, recording.poses[-1])


def test_obstacles_come_and_go_with_the_time(runs: Path) -> None:
    result = read_result(runs / "pair")
    assert len(result.start.shapes) == 2
    assert len(result.world.shapes) == len(result.world.spans) == 1
    kinds = {time: [one.kind for one in result.player.at(time).obstacles] for time in (0.5, 1.2, 2)}
    assert kinds == {0.5: ["box"], 1.2: ["box", "circle"], 2: ["circle"]}
    assert [round(time, 1) for time, _ in result.events][:2] == [1.0, 1.5]


def test_headings_turn_the_short_way(runs: Path) -> None:
    recording = read_recording(runs / "told")
    poses = recording.poses.copy()
    poses[0, :, 2], poses[1:, :, 2] = np.pi - 0.1, -np.pi + 0.1
    result = read_result(runs / "told")
    player = type(result.player)(replace(recording, poses=poses))
    yaw = player.at(float(recording.time[:2].mean())).poses[0, 2]
    assert abs(np.cos(yaw) + 1.0) < 1e-9


def test_moments_of_a_plan(runs: Path) -> None:
    result = read_result(runs / "swap")
    assert kind_of(runs / "swap") == "plan"
    assert result.player.end > 2.0
    assert np.allclose(result.player.at(0.0).poses[:, :2], [[1.0, 1.0], [1.0, 2.0]])
    assert np.allclose(result.player.at(99.0).poses[:, :2], [[3.0, 1.0], [3.0, 2.0]], atol=1e-6)
    trunks = result.player.at(1.0).trunks
    assert trunks is not None
    assert np.allclose(np.linalg.norm(trunks[:, 3:], axis=1), 1.0)
    assert len(result.planned[0]) == 2


def with_bodies(recording: Recording) -> Recording:
    """As if it had been in physics, with trunks that turn about x and joints that count."""
    count, robots = recording.poses.shape[:2]
    base = np.zeros((count, robots, 7))
    base[..., :2] = recording.poses[..., :2]
    angle = np.linspace(0.0, 4.0 * np.pi, count)
    base[..., 3], base[..., 4] = np.cos(angle / 2.0)[:, None], np.sin(angle / 2.0)[:, None]
    base[1::2, :, 3:] *= -1.0  # the same rotations
    joints = np.broadcast_to(np.arange(count)[:, None, None] * 0.01, (count, robots, 12)).copy()
    track = PhysicsTrack(
        recording.time, base, joints, joints, joints, np.ones((count, robots, 4, 3)),
        (ContactEvent(0.5, 0, "calf", "ground"), ContactEvent(0.52, 0, "calf", "ground")),
        (FallEvent(0.8, 0),),
    )  # fmt: skip
    return replace(recording, physics=track)


def test_bodies_of_a_run_in_physics(runs: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(runs / "told", tmp_path / "told"))
    recording = with_bodies(read_recording(folder))
    write_recording(folder / "recording.mcap", recording, read_result(folder).scenario.models)
    result = read_result(folder)
    whole = read_recording(folder).physics
    assert whole is not None
    assert result.recording is not None
    assert result.recording.physics is not None
    assert np.array_equal(result.recording.physics.joints, whole.joints)
    assert whole.foot_forces.all()
    assert not result.recording.physics.foot_forces.any()  # nobody looks at them
    moment = result.player.at(float(recording.time[3:5].mean()))
    assert moment.trunks is not None
    assert moment.joints is not None
    assert np.allclose(moment.joints[0], 0.035)
    angle = 3.5 * 4.0 * np.pi / (len(recording.time) - 1)
    x, y, z, w = moment.trunks[0, 3:]
    assert np.allclose(
        [abs(x), y, z, abs(w)], [abs(np.sin(angle / 2)), 0, 0, abs(np.cos(angle / 2))]
    )
    texts = [text for _, text in result.events]
    assert texts.count("robot 0: calf touched the ground") == 1
    assert "robot 0 fell" in texts


def test_a_recording_without_its_end_is_shown_as_far_as_it_goes(pair: Path) -> None:
    whole = read_result(pair).player.end
    data = (pair / "recording.mcap").read_bytes()
    (pair / "recording.mcap").write_bytes(data[: int(0.97 * len(data))])
    (pair / "summary.json").unlink()
    result = read_result(pair)
    assert 0.0 < result.player.end <= whole
    assert "breaks off at" in result.gaps[0]
    assert "not finished" in result.gaps[1]
    assert facts(result.summary) == []


@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (lambda folder: (folder / "recording.mcap").write_bytes(b"no"), "recording.mcap"),
        (lambda folder: (folder / "recording.mcap").write_bytes(b""), "recording.mcap"),
        (lambda folder: (folder / "scenario.yaml").unlink(), "has no scenario.yaml"),
        (lambda folder: (folder / "scenario.yaml").write_text("- 1"), "scenario.yaml"),
        (lambda folder: (folder / "scenario.yaml").write_bytes(b"\xff\xfe"), "scenario.yaml"),
        (lambda folder: (folder / "recording.mcap").unlink(), "expected the folder of a run"),
        (lambda folder: shutil.rmtree(folder), "expected the folder of a run"),
    ],
)
def test_broken_folders_are_told_in_words(pair: Path, harm, words: str) -> None:  # type: ignore[no-untyped-def]
    harm(pair)
    with pytest.raises(InputError, match=words):
        read_result(pair)


def test_a_scenario_of_other_robots_is_told(pair: Path, runs: Path) -> None:
    shutil.copy(runs / "told" / "scenario.yaml", pair / "scenario.yaml")
    with pytest.raises(InputError, match=r"has 2 robots, but scenario\.yaml beside it has 1"):
        read_result(pair)


@pytest.mark.parametrize("content", ["", "[]", "{", "nonsense", "1"])
def test_a_summary_that_cannot_be_read_is_no_obstacle(pair: Path, content: str) -> None:
    (pair / "summary.json").write_text(content)
    result = read_result(pair)
    assert result.gaps == ("summary.json cannot be read.",)
    assert result.summary == {}


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"\x93NUMPY"])
def test_a_plan_that_is_none(runs: Path, tmp_path: Path, content: bytes) -> None:
    folder = Path(shutil.copytree(runs / "swap", tmp_path / "swap"))
    (folder / "plan.npz").write_bytes(content)
    with pytest.raises(InputError, match=r"plan\.npz: not a plan"):
        read_result(folder)


def test_folders_are_found_the_newest_first(runs: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "deep" / "er").mkdir(parents=True)
    shutil.copytree(runs / "told", tmp_path / "deep" / "er" / "told")
    campaign = tmp_path / "campaign"
    campaign.mkdir()
    (campaign / "campaign.json").write_text("{}")
    (tmp_path / "loop").symlink_to(tmp_path)
    found = results_in([tmp_path, tmp_path / "absent", runs])
    assert {folder.name for folder in found} == {"told", "campaign", "pair", "swap"}
    times = [folder.stat().st_mtime for folder in found]
    assert times == sorted(times, reverse=True)
    assert kind_of(campaign) == "campaign"
    for alone in ("trials.jsonl", "trials.parquet"):
        (tmp_path / alone).mkdir()
        assert kind_of(tmp_path) == "campaign"
        (tmp_path / alone).rmdir()
    assert kind_of(tmp_path / "empty") is kind_of(tmp_path / "absent") is None


@pytest.mark.parametrize("said", ["", "  ", "no/such", "a\0b", "x" * 5000])
def test_paths_that_name_nothing(said: str) -> None:
    with pytest.raises(InputError):
        folder_of(said)


def test_paths_as_people_give_them(runs: Path) -> None:
    wanted = (runs / "pair").resolve()
    for said in (f" {wanted}/ ", f"'{wanted}'", str(wanted / "recording.mcap")):
        assert folder_of(said) == wanted


def test_facts_and_their_differences(runs: Path) -> None:
    summary = json.loads((runs / "pair" / "summary.json").read_text())
    other = json.loads(json.dumps(summary))
    other["makespan_s"] = summary["makespan_s"] + 1.5
    other["collisions"]["robot_robot"] = 2
    other["variant"] = "published"
    other["min_robot_distance_m"] = None
    told = dict(facts(summary))
    assert told["outcome"] == "arrived"
    assert told["all in place after"] == f"{summary['makespan_s']:.1f} s"
    changes = {label: change for label, _, _, change in compared(summary, other)}
    assert changes["all in place after"] == "+1.5 s"
    assert changes["collisions of robots"] == "+2"
    assert changes["variant"] == "differs"
    assert changes["closest two robots"] == "differs"
    assert changes["seed"] == changes["outcome"] == ""
    assert facts({"reason": {}, "makespan_s": "soon", "path_length_m": [1, None]}) == [
        ("outcome", "{}")
    ]


def test_curves_are_those_of_the_summary(runs: Path) -> None:
    result = read_result(runs / "pair")
    curves = {curve.name: curve for curve in curves_of(result)}
    nearest = curves["closest robots (m)"].values.min()
    assert nearest == pytest.approx(result.summary["min_robot_distance_m"], abs=0.02)
    errors = curves["formation error (m)"].values
    assert np.nanmean(errors) == pytest.approx(
        result.summary["formation_error_m"]["mean"], abs=0.02
    )
    assert 0.1 < curves["fastest robot (m/s)"].values.max() < 3.0
    assert {curve.name for curve in curves_of(read_result(runs / "swap"))} == {
        "closest obstacle (m)", "closest robots (m)", "fastest robot (m/s)"
    }  # fmt: skip


def test_ten_minutes_become_a_few_hundred_points(runs: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(runs / "told", tmp_path / "told"))
    recording = read_recording(folder)
    again = np.arange(12_000) % len(recording.time)
    long = replace(
        recording,
        time=np.arange(12_000) / 20.0,
        poses=recording.poses[again],
        estimated=recording.estimated[again],
        commands=recording.commands[again],
        status=tuple(recording.status[k] for k in again),
    )
    write_recording(folder / "recording.mcap", long, read_result(folder).scenario.models)
    result = read_result(folder)
    assert result.player.end == pytest.approx(599.95)
    assert all(len(curve.time) <= 600 for curve in curves_of(result))
