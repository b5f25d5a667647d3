"""A door that something blocks for good: ways around, words where there are none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.formation import VARIANTS, DynamicObstacle, Formation, FormationPlanner
from cavalcade.world import Box, OccupancyMap

ROOM = OccupancyMap.empty((9.0, 6.0), 0.05)
GO1 = (0.65, 0.28)


def planner_for(formation, map, goal, **values):
    planner = FormationPlanner(map, formation, **values)
    planner.set_goal(goal)
    return planner


def in_slots(poses, formation, goal, tolerance=0.10):
    places = formation.placed(goal)
    apart = np.hypot(*(poses[:, None, :2] - places[None]).transpose(2, 0, 1))
    return len(set(apart.argmin(axis=1))) == len(poses) and apart.min(axis=1).max() < tolerance


class TestDoor:
    """A door that one thing or another blocks for good."""

    WORLD = ROOM.with_shapes([Box((4.5, 1.25), (0.3, 2.5)), Box((4.5, 4.75), (0.3, 2.5))])
    LINE = Formation.line(3, 1.0)
    GOAL = (7.0, 3.0, 0.0)
    POSES = np.array([[2.0, 2.5, 0.0], [2.0, 3.5, 0.0], [4.5, 3.0, 0.0]])

    def test_a_lost_robot_in_it_is_named_as_no_way(self, tools):
        planner = planner_for(self.LINE, self.WORLD, self.GOAL)
        planner.lose(2)
        drive = tools.drive(planner, self.POSES, 3.0)
        status = drive.status[-1]
        assert set(drive.states) == {"infeasible"}
        assert status.involved == (0, 1)
        assert status.message == "no path to the goal for robots 0, 1"
        assert (drive.commands == 0.0).all()
        # Once it takes part again, all go.
        planner.rejoin(2)
        drive = tools.drive(planner, drive.poses[-1], 90.0)
        assert in_slots(drive.poses[-1], self.LINE, self.GOAL)

    @pytest.mark.parametrize(
        "variant",
        # Three in a line do not fit through as one rigid body.
        [name for name in VARIANTS if name != "virtual-structure"],
    )
    def test_a_lost_robot_carried_away_frees_the_way(self, variant):
        planner = planner_for(self.LINE, self.WORLD, self.GOAL, variant=variant)
        planner.lose(2)
        planner.step(self.POSES, 0.0)
        assert planner.status.state == "infeasible"
        poses = self.POSES.copy()
        poses[2] = (2.0, 5.3, 0.0)
        planner.step(poses, 0.05)
        command = planner.step(poses, 0.10)
        assert planner.status.state == "partial"
        assert np.abs(command[:2]).max() > 0.05

    def test_what_the_map_does_not_show_ends_in_a_word(self, tools):
        planner = planner_for(Formation.column(2, 1.0), self.WORLD, self.GOAL)
        planner.set_dynamic_obstacles([DynamicObstacle(Box((4.5, 3.0), (0.4, 0.9)), (0.0, 0.0))])
        drive = tools.drive(planner, self.POSES[:2], 90.0)
        status = drive.status[-1]
        assert status.state == "stuck"
        assert set(status.involved) <= {0, 1}
        assert status.involved
        assert status.message.startswith("deadlock of robot")
        assert "resolving" in drive.states
        np.testing.assert_allclose(drive.commands[-1], 0.0, atol=1e-9)
        for poses in drive.poses[::4]:
            for pose in poses:
                box = np.array([4.5, 3.0, 0.0])
                assert tools.sampled_gap(pose, box, GO1, (0.4, 0.9)) > 0.0
        # Stuck stays stuck until it is told of a change.
        planner.set_dynamic_obstacles([])
        planner.step(drive.poses[-1], 90.0)
        assert planner.status.state == "stuck"
        planner.resume()
        drive = tools.drive(planner, drive.poses[-1], 60.0)
        assert in_slots(drive.poses[-1], Formation.column(2, 1.0), self.GOAL)
        assert math.isfinite(drive.commands.max())

    def test_a_lost_robot_beside_the_way_is_gone_around(self, tools):
        planner = planner_for(self.LINE, ROOM, self.GOAL)
        planner.lose(2)
        poses = self.POSES.copy()
        poses[:2, 1] = 3.0, 4.2
        poses[0, 0] = 2.5
        drive = tools.drive(planner, poses, 60.0)
        assert drive.status[-1].arrived
        assert "stuck" not in drive.states
        for step in drive.poses[::2]:
            assert min(tools.sampled_gap(step[k], step[2], GO1, GO1) for k in (0, 1)) > 0.0
