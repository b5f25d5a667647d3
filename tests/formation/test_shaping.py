"""Springs, avoidance, limits and yaw, put together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import Formation, FormationSettings
from cavalcade.formation.settings import variant_named
from cavalcade.formation.shaping import Shaper, _spare_pace
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

GO1 = robot_model("go1")
PAIR = Formation.column(2, 1.0)
GOAL = (12.0, 4.0, 0.0)
OPEN = OccupancyMap.empty((16.0, 8.0), 0.05)
WALL = OPEN.with_shapes([Box((8.0, 1.0), (16.0, 2.0))])  # its surface at y = 2
VELOCITIES = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def shaper_for(variant="cavalcade", **values):
    return Shaper(variant_named(variant), FormationSettings(**values), GO1, 0.05)


def shaped(
    tools, poses, desired, variant="cavalcade", map=OPEN, springs=False, away=np.inf, spacing=1.0
):
    """The velocity of a pair in its slots' order."""
    cycle = tools.cycle_of(map, Formation.column(2, spacing), poses, GOAL)
    cycle.roles = np.arange(2)
    cycle.away = np.full(2, away)
    shaper_for(variant).shape(cycle, np.array(desired), springs)
    return cycle.velocity


class TestSparePace:
    @settings(max_examples=200, deadline=None)
    @given(st.floats(-3.2, 3.2), st.floats(0.01, 1.5), VELOCITIES, st.floats(0.0, 1.0))
    def test_springs_slow_a_robot_by_no_more_than_that(self, angle, pace, change, most):
        desired = pace * np.array([[math.cos(angle), math.sin(angle)]])
        before = desired + np.array([change])
        after = before.copy()
        _spare_pace(after, desired, most)
        course = desired[0] / pace
        across = np.array([-course[1], course[0]])
        assert after[0] @ course >= pace - most - 1e-9
        # What turns the robot or speeds it up stays, and so does what slows it by less.
        assert after[0] @ across == pytest.approx(before[0] @ across, abs=1e-9)
        if before[0] @ course >= pace - most + 1e-9:
            np.testing.assert_allclose(after, before, atol=1e-9)
        else:
            assert after[0] @ course == pytest.approx(pace - most, abs=1e-8)

    def test_a_leader_that_is_far_ahead_still_goes_on(self, tools):
        """The published springs, stretched, would stop it; ours leave it half its pace."""
        poses = [(7.0, 4.0, 0.0), (4.0, 4.0, 0.0)]
        desired = [(0.5, 0.0), (0.5, 0.0)]
        ours = shaped(tools, poses, desired, springs=True)
        theirs = shaped(tools, poses, desired, "published", springs=True)
        assert theirs[0, 0] < 0.15
        assert ours[0, 0] == pytest.approx(0.25)

    def test_a_robot_that_stands_is_still_pushed(self, tools):
        poses = [(7.0, 4.0, 0.0), (6.5, 4.0, 0.0)]
        velocity = shaped(tools, poses, np.zeros((2, 2)), springs=True)
        assert velocity[0, 0] > 0.1
        assert velocity[1, 0] == pytest.approx(-velocity[0, 0])


class TestSprings:
    def test_they_act_only_where_they_are_asked_for_and_had(self, tools):
        poses, desired = [(7.0, 4.0, 0.0), (6.5, 4.0, 0.0)], [(0.2, 0.0), (0.2, 0.0)]
        assert shaped(tools, poses, desired, springs=True)[0, 0] > 0.25
        for variant, springs in (("cavalcade", False), ("no-springs", True)):
            np.testing.assert_allclose(shaped(tools, poses, desired, variant, springs=springs),
                                       desired)  # fmt: skip

    @pytest.mark.parametrize("change", ["reset", "swap"])
    def test_dampers_rest_after_a_change(self, tools, change):
        """Across it lengths belong to other robots, and their difference is no speed."""
        shaper, fresh = shaper_for("published"), shaper_for("published")
        square = Formation.square(1.0)
        poses = np.column_stack([square.placed((6.0, 4.0, 0.0)), np.zeros(4)])
        poses[0, :2] += 0.2

        def shape(with_, roles, moved):
            cycle = tools.cycle_of(OPEN, square, poses + (moved, 0.0, 0.0), GOAL)
            cycle.roles = np.array(roles)
            with_.shape(cycle, np.full((4, 2), 0.1), True)
            return cycle.velocity

        shape(shaper, [0, 1, 2, 3], 0.0)
        poses[0, :2] += 0.1
        roles = [0, 1, 2, 3] if change == "reset" else [2, 3, 0, 1]
        if change == "reset":
            shaper.reset()
        found = shape(shaper, roles, 0.0)
        np.testing.assert_allclose(found, shape(fresh, roles, 0.0), atol=1e-12)

    def test_desired_velocities_are_not_touched(self, tools):
        desired = np.full((2, 2), 0.3)
        shaped(tools, [(7.0, 2.5, 0.0), (6.5, 2.5, 0.0)], desired, map=WALL, springs=True)
        assert (desired == 0.3).all()


