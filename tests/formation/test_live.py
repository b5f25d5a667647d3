"""A live planner: what follows from a change is worked out beside the cycles and then taken up."""

from __future__ import annotations

import gc
import threading
from concurrent.futures import wait

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.formation import VARIANTS, Formation, FormationPlanner
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

ROOM = OccupancyMap.empty((9.0, 6.0), 0.05)
SQUARE = Formation.square(1.0)
START, GOAL, OTHER = (1.6, 3.0, 0.0), (7.2, 3.0, 0.0), (2.4, 4.4, 2.0)
GO1 = (0.65, 0.28)


class Gate:
    """Holds what a planner prepares until it is opened."""

    def __init__(self, planner: FormationPlanner) -> None:
        self.opened = threading.Event()
        self.begun = threading.Event()
        self._prepared = planner._prepared
        planner._prepared = self._wait

    def _wait(self, request):
        self.begun.set()
        assert self.opened.wait(60.0)
        return self._prepared(request)


@pytest.fixture
def gates():
    """Gates, all of which are opened in the end, so that threads end."""
    made: list[Gate] = []

    def close(planner: FormationPlanner) -> Gate:
        made.append(Gate(planner))
        return made[-1]

    yield close
    for gate in made:
        gate.opened.set()


def settled(planner: FormationPlanner) -> None:
    """Wait for what is being prepared."""
    job = planner._preparation._job
    if job is not None:
        wait([job])


def hooked(actions: dict):
    """A hook that acts in some cycles and in each waits for what is being prepared."""

    def hook(cycle, planner):
        settled(planner)
        if cycle in actions:
            actions[cycle](planner)

    return hook


def in_slots(poses, formation, goal, tolerance=0.10):
    places = formation.placed(goal)
    apart = np.hypot(*(poses[:, None, :2] - places[None]).transpose(2, 0, 1))
    return len(set(apart.argmin(axis=1))) == len(poses) and apart.min(axis=1).max() < tolerance


def live(map=ROOM, formation=SQUARE, **values) -> FormationPlanner:
    return FormationPlanner(map, formation, live=True, **values)


class TestArriving:
    @pytest.mark.parametrize("variant", VARIANTS)
    def test_it_arrives_as_one_that_waits(self, tools, variant):
        found = []
        for planner in (live(variant=variant), FormationPlanner(ROOM, SQUARE, variant=variant)):
            planner.set_goal(GOAL)
            hook = hooked({}) if planner._preparation else None
            drive = tools.drive(planner, tools.placed(SQUARE, START), 60.0, hook)
            found.append(drive)
        first, second = found
        assert first.status[-1].arrived == second.status[-1].arrived
        # The plan is there one cycle later; then everything is as it is in the other.
        later = len(first.time) - len(second.time)
        assert abs(later) <= 20
        if second.status[-1].arrived:
            assert in_slots(first.poses[-1], SQUARE, GOAL, 0.12)

    def test_waypoints_are_taken_in_their_order_without_a_stop(self, tools):
        goals = [(4.0, 4.2, 0.0), (7.0, 4.2, -1.57), (7.0, 1.8, -1.57)]
        planner = live()
        planner.set_goals(goals)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 120.0, hooked({}))
        reached = [status.waypoint for status in drive.status]
        assert reached == sorted(reached)
        assert set(reached) == {0, 1, 2}
        assert not any(s.arrived for s in drive.status if s.waypoint < 2)
        for turn in (reached.index(1), reached.index(2)):
            assert np.abs(drive.commands[turn : turn + 3, :, :2]).max() > 0.1
        assert in_slots(drive.poses[-1], SQUARE, goals[-1])

    def test_everything_may_change_on_the_way(self, tools):
        crate = ROOM.with_shapes([Box((4.6, 3.0), (0.5, 0.5))])
        line = Formation.line(4, 0.9)
        actions = {
            40: lambda planner: planner.update_map(crate),
            80: lambda planner: planner.set_formation(line),
            120: lambda planner: planner.lose(2),
            160: lambda planner: planner.set_goal(OTHER),
            200: lambda planner: planner.rejoin(2),
        }
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 90.0, hooked(actions))
        assert drive.status[-1].arrived
        assert in_slots(drive.poses[-1], line, OTHER)
        gaps = [
            tools.occupied_gap(pose, GO1, crate.occupied, crate.resolution)
            for poses in drive.poses[40::10]
            for pose in poses
        ]
        assert min(gaps) > 0.0

    def test_a_deadlock_waits_for_its_fields(self, tools):
        """Robots that exchange places in a passage one robot wide."""
        walls = ROOM.with_shapes([Box((4.5, 1.1), (1.6, 2.2)), Box((4.5, 4.9), (1.6, 2.2))])
        planner = live(walls, Formation.column(3, 0.9))
        planner.set_goal((7.2, 3.0, np.pi))
        start = tools.placed(Formation.column(3, 0.9), (1.8, 3.0, 0.0))
        drive = tools.drive(planner, start, 120.0, hooked({}))
        assert drive.status[-1].arrived


