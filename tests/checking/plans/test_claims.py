"""What the summary claims against what the plan shows."""

from __future__ import annotations

import math

import numpy as np
import pytest


def only(report):
    (violation,) = report.violations
    return violation


@pytest.mark.parametrize(("off", "ok"), [(0.0005, True), (0.01, False)])
def test_the_start(walker, off, ok):
    walker.words["robots"][0]["start"][1] += off
    report = walker.report()
    assert report.ok == ok
    assert ok or only(report).kind == "start"


def test_the_heading_at_the_start(walker):
    walker.words["robots"][0]["start"][2] += 0.01
    assert only(walker.report()).kind == "start"


@pytest.mark.parametrize(
    ("key", "off", "ok"), [(0, 0.09, True), (0, 0.11, False), (2, 0.14, True), (2, -0.16, False)]
)
def test_the_goal(walker, key, off, ok):
    walker.words["robots"][0]["goal"][key] += off
    report = walker.report()
    assert report.ok == ok
    if not ok:
        violation = only(report)
        assert violation.kind == "arrival"
        assert violation.robots == (0,)
        assert violation.time == walker.arrays["t_0"][-1]


def test_a_whole_turn_more_is_the_same_goal(walker):
    walker.words["robots"][0]["goal"][2] += 2.0 * math.pi
    assert walker.report().ok


def test_a_goal_missed_by_a_plan_that_claims_nothing(walker):
    walker.words["robots"][0]["goal"][0] += 1.0
    walker.summary = {"success": False}
    assert walker.report().ok


def test_a_robot_without_a_plan_in_a_solved_one(maker, team):
    judged = team(maker((5.0, 5.0, 0.0)).walk(2.0), maker((5.0, 7.0, 0.0)).walk(2.0))
    judged.arrays = {k: v for k, v in judged.arrays.items() if not k.endswith("_1")}
    violation = only(judged.report())
    assert violation.kind == "plan"
    assert violation.robots == (1,)


@pytest.mark.parametrize("key", ["path_length_m", "duration_s"])
@pytest.mark.parametrize("claim", [[2.9], [None], None, [], [3.0, 3.0], ["3"], [True], [math.nan]])
def test_wrong_figures(walker, key, claim):
    walker.summary[key] = claim
    violation = only(walker.report())
    assert violation.kind == "summary"
    assert key in violation.message


@pytest.mark.parametrize("claim", [1.0, None, "soon"])
def test_a_wrong_makespan(walker, claim):
    walker.summary["makespan_s"] = claim
    assert "makespan_s" in only(walker.report()).message


def test_rounded_figures_are_right(walker):
    walker.summary["path_length_m"] = [round(walker.summary["path_length_m"][0], 3)]
    walker.summary["makespan_s"] = np.round(walker.summary["makespan_s"], 4)
    assert walker.report().ok
