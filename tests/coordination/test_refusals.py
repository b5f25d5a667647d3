"""What has no plan is refused at once with the reason; what is bad input, by name."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from cavalcade.coordination import METHODS, PlanSettings, TeamProblem, plan_team
from cavalcade.errors import InputError
from cavalcade.lattice.ground import make_ground
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

A, B = (2.0, 2.0, 0.0), (7.0, 2.0, 0.0)
C, D = (2.0, 3.0, 0.0), (7.0, 3.0, 0.0)


@pytest.fixture(scope="module", autouse=True)
def _warm(make_team) -> None:
    """Kernels are loaded before anything is timed."""
    for method in METHODS:
        plan_team(make_team([("go1", A, B), ("go1", B, A)]), method)


CASES = [
    # robots, boxes, words of the reason, who it is about
    (
        [("go1", A, B), ("go1", C, (20.0, 3.0, 0.0))],
        (),
        "the goal of robot 1 is off the map or on its border",
        (1,),
    ),
    (
        [("go1", A, B), ("go1", C, (8.8, 3.0, 0.0))],
        (),
        "the goal of robot 1 is off the map or on its border",
        (1,),
    ),
    (
        [("go1", A, (5.0, 2.0, 0.0)), ("go1", C, D)],
        ((4.9, 1.9, 5.1, 2.1),),
        "the goal of robot 0 is in or touches an occupied cell of the map (0.05 m wide)",
        (0,),
    ),
    (
        # The trunk's middle is free, a corner is not.
        [("go1", A, (5.0, 2.0, 0.0)), ("go1", C, D)],
        ((5.25, 2.1, 5.5, 2.3),),
        "the goal of robot 0 is in or touches an occupied cell of the map (0.05 m wide)",
        (0,),
    ),
    (
        [("go1", A, B), ("spirit", C, (7.2, 2.2, 1.0))],
        (),
        "the goals of robots 0 and 1 overlap or touch",
        (0, 1),
    ),
    (
        [("go1", A, B), ("go1", (2.3, 2.2, 1.0), D)],
        (),
        "the starts of robots 0 and 1 overlap or touch",
        (0, 1),
    ),
    (
        [("go1", (5.0, 2.0, 0.0), B), ("go1", C, D)],
        ((4.9, 1.9, 5.1, 2.1),),
        "the start of robot 0 is in or touches an occupied cell of the map (0.05 m wide)",
        (0,),
    ),
    (
        [("go1", A, B), ("go1", C, D)],
        ((4.0, 0.0, 4.2, 4.0),),
        "no way leads robot 0 to its goal, not even alone",
        (0,),
    ),
    (
        # Narrower than the body.
        [("double-integrator", A, B), ("spirit", C, D)],
        ((4.0, 0.0, 4.5, 1.5), (4.0, 1.8, 4.5, 4.0)),
        "no way leads robot 1 to its goal, not even alone",
        (1,),
    ),
]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("robots", "boxes", "words", "who"), CASES)
def test_what_is_infeasible_is_refused_at_once(make_team, method, robots, boxes, words, who):
    problem = make_team(robots, (9.0, 4.0), boxes)
    plan = plan_team(problem, method)
    assert (plan.reason, plan.detail, plan.involved) == ("infeasible", words, who)
    assert not plan.solved
    assert plan.trajectories == (None, None)
    assert plan.iterations == 0


def test_walled_in_on_a_large_map(make_team):
    """A proof, not a search that gives up, of a robot in a closed room."""
    walls = [(8.0, 8.0, 12.0, 8.2), (8.0, 11.8, 12.0, 12.0)]
    walls += [(8.0, 8.0, 8.2, 12.0), (11.8, 8.0, 12.0, 12.0)]
    robots = [("spirit", (10.0, 10.0, 0.0), A), ("spirit", (5.0, 5.0, 0.0), D)]
    problem = make_team(robots, (20.0, 20.0), walls)
    plan = plan_team(problem, "auto")
    assert (plan.reason, plan.involved, plan.iterations) == ("infeasible", (0,), 0)


@pytest.mark.parametrize("method", METHODS)
def test_a_millimetre_from_the_border_is_enough(make_team, judged, method):
    robots = [
        ("go1", (0.326, 0.141, 0.0), (8.674, 0.141, 0.0)),
        ("unicycle-sphere", (0.401, 3.599, 0.0), (8.599, 3.599, 0.0)),
    ]
    problem = make_team(robots)
    judged(problem, plan_team(problem, method))


@pytest.mark.parametrize("method", METHODS)
def test_bodies_may_stand_half_a_centimetre_apart(make_team, judged, method):
    robots = [
        ("go1", (2.0, 2.0, 0.0), (5.0, 2.0, 0.0)),
        ("go1", (2.655, 2.0, 0.0), (5.655, 2.0, 0.0)),
        ("go1", (2.0, 2.285, math.pi), (1.0, 2.285, math.pi)),
    ]
    problem = make_team(robots)
    judged(problem, plan_team(problem, method))


@pytest.mark.parametrize("method", METHODS)
def test_a_budget_of_one_iteration_is_soon_spent(make_team, method):
    boxes = ((4.0, 0.0, 4.3, 2.6),)
    problem = make_team([("go1", A, B), ("go1", B, A)], (9.0, 4.0), boxes)
    plan = plan_team(problem, method, PlanSettings(iterations=1))
    assert plan.reason == "budget"
    assert not plan.solved
    assert "1 iterations are used up" in plan.detail
    assert "\n" not in plan.detail


def test_what_is_known_of_single_robots_is_kept_when_the_budget_is_spent(make_team):
    problem = make_team([("go1", A, B), ("go1", (7.0, 2.0, math.pi), (2.0, 2.0, math.pi))])
    plan = plan_team(problem, "cbs", PlanSettings(iterations=3))
    assert plan.reason == "budget"
    assert plan.detail.startswith("no plan without conflicts was found; ")
    assert all(t is not None and t.length == pytest.approx(5.0) for t in plan.trajectories)


@pytest.mark.parametrize("method", METHODS)
def test_time_is_a_limit_of_its_own(make_team, method):
    problem = make_team([("go1", A, B), ("go1", B, A)], (9.0, 4.0), ((4.0, 0.0, 4.3, 2.6),))
    begin = time.perf_counter()
    plan = plan_team(problem, method, PlanSettings(seconds=1e-9))
    assert time.perf_counter() - begin < 2.0
    if not plan.solved:
        assert plan.reason == "budget"
        assert plan.detail.endswith("1e-09 s are over")
    # With time enough, the limit changes nothing.
    free, timed = (plan_team(problem, method, PlanSettings(seconds=s)) for s in (None, 600.0))
    assert free.iterations == timed.iterations


def test_unknown_methods_are_named_with_those_there_are(make_team):
    with pytest.raises(InputError, match=r"unknown method 'best'.*auto.*sequential.*joint.*cbs"):
        plan_team(make_team([("go1", A, B)]), "best")


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (PlanSettings(iterations=0), "planner.budget.iterations"),
        (PlanSettings(iterations=-5), "planner.budget.iterations"),
        (PlanSettings(seconds=0.0), "planner.budget.seconds"),
        (PlanSettings(seconds=math.nan), "planner.budget.seconds"),
    ],
)
def test_a_budget_of_nothing_is_bad_input(make_team, settings, key):
    with pytest.raises(InputError) as caught:
        plan_team(make_team([("go1", A, B)]), "auto", settings)
    assert caught.value.key == key


def test_only_robots_with_legs_are_planned_as_published(make_team):
    problem = make_team([("unicycle", A, B)])
    with pytest.raises(InputError, match="robots with legs"):
        plan_team(problem, "cbs", PlanSettings(variant="published"))


def test_a_single_cell_is_off_the_map_for_everybody():
    ground = make_ground(OccupancyMap(np.zeros((1, 1), dtype=bool), 0.05))
    pose = (0.025, 0.025, 0.0)
    problem = TeamProblem(ground, (robot_model("go1"),), (pose,), (pose,))
    assert plan_team(problem).reason == "infeasible"
