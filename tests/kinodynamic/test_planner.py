"""Plans of one robot: judged by a slow reference, repeatable, refused where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground
from cavalcade.robots import robot_model

CROSSINGS = [
    ("gap", {"width": 0.2}),
    ("gap", {"width": 0.4}),
    ("step", {"height": 0.1}),
    ("step", {"height": 0.2}),
    ("step", {"height": 0.25}),
]
START, GOAL = (2.0, 2.0, 0.0), (7.0, 2.0, 0.0)


@pytest.mark.parametrize(("kind", "options"), CROSSINGS)
def test_one_leap_crosses_and_is_hardly_longer_than_the_straight_line(
    make_terrain, judged, model, kind, options
):
    ground = make_terrain(kind, **options)
    for seed in range(3):
        plan = plan_body(ground, model, START, GOAL, seed=seed)
        judged(plan, ground, model, START, GOAL)
        assert plan.trajectory.length <= 1.05 * 5.0
        assert (plan.trajectory.phase == 2).any()


def test_a_leap_up_and_one_down(make_terrain, judged, spirit):
    ground = make_terrain("step", height=0.2)
    plan = plan_body(ground, spirit, (7.0, 2.0, 3.0), (2.0, 1.5, 0.5))
    judged(plan, ground, spirit, (7.0, 2.0, 3.0), (2.0, 1.5, 0.5))


@pytest.mark.parametrize("kind", ["slope", "rough"])
def test_other_terrain(make_terrain, judged, spirit, kind):
    ground = make_terrain(kind, seed=3)
    plan = plan_body(ground, spirit, (1.0, 2.0, 1.0), (8.0, 2.0, 0.0))
    judged(plan, ground, spirit, (1.0, 2.0, 1.0), (8.0, 2.0, 0.0))


def test_flat_ground_gives_the_straight_line_at_once(make_flat, judged, model):
    ground = make_flat()
    start, goal = (1.0, 1.0, 2.0), (8.0, 3.0, -1.0)
    plan = plan_body(ground, model, start, goal)
    judged(plan, ground, model, start, goal)
    assert plan.iterations == 1
    assert plan.trajectory.length == pytest.approx(math.dist(start[:2], goal[:2]), rel=1e-9)


def test_among_obstacles(make_flat, judged, model):
    boxes = ((2.0, 0.0, 2.3, 2.6), (4.5, 1.2, 4.8, 4.0), (6.5, 0.0, 6.8, 3.0))
    ground = make_flat(boxes=boxes)
    start, goal = (1.0, 1.0, 0.0), (8.2, 0.8, 1.6)
    for seed in range(5):
        plan = plan_body(ground, model, start, goal, seed=seed)
        judged(plan, ground, model, start, goal)


def test_trees_find_the_way_where_the_robot_cannot_turn_everywhere(make_flat, judged, spirit):
    # A passage 0.5 m wide: less than the body's diagonal, more than its width.
    ground = make_flat(boxes=((4.0, 0.0, 6.0, 1.8), (4.0, 2.3, 6.0, 4.0)))
    start, goal = (1.0, 1.0, 0.0), (8.2, 0.8, 1.6)
    for seed in range(5):
        plan = plan_body(ground, spirit, start, goal, seed=seed)
        judged(plan, ground, spirit, start, goal)


def test_published_variant_leaps_and_keeps_its_rules(make_terrain, judged, spirit):
    ground = make_terrain("gap", width=0.2)
    settings = BodySettings(variant="published", iterations=5_000)
    solved = 0
    for seed in range(4):
        plan = plan_body(ground, spirit, START, GOAL, settings, seed=seed)
        if plan.solved:
            solved += 1
            judged(plan, ground, spirit, START, GOAL, published=True)
            assert (plan.trajectory.phase == 2).any()
    assert solved >= 2


def _mirrored(ground: Ground) -> Ground:
    flip = {
        name: np.ascontiguousarray(getattr(ground, name)[::-1])
        for name in ("solid", "clearance", "height", "smooth", "slope_x", "traversability")
    }
    return ground._replace(slope_y=np.ascontiguousarray(-ground.slope_y[::-1]), **flip)


@pytest.mark.parametrize(("kind", "options"), [("rough", {"seed": 5}), *CROSSINGS[1:4]])
def test_the_mirror_image_of_a_plan_is_valid_on_the_mirrored_ground(
    make_terrain, judged, spirit, kind, options
):
    from dataclasses import replace

    ground = make_terrain(kind, **options)
    start, goal = (1.0, 1.5, 0.4), (8.0, 2.7, -0.6)
    plan = plan_body(ground, spirit, start, goal, seed=1)
    t = plan.trajectory
    flip = np.array([1.0, -1.0, 1.0])
    position = t.position * flip + np.array([0.0, 4.0, 0.0])
    image = replace(t, position=position, velocity=t.velocity * flip, yaw=-t.yaw)
    judged(
        replace(plan, trajectory=image),
        _mirrored(ground),
        spirit,
        (start[0], 4.0 - start[1], -start[2]),
        (goal[0], 4.0 - goal[1], -goal[2]),
    )


@pytest.mark.parametrize("improve", [0, 600])
def test_same_seed_same_bytes(make_terrain, make_flat, spirit, improve):
    boxes = ((2.0, 0.0, 2.3, 2.6), (4.5, 1.2, 4.8, 4.0), (6.5, 0.0, 6.8, 3.0))
    settings = BodySettings(improve=improve)
    for ground in (make_terrain("gap"), make_flat(boxes=boxes)):
        one, two = (
            plan_body(ground, spirit, (1.0, 1.0, 0.0), (8.0, 1.0, 0.0), settings, seed=7)
            for _ in range(2)
        )
        for name in ("time", "position", "velocity", "yaw", "phase"):
            a, b = getattr(one.trajectory, name), getattr(two.trajectory, name)
            assert a.tobytes() == b.tobytes()
        assert np.array_equal(one.history, two.history)
        # A limit of time that is not reached changes nothing.
        timed = BodySettings(improve=improve, seconds=1e6)
        other = plan_body(ground, spirit, (1.0, 1.0, 0.0), (8.0, 1.0, 0.0), timed, seed=7)
        assert other.trajectory.position.tobytes() == one.trajectory.position.tobytes()


def test_improving_never_makes_it_longer_and_reports_each_gain(make_flat, judged, spirit):
    ground = make_flat(boxes=((2.0, 0.0, 2.3, 2.6), (4.5, 1.2, 4.8, 4.0), (6.5, 0.0, 6.8, 3.0)))
    start, goal = (1.0, 1.0, 0.0), (8.2, 0.8, 1.6)
    first = plan_body(ground, spirit, start, goal)
    better = plan_body(ground, spirit, start, goal, BodySettings(improve=2_000))
    judged(better, ground, spirit, start, goal)
    assert better.trajectory.length <= first.trajectory.length + 1e-9
    assert better.iterations > first.iterations
    later = better.history[1:]
    assert (np.diff(later[:, 0]) >= 0.0).all()
    assert (np.diff(later[1:, 1]) < 0.0).all()
    assert better.history[-1, 1] == pytest.approx(better.trajectory.length, abs=2e-3)


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ((9.5, 2.0, 0.0), "the goal is off the map"),
        ((8.9, 2.0, 0.0), "the goal is in an obstacle or over the map's edge"),
        ((4.6, 2.0, 0.0), "the goal is in a hole"),
    ],
)
def test_goals_where_nothing_can_stand_are_refused_at_once(make_terrain, spirit, goal, words):
    plan = plan_body(make_terrain("gap", width=0.4), spirit, START, goal)
    assert (plan.reason, plan.detail, plan.trajectory) == ("infeasible", words, None)
    back = plan_body(make_terrain("gap", width=0.4), spirit, goal, START)
    assert back.detail == words.replace("goal", "start")
    assert plan.iterations == 0


def test_a_wall_is_proven_to_shut_the_goal_off(make_flat, spirit):
    ground = make_flat(boxes=((4.0, 0.0, 4.2, 4.0),))
    plan = plan_body(ground, spirit, START, GOAL)
    assert plan.reason == "infeasible"
    assert plan.detail == "no way between the obstacles is wide enough"
    assert plan.planning_time < 5.0  # with compilation not; iterations tell it better
    assert plan.iterations <= 200


def test_without_leaps_a_gap_is_proven_to_shut_the_goal_off(make_terrain, judged, spirit):
    ground = make_terrain("gap", width=0.4)
    plan = plan_body(ground, spirit, START, GOAL, BodySettings(leaps=False))
    assert (plan.reason, plan.detail[:22]) == ("infeasible", "no way over the ground")


def test_a_chasm_is_proven_too_wide_for_any_leap(make_flat, spirit):
    height = np.zeros((80, 240))
    height[:, 90:210] = -1.0
    traversable = np.ones_like(height)
    traversable[:, 88:212] = 0.0
    base = make_flat(12.0, 4.0)
    zeros = np.zeros_like(height)
    ground = base._replace(
        flat=False,
        height=height,
        smooth=zeros,
        slope_x=zeros,
        slope_y=zeros,
        traversability=traversable,
    )
    plan = plan_body(ground, spirit, (1.0, 2.0, 0.0), (11.3, 2.0, 0.0))
    assert plan.reason == "infeasible"


def test_discs_are_kept_out_of(make_flat, judged, spirit):
    ground = make_flat()
    discs = np.array([[4.5, 2.0, 0.6], [3.0, 2.5, 0.4]])
    plan = plan_body(ground, spirit, START, GOAL, BodySettings(discs=discs))
    judged(plan, ground, spirit, START, GOAL)
    for x, y, radius in discs:
        away = np.hypot(plan.trajectory.position[:, 0] - x, plan.trajectory.position[:, 1] - y)
        assert away.min() >= radius - 1e-9
    shut = BodySettings(discs=np.array([[7.2, 2.0, 0.6]]))
    plan = plan_body(ground, spirit, START, GOAL, shut)
    assert plan.detail == "the goal is within another robot's reach"


def test_no_budget_no_plan(make_flat, spirit):
    for settings in (BodySettings(iterations=0), BodySettings(seconds=0.0)):
        plan = plan_body(make_flat(), spirit, START, GOAL, settings)
        assert (plan.reason, plan.trajectory) == ("budget", None)


def test_short_ways_and_turns_alone(make_flat, judged, model):
    ground = make_flat()
    for way in (0.0, 0.001, 0.05, 0.3):
        goal = (2.0 + way, 2.0, 2.5)
        plan = plan_body(ground, model, START, goal)
        judged(plan, ground, model, START, goal)


def test_bad_input():
    with pytest.raises(InputError, match="goal: expected three numbers"):
        plan_body(None, robot_model("spirit"), START, (1.0, 2.0))
    with pytest.raises(InputError, match="start: expected finite"):
        plan_body(None, robot_model("spirit"), (math.nan, 0.0, 0.0), GOAL)
    with pytest.raises(InputError, match="variant: unknown variant 'fast'"):
        BodySettings(variant="fast")
    for name in ("iterations", "improve", "seconds", "margin"):
        with pytest.raises(InputError, match=name):
            BodySettings(**{name: -1})