class TestDocking:
    POSES = ((8.0, 2.45, 0.0), (5.0, 2.45, 0.0))  # 0.45 m to the wall: W_B = 0.3
    DESIRED = ((0.1, -0.1), (0.1, -0.1))

    def test_on_the_way_motion_towards_the_wall_is_taken_away(self, tools):
        for away in (0.61, np.inf):
            velocity = shaped(
                tools, self.POSES, self.DESIRED, map=WALL, away=away, springs=True, spacing=3.0
            )
            np.testing.assert_allclose(velocity, [(0.1, 0.0)] * 2, atol=0.01)

    def test_close_to_the_slot_it_stays(self, tools):
        velocity = shaped(tools, self.POSES, self.DESIRED, map=WALL, away=0.59)
        np.testing.assert_allclose(velocity, self.DESIRED, atol=1e-9)

    def test_it_is_none_of_the_paper(self, tools):
        velocity = shaped(tools, self.POSES, self.DESIRED, "published", WALL, away=0.2)
        np.testing.assert_allclose(velocity[:, 1], 0.0, atol=0.01)

    def test_each_robot_for_itself(self, tools):
        away = np.array([0.3, 2.0])
        velocity = shaped(
            tools, self.POSES, self.DESIRED, map=WALL, away=away, springs=True, spacing=3.0
        )
        assert velocity[0, 1] == pytest.approx(-0.1)
        assert velocity[1, 1] == pytest.approx(0.0, abs=0.01)

    @pytest.mark.parametrize(("variant", "reach"), [("cavalcade", 0.24), ("published", 0.40)])
    def test_before_the_slot_it_slows_down(self, tools, variant, reach):
        poses = [(7.0, 4.0, 0.0), (6.0, 4.0, 0.0)]
        for away in (0.05, 0.10, reach - 0.01, reach + 0.01, 1.0):
            pace = shaped(tools, poses, [(0.5, 0.0)] * 2, variant, away=away)[:, 0]
            np.testing.assert_allclose(pace, min(0.5 * away / reach, 0.5))

    def test_without_springs_the_path_is_trusted_everywhere(self, tools):
        velocity = shaped(tools, self.POSES, self.DESIRED, map=WALL)
        np.testing.assert_allclose(velocity, self.DESIRED, atol=1e-9)


class TestNarrow:
    """Beside a wall, on the way: W_B = 0.2 in the first place and 0.5 in the second."""

    POSES = ((8.0, 2.40, 0.0), (5.0, 2.55, 0.0))
    DESIRED = ((0.1, -0.1), (0.1, -0.1))

    def test_the_path_into_it_is_trusted(self, tools):
        rest = float(np.hypot(3.0, 0.15))  # springs at rest change nothing
        velocity = shaped(tools, self.POSES, self.DESIRED, map=WALL, springs=True, spacing=rest)
        np.testing.assert_allclose(velocity[0], self.DESIRED[0], atol=1e-9)
        np.testing.assert_allclose(velocity[1], (0.1, 0.0), atol=0.02)

    def test_the_paper_filters_it_too(self, tools):
        velocity = shaped(tools, self.POSES, self.DESIRED, "published", WALL)
        np.testing.assert_allclose(velocity, [(0.1, 0.0)] * 2, atol=0.02)

    def test_what_springs_add_is_filtered_all_the_same(self, tools):
        """A neighbour too near presses the other one to the wall."""
        poses = [(8.0, 2.40, 0.0), (8.0, 2.95, 0.0)]
        for variant in ("cavalcade", "published"):
            pressed = shaped(tools, poses, [(0.1, 0.0)] * 2, variant, WALL, springs=True)
            assert pressed[0, 1] > -0.01
            assert pressed[1, 1] > 0.05

    def test_springs_away_from_the_wall_are_left(self, tools):
        poses = [(8.0, 2.40, 0.0), (8.0, 4.0, 0.0)]
        velocity = shaped(tools, poses, [(0.0, 0.0)] * 2, map=WALL, springs=True)
        assert velocity[0, 1] > 0.1


