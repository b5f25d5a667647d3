"""One clearance at starts and goals: refused before planning, or planned without contact."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from cavalcade.coordination import PlanSettings, plan_team
from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.robot_planner import FlatPlanner, Span
from cavalcade.errors import ScenarioError
from cavalcade.geometry import CLEARANCE
from cavalcade.lattice.planner import SpaceTimePlanner

GAPS = (0.0, 1e-6, 1e-4, 0.5e-3, 0.99e-3, 1e-3, 1.01e-3, 1.5e-3, 2e-3, 3e-3, 5e-3, 0.01, 0.05)
ROOM, FAR = (6.0, 4.0), (4.0, 2.0, 0.0)
BOX = ((2.0, 1.0), (1.0, 1.0))


def enough(gap: float) -> bool:
    return gap >= CLEARANCE - 1e-6


@pytest.mark.parametrize("gap", GAPS)
@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, 0.3])
def test_starts_beside_a_box(make_team_of_words, footprint_gap, gap, yaw):
    # The lowest point of the body is `gap` above the box.
    reach = 0.325 * abs(math.sin(yaw)) + 0.14 * abs(math.cos(yaw))
    robots = [("go1", (2.0, 1.5 + reach + gap, yaw), FAR)]
    if not enough(gap):
        with pytest.raises(ScenarioError, match=r"robots\[0\]\.start.*world\.obstacles\[0\].*1 mm"):
            make_team_of_words(ROOM, robots, [BOX])
        return
    problem = make_team_of_words(ROOM, robots, [BOX])
    plan = plan_team(problem)
    assert plan.solved, plan.detail
    assert plan.iterations < 5_000
    assert _least_gap(footprint_gap, problem, plan) > 1e-6


@pytest.mark.parametrize("gap", GAPS)
@pytest.mark.parametrize("beside", ["border", "box", "robot"])
def test_goals_beside_something(make_team_of_words, footprint_gap, gap, beside):
    # Nose first: nobody can turn into a place that is hardly wider than the body.
    places = {
        "border": (5.675 - gap, 3.0, 0.0),
        "box": (2.0, 1.825 + gap, -math.pi / 2),
        "robot": (3.35 - gap, 2.0, 0.0),
    }
    robots = [("go1", (2.0, 3.0, 0.0), places[beside])]
    if beside == "robot":
        robots.append(("go1", (1.0, 2.5, 0.0), FAR))
    problem = make_team_of_words(ROOM, robots, [BOX])
    plan = plan_team(problem, settings=PlanSettings(seconds=60.0))
    if enough(gap):
        assert plan.solved, plan.detail
        assert _least_gap(footprint_gap, problem, plan) > 1e-6
    else:
        assert (plan.reason, plan.iterations) == ("infeasible", 0)
        assert 0 in plan.involved


@pytest.mark.parametrize("method", ["auto", "sequential", "cbs", "joint"])
@pytest.mark.parametrize("gap", [0.0, 0.9e-3, 1e-3, 2e-3, 3e-3])
def test_pairs_side_by_side(make_team_of_words, judged, gap, method):
    robots = [
        ("go1", (2.0, 2.0, 0.0), (5.0, 2.0, 0.0)),
        ("go1", (2.0, 2.28 + gap, 0.0), (5.0, 3.2, 0.0)),
    ]
    if not enough(gap):
        with pytest.raises(ScenarioError, match=r"robots\[1\]\.start.*robot 0.*1 mm"):
            make_team_of_words(ROOM, robots)
        return
    problem = make_team_of_words(ROOM, robots)
    judged(problem, plan_team(problem, method))


@pytest.mark.parametrize("gap", [1e-3, 2e-3, 5e-3, 0.02])
@pytest.mark.parametrize("where", ["goals", "both", "in a row"])
def test_pairs_that_cannot_turn_were_not_found_in_the_product_space(
    make_team_of_words, judged, gap, where
):
    left, right = (2.0, 2.0, 0.0), (2.0, 2.28 + gap, 0.0)
    ends = {
        "goals": ([left, (2.0, 3.2, 0.0)], [(5.0, 2.0, 0.0), (5.0, 2.28 + gap, 0.0)]),
        "both": ([left, right], [(5.0, 2.28 + gap, 0.0), (5.0, 2.0, 0.0)]),
        "in a row": ([left, (2.65 + gap, 2.0, 0.0)], [(5.0, 1.0, 0.0), (5.0, 3.0, 0.0)]),
    }
    robots = [("go1", start, goal) for start, goal in zip(*ends[where], strict=True)]
    problem = make_team_of_words(ROOM, robots)
    judged(problem, plan_team(problem, "joint", PlanSettings(iterations=200_000)))


@pytest.mark.parametrize("gap", [3e-3, 5e-3, 0.01, 0.02])
@pytest.mark.parametrize("ends", ["start", "goal"])
def test_places_along_a_wall_were_searched_for_in_vain(make_team_of_words, judged, gap, ends):
    """No turn of the search's fits there."""
    wall, free = (4.0, 0.14 + gap, 0.0), (2.0, 2.0, 0.0)
    start, goal = (wall, free) if ends == "start" else (free, wall)
    problem = make_team_of_words(ROOM, [("go1", start, goal)])
    judged(problem, plan_team(problem, settings=PlanSettings(iterations=200_000)))