class TestUntilItIsPrepared:
    def test_a_team_without_a_goal_stands_and_says_why(self, tools, gates):
        planner = live()
        gate = gates(planner)
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 1.0)
        assert (drive.commands == 0.0).all()
        assert set(drive.states) == {"partial"}
        assert "planned" in drive.status[-1].message
        gate.opened.set()
        assert in_slots(tools.drive(planner, drive.poses[-1], 60.0).poses[-1], SQUARE, GOAL)

    def test_a_team_under_way_goes_on(self, tools, gates):
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 3.0, hooked({}))
        gate = gates(planner)
        planner.set_goal(OTHER)
        planner.set_formation(Formation.line(4, 0.9))
        more = tools.drive(planner, drive.poses[-1], 2.0)
        assert gate.begun.is_set()
        assert (more.poses[-1, :, 0] > drive.poses[-1, :, 0] + 0.4).all()
        assert all(status.goal == pytest.approx(GOAL) for status in more.status)
        assert all(len(np.unique(status.slots, axis=0)) == 4 for status in more.status)

    def test_a_team_that_has_arrived_has_not_arrived_at_a_new_goal(self, tools, gates):
        planner = live()
        planner.set_goal(START)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 30.0, hooked({}))
        assert drive.status[-1].arrived
        gates(planner)
        planner.set_goal(GOAL)
        more = tools.drive(planner, drive.poses[-1], 0.5)
        assert not any(status.arrived for status in more.status)

    def test_a_goal_that_is_replaced_meanwhile_never_comes_into_effect(self, tools, gates):
        planner = live()
        gate = gates(planner)
        planner.set_goal(OTHER)
        first = tools.drive(planner, tools.placed(SQUARE, START), 0.5)
        assert gate.begun.is_set()
        planner.set_goal(GOAL)
        gate.opened.set()
        drive = tools.drive(planner, first.poses[-1], 60.0, hooked({}))
        goals = [
            status.goal for status in (*first.status, *drive.status) if status.goal is not None
        ]
        assert goals
        assert all(goal == pytest.approx(GOAL) for goal in goals)
        assert in_slots(drive.poses[-1], SQUARE, GOAL)

    def test_cancelled_a_goal_never_comes_into_effect(self, tools, gates):
        planner = live()
        gate = gates(planner)
        planner.set_goal(GOAL)
        tools.drive(planner, tools.placed(SQUARE, START), 0.2)
        planner.cancel()
        gate.opened.set()
        drive = tools.drive(planner, tools.placed(SQUARE, START), 1.0, hooked({}))
        assert (drive.commands == 0.0).all()
        assert set(drive.states) == {"inactive"}

    def test_cancelled_under_way_the_team_stops_at_once(self, tools, gates):
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 3.0, hooked({}))
        gates(planner)
        planner.set_goal(OTHER)
        planner.step(drive.poses[-1], 3.0)
        planner.cancel()
        commands = planner.step(drive.poses[-1], 3.05)
        assert planner.status.state == "inactive"
        np.testing.assert_allclose(commands, 0.0, atol=1e-9)

    def test_a_lost_robot_is_commanded_no_more(self, tools, gates):
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 3.0, hooked({}))
        gates(planner)
        planner.lose(1)
        more = tools.drive(planner, drive.poses[-1], 1.0)
        assert (more.commands[:, 1] == 0.0).all()
        assert np.abs(more.commands[-1]).max() > 0.1

    def test_what_is_wrong_is_refused_at_the_call(self):
        planner = live()
        calls = [
            lambda: planner.set_goal((1.0, np.nan, 0.0)),
            lambda: planner.set_formation(Formation.line(3, 1.0)),
            lambda: planner.lose(7),
            lambda: planner.update_map("hall"),
            lambda: planner.set_dynamic_obstacles([1]),
        ]
        for call in calls:
            with pytest.raises(InputError):
                call()
        planner.step(np.column_stack([SQUARE.placed(START), np.zeros(4)]), 0.0)
        assert planner.status.state == "inactive"

    def test_a_shape_is_judged_by_the_robots_that_will_take_part(self):
        planner = live()
        planner.lose(0)
        planner.set_formation(Formation.triangle(1.0))
        planner.rejoin(0)
        with pytest.raises(InputError):
            planner.set_formation(Formation.triangle(1.0))

    def test_what_goes_wrong_is_raised_by_the_next_cycle(self, tools):
        planner = live()

        def broken(request):
            raise RuntimeError("out of order")

        prepared, planner._prepared = planner._prepared, broken
        planner.set_goal(GOAL)
        poses = tools.placed(SQUARE, START)
        planner.step(poses, 0.0)
        settled(planner)
        with pytest.raises(RuntimeError, match="out of order"):
            planner.step(poses, 0.05)
        planner._prepared = prepared
        assert tools.drive(planner, poses, 60.0, hooked({})).status[-1].arrived