def yaw_rates(tools, poses, velocity, variant="cavalcade", map=OPEN, paths=None, **values):
    cycle = tools.cycle_of(map, PAIR, poses, values.pop("goal", GOAL), **values)
    cycle.velocity = np.array(velocity)
    if paths is not None:
        cycle.paths = paths
    return cycle, shaper_for(variant)


class TestYaw:
    NARROW = ((8.0, 2.40, 0.1), (5.0, 4.0, 0.1))  # W_B = 0.2 beside the wall, 1 in the open
    AHEAD = np.column_stack([np.arange(30) * 0.025, np.zeros(30)])  # along x

    @settings(max_examples=60, deadline=None)
    @given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
    def test_it_turns_the_short_way_to_where_it_goes(self, tools, yaw, course):
        velocity = [(0.3 * math.cos(course), 0.3 * math.sin(course)), (0.0, 0.0)]
        cycle, shaper = yaw_rates(tools, [(8.0, 4.0, yaw), (6.0, 4.0, yaw)], velocity)
        rate = shaper.yaw_rates(cycle)
        error = math.remainder(course - yaw, 2.0 * math.pi)
        if abs(error) < 3.1:
            assert rate[0] == pytest.approx(np.clip(2.5 * error, -1.2, 1.2), abs=1e-6)
        assert rate[1] == 0.0

    def test_in_narrow_ground_it_looks_along_its_way(self, tools):
        """Springs and avoidance push aside; the body must not turn across."""
        velocity = [(0.05, 0.2), (0.05, 0.2)]
        paths = tuple(self.AHEAD + pose[:2] for pose in self.NARROW)
        cycle, shaper = yaw_rates(tools, self.NARROW, velocity, map=WALL, paths=paths)
        rate = shaper.yaw_rates(cycle)
        assert rate[0] == pytest.approx(-0.25)  # to the path's heading, 0
        assert rate[1] == pytest.approx(1.2)  # to the velocity's

    def test_without_a_path_it_goes_by_its_velocity(self, tools):
        cycle, shaper = yaw_rates(tools, self.NARROW, [(0.05, 0.2), (0.05, 0.2)], map=WALL)
        assert shaper.yaw_rates(cycle)[0] == pytest.approx(1.2)

    def test_the_paper_always_goes_by_the_velocity(self, tools):
        paths = tuple(self.AHEAD + pose[:2] for pose in self.NARROW)
        cycle, shaper = yaw_rates(
            tools, self.NARROW, [(0.05, 0.2), (0.05, 0.2)], "published", WALL, paths
        )
        np.testing.assert_allclose(shaper.yaw_rates(cycle), 1.2)

    @pytest.mark.parametrize("variant", ["cavalcade", "published"])
    def test_near_its_final_slot_it_takes_up_the_goals_heading(self, tools, variant):
        goal = (12.0, 4.0, 0.4)
        paths = tuple(self.AHEAD + pose[:2] for pose in self.NARROW)
        cycle, shaper = yaw_rates(
            tools, self.NARROW, [(0.0, 0.3), (0.0, 0.3)], variant, WALL, paths, goal=goal
        )
        cycle.final, cycle.away = True, np.array([0.29, 0.31])
        rate = shaper.yaw_rates(cycle)
        assert rate[0] == pytest.approx(2.5 * 0.3)
        assert rate[1] == pytest.approx(1.2)
        # On the way a slot that happens to be near means nothing.
        cycle.final = False
        assert shaper.yaw_rates(cycle)[0] != pytest.approx(2.5 * 0.3)


