"""Noticing that a team gets nowhere, and sending it through one by one."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from cavalcade.formation import Formation
from cavalcade.formation.deadlock import PATIENCE, DeadlockMonitor, ProgressMonitor
from cavalcade.formation.team import Team
from cavalcade.world import OccupancyMap

ROOM = OccupancyMap.empty((10.0, 6.0), 0.05)
LINE = Formation.line(3, 1.0)
GOAL = (8.0, 3.0, 0.0)
ROLES = np.arange(3)
PERIOD = 0.25


class TestMonitor:
    def test_it_is_patient_for_its_time_and_no_longer(self):
        monitor = ProgressMonitor(3.0)
        stalled = [monitor.stalled(5.0, time) for time in np.arange(0.0, 4.0, 0.5)]
        assert stalled == [False] * 7 + [True]

    @pytest.mark.parametrize(("rate", "expected"), [(0.05, False), (0.02, True)])
    def test_a_tenth_now_and_then_is_progress(self, rate, expected):
        monitor = ProgressMonitor(3.0)
        assert expected is any(
            monitor.stalled(9.0 - rate * time, time) for time in np.arange(0.0, 12.0, 0.05)
        )

    def test_going_back_and_forth_is_none(self):
        monitor = ProgressMonitor(3.0)
        stalled = [
            monitor.stalled(5.0 + math.sin(time), 4.5 + time) for time in np.arange(0.0, 12.0, 0.1)
        ]
        assert any(stalled)

    def test_after_a_reset_it_is_patient_anew(self):
        monitor = ProgressMonitor(3.0)
        monitor.stalled(5.0, 0.0)
        monitor.reset()
        assert not monitor.stalled(5.0, 10.0)
        assert not monitor.stalled(5.0, 13.0)
        assert monitor.stalled(5.0, 13.1)

    def test_an_infinite_measure_is_no_progress(self):
        monitor = ProgressMonitor(3.0)
        assert [monitor.stalled(math.inf, time) for time in (0.0, 2.0, 4.0)] == [False, False, True]


class Story:
    """A watch, a cycle it looks at and a clock; the test says what the robots do."""

    def __init__(self, tools, seed=0, lookahead=5.0, poses=None, team=None):
        self.watch = DeadlockMonitor(lookahead, np.random.default_rng(seed))
        poses = np.column_stack([LINE.placed((2.0, 3.0, 0.0)), np.zeros(3)]) if poses is None \
            else poses  # fmt: skip
        self.cycle = tools.cycle_of(ROOM, LINE, poses, GOAL, team=team)
        self.state = "partial"
        self.says: list[str] = []

    def tell(self, eta, seconds=PERIOD, fall=0.0, single_file=False):
        """Times `(3,)` that fall by `fall` per second; returns the states of these cycles."""
        first = len(self.says)
        for _ in range(round(seconds / PERIOD)):
            self.cycle.eta = np.array(eta, dtype=float) - fall * (len(self.says) - first) * PERIOD
            self.state = self.watch.next_state(self.state, self.cycle, ROLES)
            if single_file and self.state == "resolving":
                self.watch.single_file(self.cycle)
            self.says.append(self.state)
            self.cycle.time += PERIOD
        return self.says[first:]


ETA = (9.0, 10.0, 11.0)


class TestOnTheWay:
    def test_a_team_that_gets_on_is_left_alone(self, tools):
        assert set(Story(tools).tell((40.0, 41.0, 42.0), 60.0, fall=0.5)) == {"partial"}

    def test_one_that_does_not_is_given_its_time(self, tools):
        says = Story(tools).tell(ETA, 4.0)
        wait = says.index("resolving") * PERIOD
        assert PATIENCE < wait <= PATIENCE + PERIOD
        assert set(says) == {"partial", "resolving"}

    def test_one_robot_that_gets_on_is_progress_of_the_team(self, tools):
        story = Story(tools)
        for k in range(40):
            story.tell((30.0 - 0.3 * k, 31.0, 32.0))
        assert set(story.says) == {"partial"}

    def test_a_robot_without_a_way_does_not_hide_it(self, tools):
        assert Story(tools).tell((9.0, math.inf, 11.0), 4.0)[-1] == "resolving"

    def test_one_that_takes_no_part_does_not_count(self, tools):
        team = Team(3, LINE)
        team.lose(1)
        story = Story(tools, team=team)
        for k in range(40):
            story.tell((9.0, 60.0 - k, 11.0))
        assert "resolving" in story.says

    def test_new_maps_and_states_make_it_patient_anew(self, tools):
        story = Story(tools)
        for _ in range(6):
            story.tell(ETA, 2.5)
            story.watch.refresh()
        assert set(story.says) == {"partial"}


class TestResolving:
    def begun(self, tools, **values):
        story = Story(tools, **values)
        story.tell((20.0, 21.0, 22.0), 3.5)
        assert story.state == "resolving"
        return story

    def test_it_returns_to_the_shape_when_enough_is_gained(self, tools):
        story = self.begun(tools)
        assert set(story.tell((18.0, 18.9, 20.0), PERIOD)) == {"resolving"}
        assert "partial" not in story.tell((17.0, 17.1, 30.0), PERIOD)  # 3.9 s of the median
        assert story.tell((16.0, 16.9, 18.0), PERIOD) == ["partial"]

    def test_not_so_near_the_goal_that_it_would_be_final_at_once(self, tools):
        story = self.begun(tools)
        assert story.tell((4.9, 6.0, 7.0), PERIOD) == ["resolving"]

    def test_what_the_leader_gains_alone_is_not_enough(self, tools):
        assert set(self.begun(tools).tell((6.0, 21.0, 22.0), 2.0)) == {"resolving"}

    def test_every_attempt_must_gain_more(self, tools):
        story = self.begun(tools)
        story.tell((20.0, 21.0, 22.0), 3.5)  # a second attempt
        assert story.tell((15.5, 16.0, 18.0), PERIOD) == ["resolving"]
        assert story.tell((14.0, 14.9, 18.0), PERIOD) == ["partial"]

    def test_back_in_the_shape_it_is_patient_anew(self, tools):
        story = self.begun(tools)
        assert story.tell((10.0, 11.0, 12.0), PERIOD) == ["partial"]
        assert set(story.tell((10.0, 11.0, 12.0), 3.0)) == {"partial"}
        assert "resolving" in story.tell((10.0, 11.0, 12.0), 0.75)


class TestStuck:
    def attempts(self, story, eta=ETA):
        """How many times anything was tried before it was given up."""
        count = 0
        for _ in range(1000):
            before = story.watch.attempts
            story.tell(eta)
            if story.state == "stuck":
                return count
            count += story.watch.attempts > before
        raise AssertionError("never stuck")

    def test_after_sixattempts_it_says_so(self, tools):
        story = Story(tools)
        assert self.attempts(story) == 6
        assert story.cycle.time == pytest.approx(7 * PATIENCE, abs=7 * 2 * PERIOD)
        assert [key for key, _ in itertools.groupby(story.says)] == [
            "partial", "resolving", "stuck"
        ]  # fmt: skip

    def test_it_names_who_is_not_in_a_slot(self, tools):
        poses = np.column_stack([LINE.placed(GOAL), np.zeros(3)])
        poses[1, 1] += 0.4
        story = Story(tools, poses=poses)
        story.state = "final"
        story.tell((0.5, 3.0, 0.5), 40.0)
        assert "stuck" in story.says
        assert story.watch.late == (1,)

    def test_the_next_time_it_tries_as_often_again(self, tools):
        story = Story(tools)
        self.attempts(story)
        story.watch.refresh()
        story.state = "partial"
        assert self.attempts(story) == 6

    def test_a_team_that_got_well_away_has_allattempts_again(self, tools):
        story = Story(tools)
        story.tell((40.0, 40.0, 40.0), 4 * 3.5)
        assert story.state == "resolving"
        story.tell((28.0, 28.0, 28.0), PERIOD)
        assert story.state == "partial"
        assert self.attempts(story, (28.0, 28.0, 28.0)) == 6

    def test_one_that_got_away_a_little_has_not(self, tools):
        story = Story(tools)
        story.tell((40.0, 40.0, 40.0), 3.5)
        story.tell((35.0, 35.0, 35.0), PERIOD)
        assert story.state == "partial"
        assert self.attempts(story, (35.0, 35.0, 35.0)) == 5

    def test_another_goal_forgets_all(self, tools):
        story = Story(tools)
        story.tell(ETA, 12.0)
        story.watch.restart()
        story.state = "partial"
        assert self.attempts(story) == 6


class TestAtTheGoal:
    def story(self, tools, off):
        poses = np.column_stack([LINE.placed(GOAL), np.zeros(3)])
        poses[0, 0] -= off
        story = Story(tools, poses=poses)
        story.state = "final"
        return story

    def test_in_their_slots_they_may_stand_for_ever(self, tools):
        assert set(self.story(tools, 0.07).tell((0.2, 0.2, 0.2), 60.0)) == {"final"}

    def test_one_that_stays_away_is_a_stand_off(self, tools):
        assert "resolving" in self.story(tools, 0.5).tell((0.6, 0.1, 0.1), 4.0)

    def test_there_distances_count_and_not_times(self, tools):
        story = self.story(tools, 3.0)
        for _ in range(60):
            story.cycle.points[0, 0] += 0.04
            story.tell((2.0, 2.0, 2.0))
        assert set(story.says) == {"final"}

    def test_a_team_that_gets_on_is_left_alone_where_the_measure_changes(self, tools):
        """Resolving, the first robot near: from now on distances count, the sum of all."""
        poses = np.array([[7.0, 2.0, 0.0], [2.0, 3.0, 0.0], [2.0, 4.0, 0.0]])
        story = Story(tools, poses=poses)
        story.tell((1.1, 3.0, 3.0), 3.5)
        assert story.state == "resolving"
        story.tell((1.05, 2.0, 2.0), PERIOD)
        attempts = story.watch.attempts
        for _ in range(24):  # two robots drive at 0.3 m/s
            story.cycle.points[1:, 0] += 0.3 * PERIOD
            story.tell((0.9, 2.0, 2.0))
        assert story.watch.attempts == attempts


class TestSingleFile:
    def resolving(self, tools, seed=0, attempts=1, poses=None):
        story = Story(tools, seed, poses=poses)
        story.tell(ETA, 3.25 * attempts)
        while story.watch.attempts < attempts or story.state != "resolving":
            story.tell(ETA)
        assert story.watch.attempts == attempts
        return story

    def order(self, tools, seed, attempts):
        """The precedence in that attempt."""
        story = self.resolving(tools, seed, attempts)
        return story.watch.single_file(story.cycle).rank.tolist()

    def test_each_goes_its_own_way_to_its_slot(self, tools):
        story = self.resolving(tools)
        single = story.watch.single_file(story.cycle)
        assert sorted(single.roles) == [0, 1, 2]
        for k, path in enumerate(single.paths):
            np.testing.assert_allclose(path[0], story.cycle.points[k])
            assert math.dist(path[-1], story.cycle.plan.places[single.roles[k]]) < 0.05
        np.testing.assert_allclose(np.hypot(*single.courses.T), 1.0)
        assert (single.courses[:, 0] > 0.9).all()

    def test_at_first_those_ahead_go_first(self, tools):
        story = self.resolving(tools)
        story.cycle.eta = np.array([7.0, 3.0, 5.0])
        assert story.watch.single_file(story.cycle).rank.tolist() == [2, 0, 1]

    def test_then_it_goes_by_lot(self, tools):
        orders = {tuple(self.order(tools, seed, 2)) for seed in range(20)}
        assert len(orders) > 3
        story = self.resolving(tools, 0, 2)
        rank = story.watch.single_file(story.cycle).rank
        assert sorted(rank) == [0, 1, 2]
        story.cycle.eta = story.cycle.eta[::-1].copy()
        np.testing.assert_array_equal(story.watch.single_file(story.cycle).rank, rank)

    def test_the_same_seed_draws_the_same_lots(self, tools):
        one, other = (
            [self.order(tools, 7, attempts) for attempts in (2, 3, 4, 5)] for _ in range(2)
        )
        assert one == other
        assert len({tuple(order) for order in one}) > 1

    def test_in_a_repeated_attempt_they_make_room_for_earlier_ones_first(self, tools):
        poses = np.array([[2.0, 3.0, 0.0], [2.6, 3.0, 0.0], [5.0, 5.0, 0.0]])
        story = self.resolving(tools, 0, 2, poses)
        single = story.watch.single_file(story.cycle)
        near = sorted((0, 1), key=lambda k: single.rank[k])
        offset = poses[near[1], :2] - poses[near[0], :2]
        np.testing.assert_allclose(single.courses[near[1]], 0.6 * offset / np.hypot(*offset))
        assert np.hypot(*single.courses[near[0]]) == pytest.approx(1.0)
        assert np.hypot(*single.courses[2]) == pytest.approx(1.0)  # nobody is near it
        story.cycle.time += 2.0
        again = story.watch.single_file(story.cycle)
        np.testing.assert_allclose(np.hypot(*again.courses.T), 1.0)

    def test_in_the_first_attempt_nobody_steps_back(self, tools):
        poses = np.array([[2.0, 3.0, 0.0], [2.6, 3.0, 0.0], [5.0, 5.0, 0.0]])
        story = self.resolving(tools, 0, 1, poses)
        np.testing.assert_allclose(np.hypot(*story.watch.single_file(story.cycle).courses.T), 1.0)

    def test_one_that_takes_no_part_has_no_way(self, tools):
        team = Team(3, LINE)
        team.lose(1)
        story = Story(tools, team=team)
        story.tell(ETA, 3.5)
        single = story.watch.single_file(story.cycle)
        assert single.roles[1] == -1
        assert len(single.paths[1]) == 0
        assert (single.courses[1] == 0.0).all()
