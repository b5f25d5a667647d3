"""Where there is no room for two: somebody waits, or makes way though it was there already."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from cavalcade.coordination import METHODS, TeamPlan, TeamProblem, plan_team, problem_of
from cavalcade.scenario import build_world, load_scenario

LEFT = math.pi


def late(problem: TeamProblem, plan: TeamPlan) -> float:
    """How much longer the plan takes than its slowest robot would alone, s."""
    alone = [
        plan_team(replace(problem, models=(m,), starts=(a,), goals=(b,))).trajectories[0].duration
        for m, a, b in zip(problem.models, problem.starts, problem.goals, strict=True)
    ]
    return max(t.duration for t in plan.trajectories) - max(alone)


@pytest.mark.parametrize("method", METHODS)
def test_the_alcove(judged, method):
    scenario = load_scenario("alcove")
    problem = problem_of(scenario, build_world(scenario))
    plan = plan_team(problem, method)
    judged(problem, plan)
    assert late(problem, plan) > 0.1


def _bay(make_team_of_words, models: tuple[str, str]) -> TeamProblem:
    """A corridor of 0.5 m with a bay near its left end; the ends are exchanged."""
    robots = [
        (models[0], (0.7, 0.25, 0.0), (8.3, 0.25, 0.0)),
        (models[1], (8.3, 0.25, LEFT), (0.7, 0.25, LEFT)),
    ]
    boxes = [((0.75, 1.0), (1.5, 1.0)), ((6.15, 1.0), (5.7, 1.0))]
    return make_team_of_words((9.0, 1.5), robots, boxes)


@pytest.mark.parametrize("models", [("go1", "go1"), ("unicycle", "spirit")])
def test_one_waits_in_a_bay(make_team_of_words, judged, models):
    problem = _bay(make_team_of_words, models)
    plan = plan_team(problem)
    judged(problem, plan)
    # The left robot is at the bay long before the other one.
    assert late(problem, plan) > 2.0


def _doorway(make_team_of_words) -> TeamProblem:
    """A wall with one door: two come from either side."""
    robots = [
        ("go1", (1.0, 1.0, 0.0), (5.0, 1.0, 0.0)),
        ("go1", (1.0, 3.0, 0.0), (5.0, 3.0, 0.0)),
        ("go1", (5.0, 1.8, LEFT), (1.0, 1.8, LEFT)),
        ("go1", (5.0, 2.4, LEFT), (1.0, 2.4, LEFT)),
    ]
    return make_team_of_words(
        (6.0, 4.0), robots, [((3.0, 0.8), (0.3, 1.6)), ((3.0, 3.2), (0.3, 1.6))]
    )


@pytest.mark.parametrize("method", METHODS)
def test_four_take_turns_at_a_door(make_team_of_words, judged, method):
    problem = _doorway(make_team_of_words)
    judged(problem, plan_team(problem, method))


def _occupied(make_team_of_words, swapped: bool) -> TeamProblem:
    """A robot stands at its own goal, in a corridor that the other one has to pass."""
    robots = [
        ("unicycle-sphere", (0.5, 1.75, 0.0), (4.0, 1.75, 0.0)),
        ("unicycle-sphere", (2.0, 1.75, 0.0), (2.0, 1.75, 0.0)),
    ]
    boxes = [((1.25, 0.55), (2.5, 1.0)), ((1.25, 3.0), (2.5, 1.0))]
    return make_team_of_words((4.5, 3.5), robots[::-1] if swapped else robots, boxes)


@pytest.mark.parametrize(
    ("method", "swapped"), [*((method, False) for method in METHODS), ("auto", True)]
)
def test_who_is_there_already_makes_way(make_team_of_words, judged, method, swapped):
    problem = _occupied(make_team_of_words, swapped)
    plan = plan_team(problem, method)
    judged(problem, plan)
    assert plan.trajectories[0 if swapped else 1].length > 0.5


def test_ends_of_a_dead_end_are_filled_from_behind(make_team_of_words, judged):
    """Who has to stand at the far end goes in first, whatever its number."""
    robots = [
        ("go1", (0.8, 1.0, 0.0), (5.0, 2.0, 0.0)),
        ("go1", (0.8, 2.0, 0.0), (6.5, 2.0, 0.0)),
        ("go1", (0.8, 3.0, 0.0), (8.0, 2.0, 0.0)),
    ]
    boxes = [((6.5, 0.85), (5.0, 1.7)), ((6.5, 3.15), (5.0, 1.7))]
    problem = make_team_of_words((9.0, 4.0), robots, boxes)
    for method in ("auto", "cbs", "sequential"):
        judged(problem, plan_team(problem, method))
