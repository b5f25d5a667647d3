"""What the planner is given: refused where malformed, else taken as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.formation import Formation, FormationPlanner, Imperfections
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

ROOM = OccupancyMap.empty((8.0, 5.0), 0.05)
START, GOAL = (1.5, 2.5, 0.0), (6.4, 2.6, 0.5)

PLANNER = {"map": ROOM, "formation": Formation.square()}


class TestInput:
    @pytest.mark.parametrize(
        ("values", "message"),
        [
            ({"robots": 3}, "formation: the shape square has 4 slots for 3 robots"),
            ({"model": "go9"}, "unknown robot model 'go9'"),
            ({"variant": "clever"}, r"planner\.variant: unknown variant 'clever'"),
            ({"settings": "field"}, r"settings: unknown preset 'field' \(one of: simulation"),
            ({"rate": 0.0}, "rate: expected"),
            ({"rate": math.nan}, "rate: expected"),
            ({"lookahead": -1.0}, "lookahead: expected"),
            ({"lookahead": math.nan}, "lookahead: expected"),
        ],
    )
    def test_malformed_arguments(self, values, message):
        with pytest.raises(InputError, match=message):
            FormationPlanner(**PLANNER | values)

    @pytest.mark.parametrize(
        "poses",
        [
            np.zeros((3, 3)),
            np.zeros((4, 2)),
            np.zeros(12),
            np.full((4, 3), np.nan),
            [[0.0, 0.0, np.inf]] * 4,
        ],
    )
    def test_malformed_poses(self, poses):
        planner = FormationPlanner(**PLANNER)
        with pytest.raises(InputError, match="poses: expected"):
            planner.step(poses, 0.0)

    @pytest.mark.parametrize("time", [math.nan, math.inf])
    def test_malformed_time(self, time):
        with pytest.raises(InputError, match="time"):
            FormationPlanner(**PLANNER).step(np.zeros((4, 3)), time)

    @pytest.mark.parametrize("stamps", [0.0, np.zeros(3), np.full(4, np.nan)])
    @pytest.mark.parametrize("expected", [None, Imperfections(delay=0.1)])
    def test_malformed_stamps(self, stamps, expected):
        planner = FormationPlanner(**PLANNER, expected=expected)
        with pytest.raises(InputError, match="stamps"):
            planner.step(np.zeros((4, 3)), 0.0, stamps)

    @pytest.mark.parametrize(
        "goal", [(1.0, 2.0), (1.0, 2.0, np.nan), (1.0, 2.0, 3.0, 4.0), (np.inf, 0.0, 0.0)]
    )
    def test_malformed_goals(self, goal):
        with pytest.raises(InputError, match="goal: expected"):
            FormationPlanner(**PLANNER).set_goal(goal)

    def test_a_refused_goal_leaves_the_planner_as_it_was(self, tools):
        square = Formation.square()
        planner = FormationPlanner(ROOM, square)
        planner.set_goal(GOAL)
        with pytest.raises(InputError):
            planner.set_goals([(1.0, 1.0, 0.0), (1.0, 1.0, math.nan)])
        planner.step(tools.placed(square, START), 0.0)
        assert planner.status.goal == pytest.approx(GOAL)

    def test_a_preset_by_its_name(self):
        assert FormationPlanner(**PLANNER, settings="laboratory").settings.lookahead == 2.5
        planner = FormationPlanner(**PLANNER, settings="laboratory", lookahead=4.0)
        assert planner.settings.lookahead == 4.0

    def test_a_model_of_ones_own(self, tools):
        from dataclasses import replace

        slow = replace(robot_model("go1"), name="slow", max_speed_x=0.2, max_speed_y=0.1)
        planner = FormationPlanner(ROOM, Formation.column(1), model=slow)
        planner.set_goal(GOAL)
        drive = tools.drive(planner, np.array([START]), 3.0)
        assert 0.1 < drive.commands[..., 0].max() <= 0.2 + 1e-9

    def test_what_comes_in_is_not_changed(self, tools):
        square = Formation.square()
        planner = FormationPlanner(ROOM, square)
        planner.set_goal(GOAL)
        poses = tools.placed(square, START)
        before = poses.copy()
        planner.step(poses, 0.0)
        np.testing.assert_array_equal(poses, before)
