from __future__ import annotations

import json

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.errors import InputError, OutputError
from cavalcade.execution.loop import Outcome
from cavalcade.metrics.plan_summary import as_recording
from cavalcade.metrics.run_summary import summarise
from cavalcade.recording.plan_file import read_plan
from cavalcade.scenario import load_scenario

FILES = {
    "scenario.yaml",
    "summary.json",
    "plan.npz",
    "replay.html",
    "figures/plan.png",
    "figures/timing.png",
    "figures/footholds.png",
}


def names(folder) -> set[str]:
    return {str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file()}


def test_a_plan_leaves_its_folder(make_scenario, straight_team, tmp_path):
    out = tmp_path / "plan"
    result = cv.plan(make_scenario(), out, coordinator=straight_team())
    assert result.solved
    assert result.reason == "solved"
    assert names(out) == FILES
    assert {str(file.relative_to(out)) for file in result.files} == FILES
    assert json.loads((out / "summary.json").read_text()) == result.summary
    assert load_scenario(out / "scenario.yaml").goals == make_scenario().goals
    paths, feet = read_plan(out)
    for robot, path in enumerate(result.trajectories):
        np.testing.assert_array_equal(paths[robot].position, path.position)
        np.testing.assert_array_equal(feet[robot], result.footholds[robot])
        assert len(result.footholds[robot]) > 20


def test_without_a_folder_nothing_is_written(make_scenario, straight_team, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = cv.plan(make_scenario(), coordinator=straight_team())
    assert result.solved
    assert result.files == ()
    assert result.directory is None
    assert list(tmp_path.iterdir()) == []


def test_the_summary_has_every_key_that_a_runs_has(make_scenario, straight_team):
    scenario = make_scenario()
    summary = cv.plan(scenario, coordinator=straight_team()).summary
    world = cv.build_world(scenario)
    recording = as_recording(straight_team()(scenario, world).trajectories)
    outcome = Outcome("arrived", "", (), 0.0, np.zeros(len(recording.time)))
    assert set(summarise(scenario, world, recording, outcome)) <= set(summary)


def test_the_summarys_figures(make_scenario, straight_team):
    summary = cv.plan(make_scenario(), coordinator=straight_team()).summary
    assert summary["path_length_m"] == pytest.approx([6.0, 4.0], abs=1e-6)
    assert summary["lower_bound_m"] == pytest.approx([6.0, 4.0], abs=1e-6)
    # 6 m at 0.75 m/s and 0.75 s more for speeding up and slowing down at 1 m/s².
    assert summary["duration_s"] == pytest.approx([8.75, 4.0 + 4.0 / 0.75 + 0.75], abs=1e-6)
    assert summary["makespan_s"] == max(summary["duration_s"])
    assert summary["goal_error_m"] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    assert summary["min_obstacle_distance_m"] == pytest.approx(1.0, abs=1e-6)
    assert 0.0 < summary["min_footprint_gap_m"] < summary["min_robot_distance_m"]
    assert summary["method"] == "auto"
    assert summary["found_by"] == "cbs"
    assert summary["footholds"]["out_of_reach"] == 0
    for key in ("backend", "sim_time_s", "leader_changes", "role_changes"):
        assert summary[key] is None


def test_a_plan_that_collides_is_no_success(make_scenario, straight_team):
    # The second robot is in the crossing when the first one comes.
    result = cv.plan(make_scenario(), coordinator=straight_team(waits=(0.0, 1.2)))
    assert result.plan.solved
    assert not result.solved
    assert result.reason == "collision"
    assert result.summary["collisions"]["robot_robot"] == 1
    assert result.summary["min_footprint_gap_m"] == 0.0


def test_no_plan_is_a_result_with_its_reason(make_scenario, no_plan, tmp_path):
    result = cv.plan(make_scenario(), tmp_path / "none", coordinator=no_plan)
    assert (result.solved, result.reason) == (False, "infeasible")
    assert result.summary["detail"] == "the goal of robot 1 is shut off"
    assert result.summary["involved"] == [1]
    for key in ("makespan_s", "min_robot_distance_m", "min_footprint_gap_m"):
        assert result.summary[key] is None
    assert result.summary["path_length_m"] == [None, None]
    assert result.summary["lower_bound_m"] == pytest.approx([6.0, 4.0], abs=1e-6)
    assert read_plan(tmp_path / "none") == ({}, {})
    assert (tmp_path / "none" / "figures" / "plan.png").stat().st_size > 5000


def test_the_method_may_be_given(make_scenario, straight_team, tmp_path):
    out = tmp_path / "plan"
    result = cv.plan(
        make_scenario(), out, method="joint", figures=False, replay=False,
        coordinator=straight_team(),
    )  # fmt: skip
    assert result.summary["method"] == "joint"
    assert load_scenario(out / "scenario.yaml").planner.method == "joint"
    with pytest.raises(InputError, match=r"method: unknown method 'magic' \(one of: sequential"):
        cv.plan(make_scenario(), method="magic")


def test_the_seed_may_be_given(make_scenario, straight_team):
    assert cv.plan(make_scenario(), seed=5, coordinator=straight_team()).summary["seed"] == 5


def test_a_formation_is_refused():
    with pytest.raises(InputError, match=r"task\.goals: plan is for robots with goals of their"):
        cv.plan("square-clutter")


def test_a_folder_that_holds_something_is_refused(make_scenario, straight_team, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="not empty"):
        cv.plan(make_scenario(), tmp_path, coordinator=straight_team())
    cv.plan(make_scenario(), tmp_path, force=True, coordinator=straight_team())
    assert names(tmp_path) == {*FILES, "mine.txt"}


def test_nothing_is_left_of_a_job_that_fails(make_scenario, tmp_path):
    def broken(scenario, world):
        raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        cv.plan(make_scenario(), tmp_path / "a" / "b", coordinator=broken)
    assert list(tmp_path.iterdir()) == []


def test_what_is_said_on_the_way(make_scenario, straight_team, no_plan, tmp_path, capsys):
    cv.plan(make_scenario(), tmp_path / "a", quiet=False, coordinator=straight_team())
    said = capsys.readouterr().out
    for text in ("2 robots, method auto", "solved", "× the shortest ways alone", "replay.html"):
        assert text in said
    cv.plan(make_scenario(), quiet=False, coordinator=no_plan)
    assert "infeasible (the goal of robot 1 is shut off)" in capsys.readouterr().out


@pytest.mark.slow
def test_a_real_plan_is_clean_and_the_same_every_time(tmp_path):
    for name in ("a", "b"):
        assert cv.plan("head-on", tmp_path / name, seed=3, figures=False, replay=False).solved
        report = cv.check(tmp_path / name)
        assert report.ok, report.violations
    assert (tmp_path / "a/plan.npz").read_bytes() == (tmp_path / "b/plan.npz").read_bytes()
    one, other = (json.loads((tmp_path / n / "summary.json").read_text()) for n in "ab")
    for key in ("wall_time_s", "planning_time_s"):
        del one[key], other[key]
    assert one == other
