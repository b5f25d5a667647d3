"""The folder of a live session, ended or not, and how it is judged."""

from __future__ import annotations

import json
import shutil
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cavalcade.checking import check
from cavalcade.cli.commands import run_command
from cavalcade.errors import InputError, OutputError, RecordingError
from cavalcade.jobs import finish_recording, record_live
from cavalcade.recording.frames import Frame
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model
from cavalcade.scenario import FormationSection, load_scenario
from cavalcade.scenario.settings import UnitreeSection
from cavalcade.world import Box, OccupancyMap

GO1 = robot_model("go1")
AREA = OccupancyMap.empty((8.0, 6.0), 0.1)
STARTS = np.array([(1.5, 2.0, 0.0), (1.5, 3.5, 0.0)])
LINE = FormationSection(shape="line", spacing=1.5)
CYCLES, PERIOD = 240, 0.05


def a_frame(k: int, noise: float, own: bool, random: np.random.Generator, **said) -> Frame:
    """Two robots go 2 m ahead at 0.25 m/s and stand; poses are measured ones."""
    ahead = min(0.25 * PERIOD * k, 2.0)
    poses = STARTS + (ahead, 0.0, 0.0)
    goal = STARTS + (2.0, 0.0, 0.0)
    status = PlannerStatus(
        state="final",
        leader=-1 if own else 0,
        roles=np.array([1, 0]),
        slots=np.zeros((0, 2)) if own else np.array([(0.0, 0.75), (0.0, -0.75)]),
        goals=goal[:, :2],
        goal=None if own else goal.mean(axis=0),
        targets=goal if own else None,
        paths=(np.stack([poses[0, :2], goal[0, :2]]), np.stack([poses[1, :2], goal[1, :2]])),
        eta=np.zeros(2),
        arrived=k > 200,
    )
    measured = poses + random.normal(0.0, noise, poses.shape) * (1.0, 1.0, 0.2)
    measured[0 if not k else slice(0), :] = poses[0]
    return Frame(PERIOD * k, measured, measured, np.zeros((2, 3)), status, **said)


def a_session(folder: Path, own: bool = False, noise: float = 0.0, cycles: int = CYCLES) -> Path:
    random = np.random.default_rng(0)
    recording = record_live(
        folder,
        name="lab",
        models=[GO1, GO1],
        starts=STARTS,
        area=AREA,
        rate=1.0 / PERIOD,
        backend="ros2",
        formation=None if own else LINE,
        names=["ann", "bob"],
    )
    with recording:
        for k in range(cycles):
            recording(a_frame(k, noise, own, random))
    assert recording.problem == ""
    return folder


def cut_off(folder: Path) -> None:
    """As if the process had died: no index and no metadata."""
    file = folder / "recording.mcap"
    file.write_bytes(file.read_bytes()[:-3000])


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_session_leaves_what_any_run_leaves(tmp_path: Path, own: bool, noise: float) -> None:
    folder = a_session(tmp_path / "s", own, noise)
    result = finish_recording(folder, figures=noise == 0.0)
    assert result.reason == "arrived"
    assert result.success
    assert result.summary.sim_time_s == pytest.approx(PERIOD * (CYCLES - 1))
    assert result.summary.backend == "ros2"
    assert result.summary.planning_time_s is None
    assert all(file.is_file() for file in result.files)
    names = {"summary.json", "scenario.yaml", "recording.mcap", "replay.html"}
    assert names <= {file.name for file in result.files}
    scenario = load_scenario(folder / "scenario.yaml")
    if own:
        assert scenario.robots[0].goal == pytest.approx((3.5, 2.0, 0.0))
    else:
        assert scenario.task.goals == ((3.5, 2.75, 0.0),)
    report = check(folder)
    assert report.violations == ()
    if noise:  # what is no violation is measured all the same
        assert report.figures.max_acceleration > GO1.max_acceleration


def test_contact_and_false_claims_of_live_robots_are_told(tmp_path: Path) -> None:
    folder = a_session(tmp_path / "s")
    finish_recording(folder, figures=False, replay=False)
    scenario = (folder / "scenario.yaml").read_text()
    moved = scenario.replace("3.5, 2.75", "3.9, 2.75")
    assert moved != scenario
    (folder / "scenario.yaml").write_text(moved)
    assert {one.kind for one in check(folder).violations} == {"arrival"}
    blocked = scenario.replace(
        "obstacles: []", "obstacles: [{box: {center: [2.8, 2.0], size: [0.2, 0.2]}}]"
    )
    (folder / "scenario.yaml").write_text(blocked)
    assert "robot-obstacle" in {one.kind for one in check(folder).violations}


@pytest.mark.parametrize(("late", "kinds"), [(9, set()), (11, {"samples"})])
def test_late_cycles_of_live_robots(tmp_path: Path, late: int, kinds: set[str]) -> None:
    """Half a second without a sample is the most."""
    random = np.random.default_rng(0)
    recording = record_live(
        tmp_path / "s", name="lab", models=[GO1, GO1], starts=STARTS, area=AREA,
        rate=1.0 / PERIOD, backend="ros2", formation=LINE,
    )  # fmt: skip
    with recording:
        for k in range(CYCLES):
            if not 20 < k < 20 + late:
                recording(a_frame(k, 0.0, False, random))
    finish_recording(tmp_path / "s", figures=False, replay=False)
    assert {one.kind for one in check(tmp_path / "s").violations} == kinds


