"""What may happen on the way: goals, shapes, robots and maps that change."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.formation import VARIANTS, DynamicObstacle, Formation, FormationPlanner
from cavalcade.geometry import rotation
from cavalcade.world import Box, Circle, OccupancyMap

ROOM = OccupancyMap.empty((9.0, 6.0), 0.05)
START, GOAL = (1.6, 3.0, 0.0), (7.2, 3.0, 0.0)
SQUARE = Formation.square(1.0)
GO1 = (0.65, 0.28)


def planner_for(formation=SQUARE, map=ROOM, goal=GOAL, **values):
    planner = FormationPlanner(map, formation, **values)
    planner.set_goal(goal)
    return planner


def at(cycle, action):
    """A hook that acts once."""

    def hook(now, planner):
        if now == cycle:
            action(planner)

    return hook


def in_slots(poses, formation, goal, tolerance=0.10):
    places = formation.placed(goal)
    apart = np.hypot(*(poses[:, None, :2] - places[None]).transpose(2, 0, 1))
    return len(set(apart.argmin(axis=1))) == len(poses) and apart.min(axis=1).max() < tolerance


class TestGoals:
    def test_a_new_goal_replaces_the_old_one_while_moving(self, tools):
        other = (2.5, 4.5, 2.0)
        hook = at(80, lambda planner: planner.set_goal(other))
        planner = planner_for(lookahead=1.0)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 80.0, hook)
        assert drive.status[79].goal == pytest.approx(GOAL)
        assert drive.status[80].goal == pytest.approx(other)
        assert drive.status[80].state == "partial"
        assert in_slots(drive.poses[-1], SQUARE, other)

    def test_waypoints_are_taken_in_their_order(self, tools):
        goals = [(4.0, 4.2, 0.0), (7.0, 4.2, -1.57), (7.0, 1.8, -1.57)]
        planner = planner_for()
        planner.set_goals(goals)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 120.0)
        reached = [status.waypoint for status in drive.status]
        assert reached == sorted(reached)
        assert set(reached) == {0, 1, 2}
        assert drive.status[-1].arrived
        assert in_slots(drive.poses[-1], SQUARE, goals[-1])
        # Each was passed close by before the next one counted.
        for k, goal in enumerate(goals[:-1]):
            turn = reached.index(k + 1)
            assert in_slots(drive.poses[turn], SQUARE, goal, 0.35)
        # Arriving at one on the way is not the end.
        assert not any(s.arrived for s in drive.status if s.waypoint < 2)

    def test_a_team_that_stands_at_the_first_waypoint_has_not_arrived(self, tools):
        planner = planner_for()
        planner.set_goals([START, GOAL])
        poses = tools.placed(SQUARE, START)
        for cycle in range(4):
            planner.step(poses, cycle * 0.05)
            assert not planner.status.arrived
        assert planner.status.waypoint == 1

    def test_cancelled_the_team_brakes_and_stays(self, tools):
        hook = at(60, lambda planner: planner.cancel())
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 6.0, hook)
        assert drive.states[59] != "inactive"
        assert drive.states[60] == "inactive"
        np.testing.assert_allclose(drive.commands[60:], 0.0, atol=1e-9)
        assert np.abs(drive.poses[-1] - drive.poses[-20]).max() < 1e-6

    @pytest.mark.parametrize("none", [[], np.empty((0, 3))])
    def test_an_empty_list_of_goals_cancels(self, none):
        planner = planner_for()
        planner.set_goals(none)
        planner.step([(1.0 + k, 1.0, 0.0) for k in range(4)], 0.0)
        assert planner.status.state == "inactive"


class TestPause:
    def test_paused_it_stands_and_afterwards_it_goes_on(self, tools):
        def hook(cycle, planner):
            if cycle == 60:
                planner.pause()
            if cycle == 140:
                planner.resume()

        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 60.0, hook)
        assert set(drive.states[60:140]) == {"paused"}
        np.testing.assert_allclose(drive.commands[60:140], 0.0, atol=1e-9)
        assert np.abs(drive.poses[139] - drive.poses[90]).max() < 1e-6
        assert in_slots(drive.poses[-1], SQUARE, GOAL)

    def test_paused_before_the_first_goal(self, tools):
        planner = FormationPlanner(ROOM, SQUARE)
        planner.pause()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 1.0)
        assert (drive.commands == 0.0).all()
        planner.resume()
        assert in_slots(tools.drive(planner, drive.poses[-1], 60.0).poses[-1], SQUARE, GOAL)

    def test_a_short_pause_does_not_make_it_forget_that_it_moves(self, tools, seen_velocities):
        """Right after it the filter must still know that robots need their braking distance."""

        def hook(cycle, planner):
            if cycle == 80:
                planner.pause()
            if cycle == 81:
                planner.resume()

        planner = planner_for()
        tools.drive(planner, tools.placed(SQUARE, START), 82 * 0.05, hook)
        assert np.hypot(*seen_velocities[-1][:, :2].T).max() > 0.3


class TestShape:
    def test_a_new_shape_is_taken_up_while_moving(self, tools):
        line = Formation.line(4, 1.0)
        hook = at(60, lambda planner: planner.set_formation(line))
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 80.0, hook)
        assert in_slots(drive.poses[-1], line, GOAL)
        np.testing.assert_array_equal(drive.status[-1].slots, line.slots)

    def test_after_arriving_it_re_forms_on_the_spot(self, tools):
        column = Formation.column(4, 1.0)
        planner = planner_for(goal=(4.5, 3.0, 0.0))
        drive = tools.drive(planner, tools.placed(SQUARE, (4.5, 3.0, 0.0)), 2.0)
        assert drive.status[-1].arrived
        planner.set_formation(column)
        drive = tools.drive(planner, drive.poses[-1], 40.0)
        assert in_slots(drive.poses[-1], column, (4.5, 3.0, 0.0))


class TestLoss:
    def test_the_rest_forms_a_triangle_and_goes_on(self, tools):
        hook = at(60, lambda planner: planner.lose(2))
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 80.0, hook)
        status = drive.status[-1]
        assert status.roles[2] == -1
        assert sorted(np.delete(status.roles, 2)) == [0, 1, 2]
        assert (drive.commands[60:, 2] == 0.0).all()
        assert in_slots(np.delete(drive.poses[-1], 2, axis=0), Formation.triangle(1.0), GOAL)
        assert 2 not in status.connections

    def test_the_lost_one_is_an_obstacle_to_the_others(self, tools):
        hook = at(40, lambda planner: planner.lose(0))
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 80.0, hook)
        for poses in drive.poses[::2]:
            for k in (1, 2, 3):
                assert tools.sampled_gap(poses[k], poses[0], GO1, GO1) > 0.0

    def test_lost_and_found(self, tools):
        def hook(cycle, planner):
            if cycle == 60:
                planner.lose(1)
            if cycle == 160:
                planner.rejoin(1)

        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 80.0, hook)
        assert sorted(drive.status[-1].roles) == [0, 1, 2, 3]
        assert in_slots(drive.poses[-1], SQUARE, GOAL)

    @pytest.mark.parametrize("variant", VARIANTS)
    def test_when_all_are_lost_all_stand(self, tools, variant):
        planner = planner_for(Formation.column(2), variant=variant)
        poses = tools.placed(Formation.column(2), START)
        planner.step(poses, 0.0)
        planner.lose(0)
        planner.lose(1)
        assert (planner.step(poses, 0.05) == 0.0).all()
        assert planner.status.roles.tolist() == [-1, -1]
        planner.rejoin(1)
        assert np.abs(planner.step(poses, 0.10)[1]).max() > 0.0

    def test_a_robot_out_of_reach_may_be_lost(self, tools):
        """It was the reason for `infeasible`; without it the others can go."""
        wall = ROOM.with_shapes([Box((4.5, 3.0), (0.2, 6.0))])
        planner = planner_for(Formation.column(2), wall, (3.0, 3.0, 0.0))
        poses = np.array([[1.5, 3.0, 0.0], [7.0, 3.0, 0.0]])
        planner.step(poses, 0.0)
        assert planner.status.state == "infeasible"
        planner.lose(1)
        drive = tools.drive(planner, poses, 20.0)
        assert drive.status[-1].arrived


class TestMap:
    def test_an_obstacle_appears_ahead(self, tools):
        changed = ROOM.with_shapes([Circle((4.8, 3.0), 0.4)])
        hook = at(60, lambda planner: planner.update_map(changed))
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 80.0, hook)
        assert in_slots(drive.poses[-1], SQUARE, GOAL)
        for poses in drive.poses[60::2]:
            for pose in poses:
                assert tools.occupied_gap(pose, GO1, changed.occupied, 0.05) > 0.0

    def test_one_that_appears_and_goes_leaves_no_trace(self, tools):
        changed = ROOM.with_shapes([Circle((6.0, 1.2), 0.3)])
        plain, touched = planner_for(), planner_for()
        touched.update_map(changed)
        touched.update_map(ROOM)
        poses = tools.placed(SQUARE, START)
        np.testing.assert_allclose(touched.step(poses, 0.0), plain.step(poses, 0.0), atol=1e-9)

    def test_the_way_is_closed_and_opened_again(self, tools):
        closed = ROOM.with_shapes([Box((4.5, 3.0), (0.2, 6.0))])

        def hook(cycle, planner):
            if cycle == 40:
                planner.update_map(closed)
            if cycle == 100:
                planner.update_map(ROOM)

        planner = planner_for(goal=(7.8, 3.0, 0.0))
        drive = tools.drive(planner, tools.placed(SQUARE, START), 80.0, hook)
        # On this side of the wall a placement is too far from the goal.
        assert drive.states[99] == "infeasible"
        np.testing.assert_allclose(drive.commands[60:100], 0.0, atol=1e-9)
        assert in_slots(drive.poses[-1], SQUARE, (7.8, 3.0, 0.0))

    def test_another_map_with_another_frame(self, tools):
        """The same room, seen by a map with more ground around it and a turned grid."""
        bigger = OccupancyMap(np.zeros((220, 260), np.int8), 0.05, (-1.0, -2.5, 0.1))
        hook = at(60, lambda planner: planner.update_map(bigger))
        drive = tools.drive(planner_for(), tools.placed(SQUARE, START), 60.0, hook)
        assert drive.status[70].goal == pytest.approx(GOAL)
        assert in_slots(drive.poses[-1], SQUARE, GOAL)


class TestMovers:
    @pytest.mark.parametrize("speed", [0.3, 0.5])
    def test_one_that_crosses_the_way_is_not_met(self, tools, speed):
        planner = planner_for()
        place = np.array([4.5, 0.3])
        log = []

        def hook(cycle, planner):
            if cycle > 60:
                place[1] = min(place[1] + speed * 0.05, 5.6)
            moving = (0.0, speed if place[1] < 5.6 else 0.0)
            planner.set_dynamic_obstacles([DynamicObstacle(Circle(tuple(place), 0.25), moving)])
            log.append(place.copy())

        drive = tools.drive(planner, tools.placed(SQUARE, START), 60.0, hook)
        for where, poses in zip(log, drive.poses, strict=False):
            for pose in poses:
                gap = tools.distance_to_rectangle(where[None], pose, *GO1)[0] - 0.25
                assert gap > 0.0
        assert in_slots(drive.poses[-1], SQUARE, GOAL)

    def test_a_team_that_stands_steps_aside(self, tools):
        """Head-on at a robot's walking pace, in the open."""
        alone = Formation.column(1)
        planner = planner_for(alone, goal=(4.5, 3.0, 0.0))
        place = np.array([8.5, 3.0])
        log = []

        def hook(cycle, planner):
            place[0] = max(place[0] - 0.5 * 0.05, 0.4)
            planner.set_dynamic_obstacles(
                [DynamicObstacle(Circle(tuple(place), 0.25), (-0.5, 0.0))]
            )
            log.append(place.copy())

        drive = tools.drive(planner, np.array([[4.5, 3.0, 0.0]]), 16.0, hook, until_arrived=False)
        gaps = [
            tools.distance_to_rectangle(where[None], poses[0], *GO1)[0] - 0.25
            for where, poses in zip(log, drive.poses, strict=True)
        ]
        assert min(gaps) > 0.0
        # And returns when it is past.
        planner.set_dynamic_obstacles([])
        assert tools.drive(planner, drive.poses[-1], 20.0).status[-1].arrived


