from __future__ import annotations

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.execution.fleets import tracking_model
from cavalcade.jobs import tasks
from cavalcade.jobs.planning import make_plan
from cavalcade.recording.plan_file import read_plan
from cavalcade.robots import robot_model


@pytest.fixture
def carried(make_scenario, straight_team, monkeypatch):
    """Runs a scenario whose plan comes from a given coordinator."""

    def go(coordinator=None, out=None, **options):
        chosen = coordinator or straight_team()
        monkeypatch.setattr(
            tasks,
            "make_plan",
            lambda scenario, world, reporter=None: make_plan(scenario, world, chosen, reporter),
        )
        return cv.run(make_scenario(**options), out)

    return go


def test_ideal_robots_follow_the_plan(carried, straight_team, make_scenario):
    result = carried()
    assert result.reason == "arrived"
    world = cv.build_world(make_scenario())
    paths = straight_team()(make_scenario(), world).trajectories
    recording = result.recording
    for robot, path in enumerate(paths):
        off = recording.poses[:, robot] - path.poses_at(recording.time)
        assert np.hypot(off[:, 0], off[:, 1]).max() < 0.01
        assert np.abs(off[:, 2]).max() < 0.01
    assert result.summary["goal_error_m"] == pytest.approx([0.0, 0.0], abs=0.01)
    assert result.summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    # Arrived for half a second, and then no cycle more.
    assert recording.time[-1] == pytest.approx(result.summary["makespan_s"] + 0.5, abs=1.0)


def test_a_run_leaves_everything(carried, tmp_path):
    out = tmp_path / "run"
    carried(out=out)
    for name in ("scenario.yaml", "summary.json", "recording.mcap", "plan.npz", "replay.html"):
        assert (out / name).stat().st_size > 0
    assert {p.name for p in (out / "figures").iterdir()} >= {"plan.png", "timing.png"}
    assert sorted(read_plan(out)[0]) == [0, 1]
    read = cv.read_recording(out)
    assert read.poses.shape[1:] == (2, 3)
    np.testing.assert_allclose(read.status[-1].targets[0], (7.0, 3.0, 0.0), atol=1e-6)
    report = cv.check(out)
    assert report.ok, report.violations


def test_without_a_plan_nobody_moves(carried, no_plan, tmp_path):
    result = carried(no_plan, tmp_path / "run")
    assert (result.success, result.reason) == (False, "infeasible")
    assert result.summary["detail"] == "the goal of robot 1 is shut off"
    assert len(result.recording.time) == 1
    assert result.summary["makespan_s"] is None


def test_what_formations_alone_have_is_null(carried):
    summary = carried().summary
    assert summary["leader_changes"] is summary["role_changes"] is None
    assert summary["formation_error_m"] == {"mean": None, "p95": None, "max": None}
    assert summary["planning_time_s"] == 0.25


def test_a_search_budget_does_not_end_the_run(carried):
    assert carried(budget={"iterations": 5}).reason == "arrived"


@pytest.mark.parametrize("model", ["unicycle", "unicycle-2", "single-integrator", "go1"])
def test_robots_of_all_drives_follow(carried, model, straight_team):
    ways = [((1.0, 3.0, 0.0), (3.0, 3.0, 0.0))]

    def slow(scenario, world):
        """At half the speed, which all of them reach."""
        plan = straight_team(waits=(0.5,))(scenario, world)
        path = plan.trajectories[0]
        slower = type(path)(
            2.0 * path.time, path.position, 0.5 * path.velocity, path.yaw, path.phase
        )
        return type(plan)("solved", "", (), (slower,), "cbs", 1, 0.0)

    result = carried(slow, robots=ways, model=model)
    assert result.reason == "arrived"
    assert result.summary["goal_error_m"][0] < 0.02


def test_unicycles_do_not_slide():
    model = tracking_model(robot_model("unicycle"), leaps=False)
    assert model.max_speed_y <= 1e-3
    assert model.max_speed_x == robot_model("unicycle").max_speed_x


def test_legged_robots_have_the_limits_of_plans_not_of_formations():
    model, legs = robot_model("spirit"), robot_model("spirit").legs
    walking, leaping = tracking_model(model, False), tracking_model(model, True)
    assert walking.max_speed_x == legs.v_max > model.max_speed_x
    assert walking.max_acceleration == pytest.approx(legs.mu * 9.81)
    assert leaping.max_acceleration == pytest.approx(legs.mu * 9.81 * legs.grf_max)


@pytest.mark.slow
def test_a_shipped_team_arrives(tmp_path):
    result = cv.run("corner-swap", tmp_path / "run", figures=False, replay=False)
    assert result.reason == "arrived"
    report = cv.check(tmp_path / "run")
    assert report.ok, report.violations
