"""Partial goals, goals that do not fit, and ways to them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import Formation, FormationSettings
from cavalcade.formation._clearance import Footprint
from cavalcade.formation.goals import (
    Descent,
    GoalPlan,
    descend_from,
    eta_from,
    local_path,
    partial_goals,
)
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.world import Box, Circle, OccupancyMap

CELL = 0.05
W_MIN = 0.70
SQUARE = Formation.square(1.0).slots
GO1 = (0.65, 0.28)
COVER = Footprint.of(*GO1)


def maps_of(*shapes, size=(8.0, 6.0), **values):
    world = OccupancyMap.empty(size, CELL).with_shapes(shapes)
    return PlanningMaps(world.occupied, CELL, FormationSettings(**values))


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
        goals = partial_goals(maps_of(*walls), np.array([4.0, 3.0]), 0.0, SQUARE, W_MIN)
        np.testing.assert_allclose(goals, np.tile((4.0, 3.0), (4, 1)), atol=1e-9)

    def test_off_the_map_they_are_drawn_back_in(self):
        goals = partial_goals(OPEN, np.array([1.0, 1.0]), 0.0, Formation.column(4).slots, W_MIN)
        assert (goals > 0.3).all()

    def test_one_robot_has_one(self):
        goals = partial_goals(OPEN, np.array([2.0, 2.0]), 1.0, np.zeros((1, 2)), W_MIN)
        np.testing.assert_array_equal(goals, [[2.0, 2.0]])


def gaps(tools, maps, places, yaw):
    """Of the bodies of Go1s that stand there, to the nearest obstacle."""
    return [
        tools.occupied_gap(np.array([*place, yaw]), GO1, maps.occupied, CELL) for place in places
    ]


OPEN = maps_of(size=(12.0, 12.0))
CLUTTER = maps_of(
    Circle((3.0, 2.0), 0.3), Circle((5.0, 4.0), 0.2), Box((4.2, 3.0), (0.3, 0.5), 0.4)
)


class TestPlan:
    START = np.array([[1.0, 3.0], [1.0, 4.0], [1.0, 2.0], [2.0, 3.0]])

    def test_a_goal_that_fits_stays(self):
        plan = GoalPlan(CLUTTER, np.array([6.5, 3.0, 0.5]), SQUARE, self.START, COVER)
        assert plan.moved == 0.0
        assert plan.pose.tolist() == [6.5, 3.0, 0.5]
        assert len(plan.cut_off) == 0

    @pytest.mark.parametrize(
        "goal", [(7.9, 3.0, 0.0), (5.0, 4.5, 0.3), (6.5, 5.9, 1.0), (3.0, 2.8, 2.0)]
    )
    def test_one_that_does_not_fit_is_moved_no_further_than_it_must(self, tools, goal):
        plan = GoalPlan(CLUTTER, np.array(goal), SQUARE, self.START, COVER)
        assert 0.0 < plan.moved == pytest.approx(math.dist(plan.pose[:2], goal[:2]))
        assert plan.pose[2] == goal[2]
        assert (CLUTTER.speed_at(plan.places) > 0.0).all()
        assert min(gaps(tools, CLUTTER, plan.places, goal[2])) > 0.02
        # Nearer placements, tried one by one, put a slot into the inflated zone, or a body so
        # close to an obstacle that its discs (8 cm longer) have no room.
        least = 0.06 + 0.081
        steps = np.arange(-plan.moved, plan.moved + CELL, CELL)
        wanted = plan.places - (plan.pose[:2] - goal[:2])
        for dx in steps:
            for dy in steps:
                if math.hypot(dx, dy) < plan.moved - CELL:
                    places = wanted + np.array([dx, dy])
                    assert (CLUTTER.speed_at(places) == 0.0).any() or any(
                        gap < least for gap in gaps(tools, CLUTTER, places, goal[2])
                    )

    def test_bodies_are_placed_as_the_goal_turns_them(self, tools):
        """0.35 m from a wall there is room for a robot along it, not for one that faces it."""
        along, facing = (
            GoalPlan(OPEN, np.array([11.65, 6.0, yaw]), np.zeros((1, 2)), np.array([[3.0, 6.0]]),
                     COVER)
            for yaw in (math.pi / 2, 0.0)
        )  # fmt: skip
        assert along.moved == 0.0
        # Its discs reach 0.406 m to the front, and 0.06 m are to spare there.
        assert facing.moved == pytest.approx(0.406 + 0.06 - 0.35, abs=CELL)
        assert facing.pose[0] < 11.65
        assert min(gaps(tools, OPEN, facing.places, 0.0)) > 0.02

    @settings(max_examples=25, deadline=None)
    @given(st.integers(0, 2**32 - 1), st.sampled_from([0.30, 0.25, 0.21]))
    def test_nobody_is_sent_into_an_obstacle(self, tools, seed, radius):
        rng = np.random.default_rng(seed)
        world = OccupancyMap.empty((6.0, 5.0), CELL).with_shapes(
            [Circle(tuple(rng.uniform((3.0, 1.0), (5.0, 4.0))), 0.3) for _ in range(3)]
        )
        maps = PlanningMaps(world.occupied, CELL, FormationSettings(), radius)
        goal = np.array([*rng.uniform((2.5, 0.5), (5.5, 4.5)), rng.uniform(-3.0, 3.0)])
        slots = Formation.triangle(0.8).slots
        plan = GoalPlan(maps, goal, slots, np.tile((1.0, 2.5), (3, 1)), COVER)
        if len(plan.cut_off) == 0:
            assert min(gaps(tools, maps, plan.places, goal[2])) > 0.01

    def test_where_there_is_little_room_the_bodies_fill_it(self):
        """A dead end just wide enough: room to turn is given up before the place is."""
        walls = [Box((6.0, 1.25), (3.0, 2.5)), Box((6.0, 4.6), (3.0, 2.8))]  # 0.70 m between them
        maps = maps_of(*walls)
        alone, start = np.zeros((1, 2)), np.array([[1.0, 3.0]])
        along = GoalPlan(maps, np.array([6.0, 2.85, 0.0]), alone, start, COVER)
        across = GoalPlan(maps, np.array([6.0, 2.85, math.pi / 2]), alone, start, COVER)
        assert along.moved < CELL
        assert across.moved > 1.0
        assert across.places[0, 0] < 4.5

    def test_a_goal_far_out_of_reach_of_any_placement_cuts_everyone_off(self):
        plan = GoalPlan(CLUTTER, np.array([30.0, 3.0, 0.0]), SQUARE, self.START, COVER)
        assert plan.cut_off.tolist() == [0, 1, 2, 3]
        assert plan.problem == "it is off the map"

    @pytest.mark.parametrize(
        ("goal", "problem"),
        [
            ((8.01, 3.0), ""),  # beyond the border, but moved to where it fits
            ((11.5, 3.0), "it is off the map"),
            ((4.2, 3.0), "the shape fits nowhere within 3 m of it"),
            ((3.8, 3.0), ""),
        ],
    )
    def test_a_goal_off_the_map_was_called_unreachable(self, goal, problem):
        block = Box((3.5, 3.0), (4.0, 6.0))
        maps = maps_of() if goal[0] > 8.0 else maps_of(block, size=(5.5, 6.0))
        alone, start = np.zeros((1, 2)), np.array([[0.75, 3.0]])
        plan = GoalPlan(maps, np.array([*goal, 0.0]), alone, start, COVER)
        assert plan.problem == problem
        assert (len(plan.cut_off) > 0) == (problem != "")

    def test_only_who_is_walled_in_is_cut_off(self):
        cell = [Box((1.0, 4.0 + dy), (1.3, 0.1)) for dy in (-0.6, 0.6)]
        cell += [Box((1.0 + dx, 4.0), (0.1, 1.3)) for dx in (-0.6, 0.6)]
        plan = GoalPlan(maps_of(*cell), np.array([6.0, 3.0, 0.0]), SQUARE, self.START, COVER)
        assert plan.cut_off.tolist() == [1]

    def test_a_goal_behind_a_wall_is_moved_to_this_side_of_it(self):
        maps = maps_of(Box((5.0, 3.0), (0.2, 6.0)))
        plan = GoalPlan(maps, np.array([6.0, 3.0, 0.0]), SQUARE, self.START, COVER)
        assert len(plan.cut_off) == 0
        assert plan.places[:, 0].max() < 4.9 - 0.30

    def test_a_shape_around_an_obstacle_keeps_its_centre(self):
        maps = maps_of(Circle((5.0, 3.0), 0.2))
        plan = GoalPlan(maps, np.array([5.0, 3.0, 0.0]), Formation.circle(6, 1.5).slots,
                        self.START, COVER)  # fmt: skip
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
        maps = maps_of(Box((6.0, 3.0), (4.0, 6.0)))
        way = descend_from(maps.leader.field(np.array([1.0, 3.0])), np.array([7.0, 3.0]))
        assert way.eta == math.inf


class TestCover:
    @pytest.mark.parametrize("size", [(0.65, 0.28), (0.70, 0.35), (1.0, 0.2), (0.4, 0.4)])
    @pytest.mark.parametrize("discs", [(1, 1), (2, 1), (4, 1), (7, 1), (5, 2), (2, 3)])
    def test_the_discs_cover_the_rectangle_and_no_smaller_ones_would(self, tools, size, discs):
        cover = Footprint.of(*size, *discs)
        points = tools.rectangle_points(np.zeros(3), *size, 0.01)
        offset = points[:, None] - cover.discs[None]
        away = np.hypot(offset[..., 0], offset[..., 1]).min(axis=1)
        assert len(cover.discs) == discs[0] * discs[1]
        assert away.max() == pytest.approx(cover.radius)
        np.testing.assert_allclose(cover.discs, -cover.discs[::-1], atol=1e-12)


class TestWays:
    INSIDE = np.array([3.0, 2.45])  # in the inflated zone of a circle

    def test_times_are_the_descents(self):
        field = CLUTTER.leader.field(np.array([6.5, 3.0]))
        for point in ((1.0, 3.0), (6.5, 3.0), (3.0, 2.45)):
            way = descend_from(field, np.array(point))
            assert eta_from(field, np.array(point)) == pytest.approx(way.eta, abs=1e-6)

    def test_the_inflated_zone_costs_time(self):
        """So that a robot in it does not lead."""
        field = CLUTTER.leader.field(np.array([6.5, 3.0]))
        near = field.nearest_reached(self.INSIDE)
        assert eta_from(field, self.INSIDE) >= field.eta(near) + math.dist(near, self.INSIDE) / 0.5

    def test_no_time_where_there_is_no_free_ground_near(self):
        field = maps_of(Box((6.0, 3.0), (4.0, 6.0))).leader.field(np.array([1.0, 3.0]))
        assert eta_from(field, np.array([7.0, 3.0])) == math.inf

    def test_a_local_path_leads_from_start_to_goal(self):
        way, _ = local_path(CLUTTER, np.array([1.0, 3.0]), np.array([6.5, 3.0]))
        assert way[0].tolist() == [1.0, 3.0]
        assert math.dist(way[-1], (6.5, 3.0)) < CELL
        assert (CLUTTER.speed_at(way) > 0.0).all()

    def test_from_the_inflated_zone_it_first_leads_out(self):
        way, _ = local_path(CLUTTER, self.INSIDE, np.array([6.5, 3.0]))
        assert way[0].tolist() == self.INSIDE.tolist()
        assert (CLUTTER.speed_at(way[1:]) > 0.0).all()

    def test_out_it_leads_even_if_the_goal_is_not_free(self):
        way, _ = local_path(CLUTTER, self.INSIDE, np.array([5.0, 4.0]))
        assert len(way) == 2
        assert CLUTTER.speed_at(way[1:])[0] > 0.0

    def test_none_from_deep_inside(self):
        maps = maps_of(Box((6.0, 3.0), (4.0, 6.0)))
        assert len(local_path(maps, np.array([7.0, 3.0]), np.array([1.0, 3.0]))[0]) == 0


class TestSlotFields:
    """Marched only as far as the robots that ask need."""

    WALL = Box((4.0, 1.9), (0.2, 3.8))  # from y = 0 to 3.8

    def plan(self):
        maps = maps_of(self.WALL)
        return GoalPlan(
            maps, np.array([6.5, 2.0, 0.0]), np.zeros((1, 2)), np.array([[1.0, 3.0]]), COVER
        )

    @staticmethod
    def full(plan):
        return plan.maps.follower.field(plan.places[0])

    def test_for_those_that_asked_it_is_the_whole_field(self):
        plan = self.plan()
        points = np.array([[1.0, 3.0], [5.0, 5.0], [2.5, 1.0]])
        field, full = plan.slot_field(0, points), self.full(plan)
        for point in points:
            assert eta_from(field, point) == pytest.approx(eta_from(full, point), rel=0.01)

    def test_it_is_kept_as_long_as_it_serves(self):
        plan = self.plan()
        far, near = np.array([[1.0, 3.0]]), np.array([[5.0, 5.0]])
        field = plan.slot_field(0, far)
        assert plan.slot_field(0, near) is field
        assert plan.slot_field(0, far) is field

    def test_for_one_far_beyond_it_is_marched_anew(self):
        plan = self.plan()
        near, far = np.array([[5.5, 3.0]]), np.array([[1.0, 1.0]])
        field = plan.slot_field(0, near)
        assert plan.slot_field(0, far) is not field
        assert eta_from(plan.slot_field(0, far), far[0]) == pytest.approx(
            eta_from(self.full(plan), far[0]), rel=0.01
        )

    def test_so_it_is_for_one_a_little_beyond(self):
        """On the other side of a thin wall; or driven back a step by something that moves."""
        plan = self.plan()
        plan.slot_field(0, np.array([[4.7, 1.0]]))
        behind = np.array([3.3, 1.0])
        field, full = plan.slot_field(0, behind[None]), self.full(plan)
        assert eta_from(field, behind) == pytest.approx(eta_from(full, behind), rel=0.01)
        way = descend_from(field, behind).points
        assert (plan.maps.speed_at(way) > 0.0).all()
        steps = np.hypot(*np.diff(way, axis=0).T)
        assert steps.max() <= 0.1

    def test_one_without_a_way_has_none(self):
        maps = maps_of(Box((4.0, 3.0), (0.2, 6.0)))
        plan = GoalPlan(maps, np.array([6.5, 3.0, 0.0]), np.zeros((1, 2)),
                        np.array([[6.0, 3.0]]), COVER)  # fmt: skip
        point = np.array([1.0, 3.0])
        assert eta_from(plan.slot_field(0, point[None]), point) == math.inf