def test_velocities_survive_another_maps_frame(seen_velocities):
    """They are told in the map's frame of the poses, whatever the grid's."""
    planner = planner_for(Formation.column(2))
    poses = np.array([[3.0, 3.0, 0.0], [2.0, 3.0, 0.0]])
    for cycle in range(20):
        planner.step(poses + (0.3 * 0.05 * cycle, 0.0, 0.0), cycle * 0.05)
    planner.update_map(OccupancyMap(np.zeros((220, 260), np.int8), 0.05, (-1.0, -2.5, 2.0)))
    for cycle in range(20, 23):
        planner.step(poses + (0.3 * 0.05 * cycle, 0.0, 0.0), cycle * 0.05)
        speed = seen_velocities[-1][:, :2] @ rotation(2.0).T  # the filter sees the grid's frame
        np.testing.assert_allclose(speed[:, 1], 0.0, atol=0.02)
        assert (speed[:, 0] > 0.1).all()


@pytest.mark.parametrize("push", [(0.06, 0.0, 0.0), (0.0, -0.075, 0.0), (0.0, 0.0, 0.11)])
def test_a_robot_that_is_pushed_out_of_its_slot_returns(tools, push):
    """However little; what rests must also count as arrived."""
    planner = planner_for(goal=(4.5, 3.0, 0.0))
    drive = tools.drive(planner, tools.placed(SQUARE, (4.5, 3.0, 0.0)), 2.0)
    assert drive.status[-1].arrived
    poses = drive.poses[-1].copy()
    poses[0] += push
    drive = tools.drive(planner, poses, 12.0, until_arrived=False)
    assert drive.status[-1].arrived
