"""Problems of teams on a map, without a scenario."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.coordination import TeamProblem, plan_team, problem_of
from cavalcade.errors import CavalcadeError, InputError
from cavalcade.geometry import transform_points
from cavalcade.robots import robot_model
from cavalcade.scenario import build_world, load_scenario
from cavalcade.world import OccupancyMap

STARTS = [(1, 2, 0), (5, 2, np.pi)]
GOALS = STARTS[::-1]


def test_a_map_models_starts_and_goals_are_enough():
    plan = plan_team(TeamProblem.on_map(OccupancyMap.empty((6, 4)), ["go1"] * 2, STARTS, GOALS))
    assert plan.solved
    for path, start, goal in zip(plan.trajectories, STARTS, GOALS, strict=True):
        assert path.position[0, :2] == pytest.approx(start[:2])
        assert path.position[-1, :2] == pytest.approx(goal[:2])


def test_poses_are_in_the_frame_of_the_map():
    origin = (3.0, -2.0, 0.5)
    map = OccupancyMap(np.zeros((80, 120), dtype=bool), 0.05, origin)
    starts, goals = _in_map(STARTS, origin), _in_map(GOALS, origin)
    problem = TeamProblem.on_map(map, [robot_model("go1")] * 2, starts, goals)
    assert np.array(problem.starts) == pytest.approx(np.array(STARTS))
    assert np.array(problem.goals) == pytest.approx(np.array(GOALS))
    plan = plan_team(problem)
    for path, start in zip(plan.trajectories, starts, strict=True):
        assert path.position[0, :2] == pytest.approx(start[:2])
        assert path.yaw[0] == pytest.approx(start[2])


def _in_map(poses, origin):
    """The poses, given in the frame of `origin`, in the map's."""
    points = transform_points(origin, np.array(poses)[:, :2])
    yaws = np.array(poses)[:, 2] + origin[2]
    return list(map(tuple, np.column_stack([points, yaws]).tolist()))


def test_a_scenario_poses_the_same_problem():
    scenario = load_scenario("head-on")
    world = build_world(scenario)
    names = [model.name for model in scenario.models]
    by_hand = TeamProblem.on_map(world.map, names, scenario.starts, scenario.goals)
    problem = problem_of(scenario, world)
    assert (by_hand.starts, by_hand.goals) == (problem.starts, problem.goals)
    assert by_hand.models == problem.models
    assert (by_hand.ground.clearance == problem.ground.clearance).all()


def test_each_robot_has_a_start_and_a_goal_and_is_known():
    map = OccupancyMap.empty((6, 4))
    with pytest.raises(InputError, match="goals: expected 2 poses, not 1"):
        TeamProblem.on_map(map, ["go1"] * 2, STARTS, GOALS[:1])
    with pytest.raises(CavalcadeError, match="nobody"):
        TeamProblem.on_map(map, ["nobody"] * 2, STARTS, GOALS)