def test_its_thread_ends_with_the_planner(tools):
    planner = live()
    planner.set_goal(GOAL)
    planner.step(tools.placed(SQUARE, START), 0.0)
    settled(planner)
    (thread,) = planner._preparation._thread._threads
    del planner
    gc.collect()
    thread.join(60.0)
    assert not thread.is_alive()


class TestMaps:
    @pytest.mark.parametrize("shift", [0.0, 0.4])
    @pytest.mark.parametrize("cell", [0.05, 0.04])
    def test_a_way_that_was_closed_is_not_driven_through(self, tools, gates, cell, shift):
        """The safety filter goes by the new map before there are new paths."""
        wall = Box((4.4, 3.0), (0.3, 6.0))
        closed = OccupancyMap.empty((9.0, 6.0), cell).with_shapes([wall])
        closed = OccupancyMap(closed.grid, cell, (shift, 0.0, 0.0))
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 2.5, hooked({}))
        gates(planner)
        planner.update_map(closed)
        more = tools.drive(planner, drive.poses[-1], 10.0)
        gaps = [
            tools.occupied_gap(pose - (shift, 0.0, 0.0), GO1, closed.occupied, cell)
            for poses in more.poses
            for pose in poses
        ]
        assert min(gaps) > 0.0
        assert (more.poses[-1, :, 0] < 4.4 + shift).all()

    def test_a_closed_way_is_told_of(self, tools):
        closed = ROOM.with_shapes([Box((4.4, 3.0), (0.3, 6.0))])
        planner = live()
        planner.set_goal(GOAL)
        hook = hooked({40: lambda planner: planner.update_map(closed)})
        drive = tools.drive(planner, tools.placed(SQUARE, START), 4.0, hook)
        assert drive.states[-1] == "infeasible"
        hook = hooked({0: lambda planner: planner.update_map(ROOM)})
        drive = tools.drive(planner, drive.poses[-1], 60.0, hook)
        assert "infeasible" not in drive.states
        assert drive.status[-1].arrived

    def test_a_turned_grid_is_the_same_world(self, tools):
        turned = OccupancyMap(np.zeros((260, 260), np.int8), 0.05, (4.5, -4.0, 0.7))
        planner = live()
        planner.set_goal(GOAL)
        hook = hooked({60: lambda planner: planner.update_map(turned)})
        drive = tools.drive(planner, tools.placed(SQUARE, START), 60.0, hook)
        assert in_slots(drive.poses[-1], SQUARE, GOAL)

    def test_maps_that_keep_changing_are_taken_up(self, tools):
        """Even where a preparation takes longer than the map stays as it is."""
        planner = live()
        planner.set_goal(GOAL)

        def hook(cycle, planner):
            if cycle % 2:
                settled(planner)
            crate = Box((4.5, 0.4 + 0.01 * (cycle % 60)), (0.3, 0.3))
            planner.update_map(ROOM.with_shapes([crate]))

        assert tools.drive(planner, tools.placed(SQUARE, START), 60.0, hook).status[-1].arrived