@pytest.mark.parametrize("variant", ["cavalcade", "published"])
def test_one_that_takes_no_part_is_told_nothing(tools, variant):
    cycle = tools.cycle_of(OPEN, PAIR, [(7.0, 4.0, 1.0), (6.5, 4.0, 1.0)], GOAL)
    cycle.team.present[1] = False
    cycle.roles = np.array([0, -1])
    shaper = shaper_for(variant)
    shaper.shape(cycle, np.full((2, 2), 0.3), True)
    assert np.hypot(*cycle.velocity[0]) > 0.1
    assert cycle.velocity[1].tolist() == [0.0, 0.0]
    rate = shaper.yaw_rates(cycle)
    assert abs(rate[0]) > 0.1
    assert rate[1] == 0.0


def test_the_slower_of_model_and_settings_counts(tools):
    assert shaper_for(v_max_x=0.3).top == 0.3
    assert shaper_for(v_max_x=3.0).top == GO1.max_speed_x
    cycle = tools.cycle_of(OPEN, PAIR, [(7.0, 4.0, 0.0), (5.0, 4.0, math.pi / 2)], GOAL)
    shaper_for(v_max_x=3.0, v_max_y=3.0).shape(cycle, np.full((2, 2), (5.0, 0.0)), False)
    np.testing.assert_allclose(cycle.velocity, [(0.5, 0.0), (0.2, 0.0)], atol=1e-9)


class TestRest:
    """In its slot a robot rests, so that noise on the poses does not keep it busy."""

    def paces(self, tools, distances, variant="cavalcade"):
        """Of a robot that is told to drive to a slot that far away, one cycle after another."""
        shaper, found = shaper_for(variant), []
        for away in distances:
            cycle = tools.cycle_of(OPEN, PAIR, [(7.0, 4.0, 0.0), (6.0, 4.0, 0.0)], GOAL)
            cycle.roles, cycle.away = np.arange(2), np.array([away, 3.0])
            shaper.shape(cycle, np.full((2, 2), (0.4, 0.0)), False)
            assert cycle.velocity[1, 0] == pytest.approx(0.4)
            found.append(cycle.velocity[0, 0])
        return np.array(found)

    def test_from_where_it_is_reached_until_it_is_clearly_left(self, tools):
        pace = self.paces(tools, [0.3, 0.05, 0.02, 0.01, 0.02, 0.04, 0.01, 0.20, 0.04, 0.01])
        assert (pace > 0.0).tolist() == [True] * 3 + [False] * 4 + [True, True, False]

    def test_a_slot_anew_is_reached_anew(self, tools):
        shaper = shaper_for()
        for away, resting in ((0.01, True), (0.04, True), (None, None), (0.04, False)):
            if away is None:
                shaper.reset()
                continue
            cycle = tools.cycle_of(OPEN, PAIR, [(7.0, 4.0, 0.0), (6.0, 4.0, 0.0)], GOAL)
            cycle.roles, cycle.away = np.arange(2), np.full(2, away)
            shaper.shape(cycle, np.full((2, 2), (0.4, 0.0)), False)
            assert resting == bool((cycle.velocity == 0.0).all())

    def test_it_is_none_of_the_paper(self, tools):
        assert (self.paces(tools, [0.01, 0.005, 0.01], "published") > 0.0).all()

    def test_nor_does_it_turn(self, tools):
        shaper = shaper_for()
        rates = []
        for yaw in (0.2, 0.05, 0.02, 0.05, 0.08, 0.3):
            cycle = tools.cycle_of(OPEN, PAIR, [(7.0, 4.0, yaw), (6.0, 4.0, 0.5)], GOAL)
            cycle.velocity, cycle.final = np.zeros((2, 2)), True
            cycle.away = np.array([0.01, 0.01])
            rates.append(shaper.yaw_rates(cycle))
        rates = np.array(rates)
        assert (rates[:, 0] != 0.0).tolist() == [True, True, False, False, False, True]
        assert (rates[:, 1] < 0.0).all()
