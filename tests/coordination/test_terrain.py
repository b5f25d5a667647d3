"""Teams on uneven ground: they walk where they can, leap where they must, one after the other."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from cavalcade.coordination import PlanSettings, TeamPlan, TeamProblem, plan_team
from cavalcade.coordination.terrain import delayed, walkable
from cavalcade.errors import InputError
from cavalcade.lattice.ground import make_ground
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap, generate_terrain

FLIGHT = 2


def _problem(kind: str, robots: list, **options: float) -> TeamProblem:
    terrain = generate_terrain(kind, (9.0, 4.0), 1, **options)
    ground = make_ground(OccupancyMap(np.zeros(terrain.height.shape, bool), 0.05), terrain)
    names, starts, goals = zip(*robots, strict=True)
    return TeamProblem(ground, tuple(map(robot_model, names)), starts, goals)


def _gap(footprint_gap: Callable, problem: TeamProblem, plan: TeamPlan) -> float:
    """Least distance of two robots' bodies, until long after both have parked, m."""
    time = np.arange(0.0, max(t.duration for t in plan.trajectories) + 1.0, 0.01)
    shapes = [(m.length / 2, m.width / 2, False) for m in problem.models]
    tracks = [t.poses_at(time) for t in plan.trajectories]
    return min(
        footprint_gap(shapes[i], tracks[i], shapes[j], tracks[j]).min()
        for i in range(len(tracks))
        for j in range(i)
    )


def _ends(problem: TeamProblem, plan: TeamPlan) -> None:
    for t, start, goal in zip(plan.trajectories, problem.starts, problem.goals, strict=True):
        assert np.diff(t.time).min() > 0.0
        assert np.diff(t.time).max() <= 0.03 + 1e-9
        for k, pose in ((0, start), (-1, goal)):
            assert t.position[k, :2] == pytest.approx(pose[:2], abs=1e-6)
            assert math.remainder(t.yaw[k] - pose[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


PAIR = [
    ("spirit", (2.0, 2.0, 0.0), (7.0, 2.0, 0.0)),
    ("spirit", (7.0, 2.0, math.pi), (2.0, 2.0, math.pi)),
]


@pytest.mark.parametrize("method", ["auto", "sequential", "cbs"])
def test_two_exchange_sides_of_a_gap(footprint_gap, method):
    problem = _problem("gap", PAIR, width=0.3)
    plan = plan_team(problem, method, seed=1)
    assert plan.solved, plan.detail
    _ends(problem, plan)
    assert all((t.phase == FLIGHT).any() for t in plan.trajectories)
    # Nobody flies over another: bodies are apart as seen from above, at all times.
    assert _gap(footprint_gap, problem, plan) > 0.0


def test_three_over_rough_ground(footprint_gap):
    robots = [*PAIR, ("go1", (4.5, 0.8, 1.6), (4.5, 3.2, 1.6))]
    problem = _problem("rough", robots)
    plan = plan_team(problem, seed=4)
    assert plan.solved, plan.detail
    _ends(problem, plan)
    assert _gap(footprint_gap, problem, plan) > 0.0


def test_the_same_seed_gives_the_same_bytes(bytes_of):
    problem = _problem("gap", PAIR, width=0.3)
    first, again = (bytes_of(plan_team(problem, seed=4)) for _ in range(2))
    assert first == again


def test_without_leaps_a_gap_cannot_be_crossed():
    problem = _problem("gap", PAIR, width=0.4)
    plan = plan_team(problem, "auto", PlanSettings(leaps=False))
    assert plan.reason == "infeasible"
    assert plan.detail.startswith("robot 0: no way over the ground")
    assert 0 in plan.involved


def test_joint_plans_walk(footprint_gap):
    problem = _problem("rough", PAIR)
    plan = plan_team(problem, "joint")
    assert plan.solved, plan.detail
    _ends(problem, plan)
    assert _gap(footprint_gap, problem, plan) > 0.0
    assert not any((t.phase == FLIGHT).any() for t in plan.trajectories)


def test_robots_on_wheels_stay_on_level_ground():
    problem = _problem("rough", [("unicycle", (2.0, 2.0, 0.0), (7.0, 2.0, 0.0))])
    with pytest.raises(InputError, match="robots with legs"):
        plan_team(problem)


def test_walkable_ground_is_solid_where_no_foot_may_stand():
    ground = _problem("gap", PAIR, width=0.4).ground
    model = robot_model("spirit")
    walking = walkable(ground, model)
    assert walking.solid[ground.traversability < 0.3].all()
    assert not walking.solid[:, 20:60].any()
    assert walking.solid[:, 90].all()
    assert (walking.clearance <= ground.clearance + 1e-9).all()
    level = ground._replace(flat=True)
    assert walkable(level, model) is level


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.5, 1.234])
def test_begun_later_is_the_same_after_standing(delay):
    plan = plan_team(_problem("gap", PAIR[:1], width=0.3))
    before = plan.trajectories[0]
    after = delayed(before, delay)
    assert after.duration == pytest.approx(before.duration + delay)
    assert np.diff(after.time).min() > 0.0
    assert np.diff(after.time).max() <= 0.03 + 1e-9
    time = np.linspace(0.0, before.duration, 50)
    assert after.poses_at(time + delay) == pytest.approx(before.poses_at(time))
    assert (after.poses_at(np.linspace(0.0, delay, 5)) == before.poses_at(np.zeros(5))).all()
    assert after.length == pytest.approx(before.length)