class TestRamps:
    """Commands and robots alike keep to the limits of acceleration."""

    @pytest.mark.parametrize("rate", [10.0, 20.0, 50.0])
    def test_paused_it_brakes_and_resumed_it_sets_off(self, tools, rate):
        planner = live(rate=rate)
        planner.set_goal(GOAL)
        first, second, end = round(3 * rate), round(5 * rate), 7.0
        actions = {
            first: lambda planner: planner.pause(),
            second: lambda planner: planner.resume(),
        }
        drive = tools.drive(planner, tools.placed(SQUARE, START), end, hooked(actions))
        model, period = robot_model("go1"), 1.0 / rate
        assert set(drive.states[first:second]) == {"paused"}
        speeds = np.hypot(drive.commands[:, :, 0], drive.commands[:, :, 1])
        assert speeds[first - 1].max() > 0.3
        braking = np.diff(speeds[first - 1 : second], axis=0)
        assert (braking < 1e-9).all()
        # The body turns meanwhile, and the filter may brake harder: it is what is safe.
        assert braking.min() > -1.05 * model.max_acceleration * period
        np.testing.assert_allclose(drive.commands[first + round(rate) : second], 0.0, atol=1e-9)
        setting_off = np.diff(speeds[second - 1 : second + round(0.4 * rate)], axis=0)
        assert setting_off.max() < 1.05 * model.max_acceleration * period
        turns = np.abs(np.diff(drive.commands[first - 1 :, :, 2], axis=0))
        assert turns[: round(rate)].max() < 1.05 * model.max_yaw_acceleration * period
        assert speeds[-1].max() > 0.3

    def test_a_pause_and_resume_within_a_cycle_change_nothing(self, tools):
        planner = live()
        planner.set_goal(GOAL)

        def blink(planner):
            planner.pause()
            planner.resume()

        drive = tools.drive(planner, tools.placed(SQUARE, START), 4.0, hooked({60: blink}))
        speeds = np.hypot(drive.commands[:, :, 0], drive.commands[:, :, 1]).max(axis=1)
        assert speeds[60:].min() > speeds[59] - 0.1

    def test_after_a_pause_without_cycles_it_sets_off_from_standing(self, tools):
        planner = live()
        planner.set_goal(GOAL)
        drive = tools.drive(planner, tools.placed(SQUARE, START), 3.0, hooked({}))
        planner.pause()
        planner.resume()
        settled(planner)
        commands = planner.step(drive.poses[-1], 9.0)
        assert np.hypot(commands[:, 0], commands[:, 1]).max() < 0.055