@pytest.mark.parametrize("gap", [0, 90])
def test_a_restarted_simulation_was_summarised_as_a_collision(tmp_path: Path, gap: int) -> None:
    """Robots are back at their starts; what was between is no motion through a wall."""
    random = np.random.default_rng(0)
    wall = Box((2.5, 2.75), (0.1, 3.0))
    recording = record_live(
        tmp_path / "s", name="lab", models=[GO1, GO1], starts=STARTS, area=AREA.with_shapes([wall]),
        rate=1.0 / PERIOD, backend="ros2", formation=LINE,
    )  # fmt: skip
    with recording:
        for k in range(60):
            frame = a_frame(0, 0.0, False, random)
            poses = frame.poses + ((2.5, 0.0, 0.0) if k >= 30 else (0.0, 0.0, 0.0))
            late = gap if k >= 30 else 0
            recording(replace(frame, time=PERIOD * (k + late), poses=poses))
    summary = finish_recording(tmp_path / "s", figures=False, replay=False).summary
    assert summary.reason == "stopped"
    assert summary.min_obstacle_distance_m > 0.5
    assert summary.path_length_m == (0.0, 0.0)
    (only,) = check(tmp_path / "s").violations
    assert only.kind == "samples"


def test_a_session_that_died(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = a_session(tmp_path / "s", cycles=150)
    cut_off(folder)
    (violation,) = check(folder).violations
    assert violation.kind == "samples"
    assert "breaks off" in violation.message
    with pytest.warns(UserWarning, match="the end of this recording is missing"):
        result = finish_recording(folder)
    assert (result.reason, result.success) == ("crashed", False)
    assert "breaks off" in result.summary.detail
    assert not result.recording.ended
    assert (folder / "figures" / "sequence.png").is_file()
    (violation,) = check(folder).violations
    assert run_command(["show", str(folder)]) == 2
    assert "finished" in capsys.readouterr().err
    (folder / "summary.json").unlink()
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert run_command(["show", str(folder)]) == 0
    said = capsys.readouterr()
    assert "replay.html" in said.out
    assert "the end of this recording is missing" in said.err
    assert json.loads((folder / "summary.json").read_text())["reason"] == "crashed"


def test_shapes_that_were_asked_for_on_the_way(tmp_path: Path) -> None:
    folder, random = tmp_path / "s", np.random.default_rng(0)
    recording = record_live(
        folder, name="lab", models=[GO1, GO1], starts=STARTS, area=AREA, rate=20.0,
        backend="ros2", formation=FormationSection(shape="column", spacing=1.0),
    )  # fmt: skip
    with recording:
        for k in range(CYCLES):
            frame = a_frame(k, 0.0, False, random)
            if k < 10:
                frame.status.slots[:] = ((0.5, 0.0), (-0.5, 0.0))
            recording(frame)
    finish_recording(folder, figures=False, replay=False)
    assert load_scenario(folder / "scenario.yaml").task.formation.shape == "custom"
    assert check(folder).ok


def test_other_reasons_and_nothing_to_finish(tmp_path: Path) -> None:
    folder = a_session(tmp_path / "s", cycles=50)
    result = finish_recording(folder, "stopped", "e-stop", figures=False, replay=False)
    assert (result.reason, result.summary.detail) == ("stopped", "e-stop")
    empty = a_session(tmp_path / "e", cycles=0)
    with pytest.raises(RecordingError, match="nothing was recorded"):
        finish_recording(empty)
    with pytest.raises(RecordingError, match=r"scenario\.yaml"):
        finish_recording(tmp_path)


def test_folders_that_hold_something(tmp_path: Path) -> None:
    folder = a_session(tmp_path / "s", cycles=5)
    with pytest.raises(OutputError, match="not empty"):
        a_session(folder)
    finish_recording(folder, replay=False)
    record_live(
        folder, name="lab", models=[GO1], starts=STARTS[:1], area=AREA, rate=20.0,
        backend="ros2", force=True,
    ).close()  # fmt: skip
    assert not (folder / "summary.json").exists()
    assert not list((folder / "figures").glob("*.png"))
    shutil.rmtree(folder)


def test_folders_of_go2s_could_not_be_begun(tmp_path: Path) -> None:
    """Scenarios of theirs say where each is on the network; odometry begins where they stand."""
    places = UnitreeSection(robots=[{"interface": "eth1", "battery_min": 5}, {"domain": 7}])
    recording = record_live(
        tmp_path / "s", name="lab", models=[GO1, GO1], starts=STARTS, area=AREA,
        rate=1.0 / PERIOD, backend="unitree", formation=LINE, unitree=places,
    )  # fmt: skip
    random = np.random.default_rng(0)
    with recording:
        for k in range(CYCLES):
            recording(a_frame(k, 0.01, False, random))
    assert finish_recording(tmp_path / "s", figures=False, replay=False).success
    scenario = load_scenario(tmp_path / "s" / "scenario.yaml")
    assert scenario.execution.unitree == places
    assert check(tmp_path / "s").violations == ()
    with pytest.raises(InputError, match=r"execution\.unitree\.robots: expected the place of each"):
        record_live(
            tmp_path / "t", name="lab", models=[GO1, GO1], starts=STARTS, area=AREA, rate=20.0,
            backend="unitree",
        )  # fmt: skip


def test_values_that_no_scenario_has(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="backend"):
        record_live(
            tmp_path / "s", name="lab", models=[GO1], starts=STARTS[:1], area=AREA, rate=20.0,
            backend="telepathy",
        )  # fmt: skip


def test_show_of_a_folder_takes_no_options_of_scenarios(tmp_path: Path) -> None:
    assert run_command(["show", str(tmp_path), "--seed", "3"]) == 2
