"""What one cycle knows and reports."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import Formation
from cavalcade.formation.cycle import (
    EMPTY_PATH,
    by_robot,
    direction,
    distances,
    named,
    order_of,
    path_heading,
)
from cavalcade.formation.team import Team
from cavalcade.world import OccupancyMap

ROOM = OccupancyMap.empty((8.0, 5.0), 0.05)
COLUMN = Formation.column(3, 1.0)
GOAL = (5.0, 2.5, 0.5)


def cycle_at(tools, poses, goal=GOAL, team=None):
    return tools.cycle_of(ROOM, COLUMN, poses, goal, team=team)


def standing(tools, goal=GOAL):
    """In the slots, final, with everything a status is made of."""
    cycle = cycle_at(tools, tools.placed(COLUMN, goal))
    cycle.final, cycle.roles = True, np.arange(3)
    cycle.away = np.zeros(3)
    return cycle


class TestBeginning:
    def test_nothing_is_known(self, tools):
        cycle = cycle_at(tools, tools.placed(COLUMN, (2.0, 2.5, 0.0)))
        assert cycle.velocity is None
        assert (cycle.eta == np.inf).all()
        assert (cycle.away == np.inf).all()
        assert (cycle.roles == -1).all()
        assert [len(path) for path in cycle.paths] == [0, 0, 0]
        assert not cycle.final

    def test_cycles_share_nothing(self, tools):
        one, other = (cycle_at(tools, tools.placed(COLUMN, (2.0, 2.5, 0.0))) for _ in range(2))
        one.eta[0], one.roles[0] = 1.0, 2
        assert other.eta[0] == np.inf
        assert other.roles[0] == -1


class TestHeadings:
    def test_those_that_move_head_where_they_move_and_others_where_they_look(self, tools):
        poses = np.array([[1.0, 1.0, 0.3], [2.0, 1.0, -2.0], [3.0, 1.0, 1.0]])
        cycle = cycle_at(tools, poses)
        np.testing.assert_array_equal(cycle.headings(), poses[:, 2])
        cycle.velocity = np.array([[0.0, 0.4], [0.01, 0.01], [-0.3, 0.0]])
        np.testing.assert_allclose(cycle.headings(), (math.pi / 2, -2.0, math.pi))


class TestDistances:
    def test_to_the_places_of_the_roles(self, tools):
        cycle = cycle_at(tools, tools.placed(COLUMN, GOAL))
        np.testing.assert_allclose(cycle.plan_distances(np.arange(3)), 0.0, atol=1e-9)
        np.testing.assert_allclose(cycle.plan_distances(np.array([2, 1, 0])), (2.0, 0.0, 2.0))

    def test_without_roles_nobody_is_near(self, tools):
        cycle = cycle_at(tools, tools.placed(COLUMN, GOAL))
        assert (cycle.plan_distances(np.empty(0, np.int64)) == np.inf).all()

    def test_of_those_that_take_part_only(self, tools):
        team = Team(3, COLUMN)
        team.lose(1)
        cycle = cycle_at(tools, tools.placed(COLUMN, GOAL), team=team)
        away = cycle.plan_distances(np.array([0, -1, 1]))
        # Two in a column 1 m apart stand at 0.5 m from where three had their ends.
        np.testing.assert_allclose(away, (0.5, 0.5))

    def test_a_robot_without_a_slot_is_infinitely_far(self):
        targets = by_robot(np.array([[1.0, 1.0], [2.0, 2.0]]), np.array([1, -1, 0]))
        assert targets[0].tolist() == [2.0, 2.0]
        assert np.isnan(targets[1]).all()
        away = distances(np.zeros((3, 2)), targets)
        assert away.tolist() == [math.hypot(2, 2), math.inf, math.hypot(1, 1)]


class TestStatus:
    def test_in_their_slots_and_turned_they_have_arrived(self, tools):
        status = standing(tools).status("final", 1, 2)
        assert status.arrived
        assert (status.state, status.waypoint) == ("final", 2)
        assert status.goal.tolist() == list(GOAL)
        assert status.goal_moved == 0.0

    def test_one_that_is_away_is_enough_not_to_have(self, tools):
        cycle = standing(tools)
        cycle.away[2] = 0.095
        assert not cycle.status("final", -1, 0).arrived

    @pytest.mark.parametrize("turn", [0.14, -0.14, math.pi])
    def test_so_is_one_that_looks_elsewhere(self, tools, turn):
        cycle = standing(tools)
        cycle.poses[1, 2] += turn
        assert not cycle.status("final", -1, 0).arrived

    def test_full_turns_do_not_count(self, tools):
        cycle = standing(tools)
        cycle.poses[1, 2] -= 2.0 * math.pi
        assert cycle.status("final", -1, 0).arrived

    def test_one_that_takes_no_part_does_not_count(self, tools):
        team = Team(3, COLUMN)
        team.lose(1)
        cycle = cycle_at(tools, tools.placed(COLUMN, GOAL), team=team)
        cycle.final, cycle.away = True, np.array([0.0, np.inf, 0.0])
        cycle.poses[1, 2] += 1.0
        assert cycle.status("final", -1, 0).arrived

    def test_only_final_goals_can_be_arrived_at(self, tools):
        cycle = standing(tools)
        cycle.final = False
        assert not cycle.status("partial", 0, 0).arrived

    @pytest.mark.parametrize("state", ["final", "resolving", "stuck", "infeasible"])
    def test_there_is_a_leader_on_the_way_only(self, tools, state):
        assert standing(tools).status("partial", 2, 0).leader == 2
        assert standing(tools).status(state, 2, 0).leader == -1

    def test_its_roles_stay_what_they_were(self, tools):
        cycle = standing(tools)
        status = cycle.status("final", -1, 0)
        cycle.roles[0] = 2
        assert status.roles.tolist() == [0, 1, 2]


class TestPaths:
    @settings(max_examples=60, deadline=None)
    @given(
        st.floats(-3.1, 3.1),
        st.integers(2, 60),
        st.floats(0.005, 0.1),
        st.sampled_from([0.15, 0.4]),
    )
    def test_a_straight_one_has_one_direction(self, angle, count, spacing, reach):
        course = np.array([math.cos(angle), math.sin(angle)])
        path = np.array([1.0, 2.0]) + np.arange(count)[:, None] * spacing * course
        np.testing.assert_allclose(direction(path, reach), course, atol=1e-9)
        assert path_heading(path) == pytest.approx(angle)

    @pytest.mark.parametrize("reach", [0.15, 0.4])
    def test_a_bent_one_that_to_the_point_that_far_along(self, reach):
        along = np.arange(0.0, 1.5, 0.025)
        path = np.column_stack([np.minimum(along, 0.1), np.maximum(along - 0.1, 0.0)])
        expected = np.array([0.1, reach - 0.1])
        found = direction(path, reach)
        assert np.hypot(*found) == pytest.approx(1.0)
        np.testing.assert_allclose(found, expected / np.hypot(*expected), atol=0.12)

    def test_a_long_first_piece_is_followed_to_its_end(self):
        """Out of the inflated zone, before the way turns."""
        path = np.array([[0.0, 0.0], [0.6, 0.0], [0.6, 0.05], [0.6, 0.10], [0.6, 0.15]])
        np.testing.assert_allclose(direction(path), (1.0, 0.0))
        assert path_heading(path) == 0.0

    @pytest.mark.parametrize("path", [EMPTY_PATH, np.ones((1, 2)), np.ones((5, 2))])
    def test_none_without_a_way(self, path):
        np.testing.assert_array_equal(direction(path), (0.0, 0.0))
        assert path_heading(path) is None


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([0.0, 1.0, 2.5, 7.0, math.inf]), min_size=1, max_size=8))
def test_precedence_is_an_order_by_time_and_number(times):
    rank = order_of(np.array(times))
    assert sorted(rank) == list(range(len(times)))
    expected = sorted(range(len(times)), key=lambda k: (times[k], k))
    assert [list(rank).index(place) for place in range(len(times))] == expected


def test_robots_are_named():
    assert named((2,)) == "robot 2"
    assert named((1, 3)) == "robots 1, 3"
