"""Partial goals, goals that do not fit, and ways to them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import Formation, FormationSettings
from cavalcade.formation.goals import Descent, GoalPlan, descend_from, partial_goals
from cavalcade.formation.ground import Ground
from cavalcade.world import Box, Circle, OccupancyMap

CELL = 0.05
W_MIN = 0.70
SQUARE = Formation.square(1.0).slots


def ground_of(*shapes, size=(8.0, 6.0), **values):
    world = OccupancyMap.empty(size, CELL).with_shapes(shapes)
    return Ground(world.occupied, CELL, FormationSettings(**values))


class TestPartialGoals:
    @settings(max_examples=40, deadline=None)
    @given(st.floats(-4.0, 4.0), st.integers(1, 12))
    def test_in_the_open_they_are_equation_2(self, heading, robots):
        slots = Formation.circle(robots, 1.2).slots
        anchor = np.array([6.0, 6.0])
        goals = partial_goals(OPEN, anchor, heading, slots, W_MIN)
        for goal, slot in zip(goals, slots, strict=True):
            x, y = slot - slots[0]
            assert goal[0] == pytest.approx(6.0 + math.cos(heading) * x - math.sin(heading) * y)
            assert goal[1] == pytest.approx(6.0 + math.sin(heading) * x + math.cos(heading) * y)

    @settings(max_examples=40, deadline=None)
    @given(st.integers(0, 2**32 - 1))
    def test_elsewhere_they_lie_between_the_slot_and_the_leaders_goal(self, seed):
        rng = np.random.default_rng(seed)
        anchor, heading = rng.uniform((2.0, 1.0), (6.0, 5.0)), rng.uniform(-3.0, 3.0)
        goals = partial_goals(CLUTTER, anchor, heading, SQUARE, W_MIN)
        c, s = math.cos(heading), math.sin(heading)
        wanted = (SQUARE - SQUARE[0]) @ np.array([[c, s], [-s, c]]) + anchor
        np.testing.assert_array_equal(goals[0], anchor)
        for goal, slot in zip(goals[1:], wanted[1:], strict=True):
            detour = math.dist(slot, goal) + math.dist(goal, anchor) - math.dist(slot, anchor)
            assert detour == pytest.approx(0.0, abs=1e-9)
            good = CLUTTER.speed_at(goal[None])[0] >= W_MIN
            assert good or math.dist(goal, anchor) < 1e-9
            if CLUTTER.speed_at(slot[None])[0] >= W_MIN:
                assert math.dist(goal, slot) < 1e-9
            elif good:
                # No further than it must: a step back it was not good enough.
                back = goal + (slot - goal) / math.dist(slot, goal) * 0.05
                assert CLUTTER.speed_at(back[None])[0] < W_MIN

    def test_in_a_narrow_corridor_all_fall_onto_the_leaders(self):
        walls = [Box((4.0, 1.2), (8.0, 2.4)), Box((4.0, 4.8), (8.0, 2.4))]
        goals = partial_goals(ground_of(*walls), np.array([4.0, 3.0]), 0.0, SQUARE, W_MIN)
        np.testing.assert_allclose(goals, np.tile((4.0, 3.0), (4, 1)), atol=1e-9)

    def test_off_the_map_they_are_drawn_back_in(self):
        goals = partial_goals(OPEN, np.array([1.0, 1.0]), 0.0, Formation.column(4).slots, W_MIN)
        assert (goals > 0.3).all()

    def test_one_robot_has_one(self):
        goals = partial_goals(OPEN, np.array([2.0, 2.0]), 1.0, np.zeros((1, 2)), W_MIN)
        np.testing.assert_array_equal(goals, [[2.0, 2.0]])


OPEN = ground_of(size=(12.0, 12.0))
CLUTTER = ground_of(
    Circle((3.0, 2.0), 0.3), Circle((5.0, 4.0), 0.2), Box((4.2, 3.0), (0.3, 0.5), 0.4)
)


class TestPlan:
    START = np.array([[1.0, 3.0], [1.0, 4.0], [1.0, 2.0], [2.0, 3.0]])

    def test_a_goal_that_fits_stays(self):
        plan = GoalPlan(CLUTTER, np.array([6.5, 3.0, 0.5]), SQUARE, self.START)
        assert plan.moved == 0.0
        assert plan.pose.tolist() == [6.5, 3.0, 0.5]
        assert len(plan.cut_off) == 0

    @pytest.mark.parametrize(
        "goal", [(7.9, 3.0, 0.0), (5.0, 4.5, 0.3), (6.5, 5.9, 1.0), (3.0, 2.8, 2.0)]
    )
    def test_one_that_does_not_fit_is_moved_no_further_than_it_must(self, goal):
        plan = GoalPlan(CLUTTER, np.array(goal), SQUARE, self.START)
        assert 0.0 < plan.moved == pytest.approx(math.dist(plan.pose[:2], goal[:2]))
        assert plan.pose[2] == goal[2]
        assert (CLUTTER.speed_at(plan.places) > 0.0).all()
        # Nearer placements, tried one by one, put a slot onto an obstacle.
        steps = np.arange(-plan.moved, plan.moved + CELL, CELL)
        wanted = plan.places - (plan.pose[:2] - goal[:2])
        for dx in steps:
            for dy in steps:
                if math.hypot(dx, dy) < plan.moved - CELL:
                    assert (CLUTTER.speed_at(wanted + np.array([dx, dy])) == 0.0).any()

    def test_a_goal_far_out_of_reach_of_any_placement_cuts_everyone_off(self):
        plan = GoalPlan(CLUTTER, np.array([30.0, 3.0, 0.0]), SQUARE, self.START)
        assert plan.cut_off.tolist() == [0, 1, 2, 3]

    def test_only_who_is_walled_in_is_cut_off(self):
        cell = [Box((1.0, 4.0 + dy), (1.3, 0.1)) for dy in (-0.6, 0.6)]
        cell += [Box((1.0 + dx, 4.0), (0.1, 1.3)) for dx in (-0.6, 0.6)]
        plan = GoalPlan(ground_of(*cell), np.array([6.0, 3.0, 0.0]), SQUARE, self.START)
        assert plan.cut_off.tolist() == [1]

    def test_a_goal_behind_a_wall_is_moved_to_this_side_of_it(self):
        ground = ground_of(Box((5.0, 3.0), (0.2, 6.0)))
        plan = GoalPlan(ground, np.array([6.0, 3.0, 0.0]), SQUARE, self.START)
        assert len(plan.cut_off) == 0
        assert plan.places[:, 0].max() < 4.9 - 0.30

    def test_a_shape_around_an_obstacle_keeps_its_centre(self):
        ground = ground_of(Circle((5.0, 3.0), 0.2))
        plan = GoalPlan(ground, np.array([5.0, 3.0, 0.0]), Formation.circle(6, 1.5).slots,
                        self.START)  # fmt: skip
        assert plan.moved == 0.0
        assert np.isfinite([plan.field.eta(point) for point in self.START]).all()


class TestDescent:
    LINE = Descent(np.column_stack([np.linspace(0.0, 4.0, 41), np.zeros(41)]),
                   np.linspace(8.0, 0.0, 41))  # fmt: skip

    def test_its_eta_is_the_time_from_its_first_point(self):
        assert self.LINE.eta == 8.0
        assert Descent(np.empty((0, 2)), np.empty(0)).eta == math.inf

    @pytest.mark.parametrize(
        ("time", "x"), [(0.0, 0.0), (0.2, 0.1), (2.5, 1.25), (7.97, 3.985), (8.0, 4.0), (99.0, 4.0)]
    )
    def test_the_point_ahead_is_found_by_time(self, time, x):
        point, heading = self.LINE.ahead(time)
        np.testing.assert_allclose(point, (x, 0.0), atol=1e-9)
        assert heading == 0.0

    def test_the_way_from_free_ground_ends_at_the_goal(self):
        field = CLUTTER.leader.field(np.array([6.5, 3.0]))
        way = descend_from(field, np.array([1.0, 3.0]))
        assert way.points[0].tolist() == [1.0, 3.0]
        assert math.dist(way.points[-1], (6.5, 3.0)) < CELL
        assert (np.diff(way.times) <= 0.0).all()
        assert (CLUTTER.speed_at(way.points) > 0.0).all()

    def test_from_the_inflated_zone_it_first_makes_for_free_ground(self):
        inside = np.array([3.0, 2.45])  # 0.15 m from the circle's surface
        assert CLUTTER.speed_at(inside[None])[0] == 0.0
        way = descend_from(CLUTTER.leader.field(np.array([6.5, 3.0])), inside)
        assert way.points[0].tolist() == inside.tolist()
        assert math.dist(way.points[1], inside) < 0.35
        assert math.isfinite(way.eta)

    def test_from_nowhere_near_free_ground_there_is_no_way(self):
        ground = ground_of(Box((6.0, 3.0), (4.0, 6.0)))
        way = descend_from(ground.leader.field(np.array([1.0, 3.0])), np.array([7.0, 3.0]))
        assert way.eta == math.inf
