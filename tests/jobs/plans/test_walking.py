"""Plans carried out on legs."""

from __future__ import annotations

import pytest

import cavalcade as cv
from cavalcade.checking import check

pytest.importorskip("mujoco")

GO1 = ["robots.*.model=go1"]


def test_a_shipped_swap_is_walked_and_the_checker_agrees(tmp_path):
    run = cv.run(
        "head-on",
        tmp_path / "a",
        overrides=GO1,
        backend="mujoco",
        figures=False,
        replay=False,
    )
    summary = run.summary
    assert (summary["success"], summary["reason"]) == (True, "arrived")
    assert summary["falls"] == 0
    assert summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    assert max(summary["goal_error_m"]) < 0.05
    # The plan leaves room, and bodies stay within it.
    assert summary["min_footprint_gap_m"] > 0.10
    report = check(tmp_path / "a")
    assert report.ok, report.violations
    assert not any(
        model.description is None
        for model in cv.load_scenario(tmp_path / "a" / "scenario.yaml").models
    )


@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_plans_for_legs_are_made_with_the_margin_that_is_said(margin):
    said = [*GO1, "execution.backend=mujoco", f"planner.margin={margin}"]
    found = cv.plan(cv.load_scenario("head-on", overrides=said))
    assert found.plan.margins == ((margin,) * 2 if margin else ())


def test_without_a_word_only_legs_get_room():
    plain = cv.plan(cv.load_scenario("head-on", overrides=GO1))
    assert plain.plan.margins == ()
    said = [*GO1, "execution.backend=mujoco"]
    assert cv.plan(cv.load_scenario("head-on", overrides=said)).plan.margins == (0.05, 0.05)