def test_a_place_along_a_wall_is_led_into_past_others(make_team_of_words, judged):
    robots = [
        ("go1", (2.0, 2.0, 0.0), (4.0, 0.15, 0.0)),
        ("go1", (4.0, 2.0, 0.0), (1.0, 2.0, 0.0)),
        ("go1", (2.0, 0.16, 0.0), (4.5, 3.0, 0.0)),
    ]
    problem = make_team_of_words(ROOM, robots)
    judged(problem, plan_team(problem, settings=PlanSettings(iterations=400_000)))


@pytest.mark.parametrize("gap", [0.8e-3, 1.5e-3, 1.9e-3])
def test_a_start_beside_a_wall_let_robots_pass_each_other_in_conflict(make_team_of_words, gap):
    """The passage between the box and the other is too narrow: the path leads round the other."""
    robots = [
        ("go1", (2.0, 1.1409995, 0.0), (5.4, 3.0, 0.0)),
        ("go1", (3.2, 1.421 + gap, 0.0), (5.4, 1.0, 0.0)),
    ]
    problem = make_team_of_words(ROOM, robots, [((2.75, 0.5), (2.5, 1.0))])
    standing = np.array([problem.starts[1]])
    planner = FlatPlanner(problem, SpaceTimePlanner(problem.ground))
    path = planner.plan(0, [Span(1, standing)], Budget(200_000))
    assert path is not None
    assert conflicts_of([path.track, standing], problem.models) == []


@pytest.mark.parametrize("method", ["auto", "sequential", "cbs", "joint"])
def test_a_goal_that_touches_the_wall_is_refused_at_once(make_team_of_words, method):
    """Such a one was searched for until long after the limit of time."""
    problem = make_team_of_words(ROOM, [("go1", (2.0, 2.0, 0.0), (4.0, 0.14, 0.0))])
    plan = plan_team(problem, method, PlanSettings(seconds=10.0))
    assert (plan.reason, plan.iterations) == ("infeasible", 0)
    assert "border" in plan.detail


def _least_gap(gap, problem, plan) -> float:
    """To the border, the box and each other, at every 5 ms."""
    time = np.arange(0.0, max(t.duration for t in plan.trajectories) + 0.01, 0.005)
    shapes = [(model.length / 2, model.width / 2, False) for model in problem.models]
    poses = [
        np.column_stack(
            [
                np.interp(time, t.time, t.position[:, 0]),
                np.interp(time, t.time, t.position[:, 1]),
                np.interp(time, t.time, t.yaw),
            ]
        )
        for t in plan.trajectories
    ]

    def boxes_gap(i: int, center: tuple[float, float], size: tuple[float, float]) -> float:
        there = np.repeat([[*center, 0.0]], len(time), axis=0)
        return gap(shapes[i], poses[i], (size[0] / 2, size[1] / 2, False), there).min()

    # The border as walls around the room.
    width, height = ROOM
    walls = [((x, height / 2), (2.0, height + 4.0)) for x in (-1.0, width + 1.0)]
    walls += [((width / 2, y), (width + 4.0, 2.0)) for y in (-1.0, height + 1.0)]
    boxes = [*walls, *((shape.center, shape.size) for shape in problem.shapes)]
    pairs = itertools.combinations(range(len(poses)), 2)
    return min(
        *(boxes_gap(i, center, size) for i in range(len(poses)) for center, size in boxes),
        *(gap(shapes[i], poses[i], shapes[j], poses[j]).min() for i, j in pairs),
    )
