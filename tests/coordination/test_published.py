"""The paper's plain options: they run, and keep what they promise, which is less."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.coordination import PlanSettings, TeamPlan, plan_team
from cavalcade.coordination.published import DISTANCE

PAIR = [
    ("spirit", (2.0, 5.0, 0.0), (8.0, 5.5, 0.0)),
    ("spirit", (8.0, 4.6, math.pi), (2.0, 4.5, math.pi)),
]
PUBLISHED = PlanSettings(
    variant="published", constraints="static", conflict="first", iterations=300_000
)


def _apart(plan: TeamPlan) -> float:
    """Least distance of the centres of two robots, until both have parked, m."""
    end = max(t.duration for t in plan.trajectories) + 1.0
    time = np.arange(0.0, end, 0.01)
    one, other = (t.poses_at(time) for t in plan.trajectories)
    return float(np.hypot(*(one - other).T[:2]).min())


@pytest.mark.parametrize("method", ["sequential", "cbs", "auto"])
@pytest.mark.parametrize("seed", range(3))
def test_published_plans_keep_their_distance_of_centres(make_team, method, seed):
    problem = make_team(PAIR, (10.0, 10.0))
    plan = plan_team(problem, method, PUBLISHED, seed)
    assert plan.solved, plan.detail
    assert _apart(plan) >= DISTANCE - 0.01
    for t, start, goal in zip(plan.trajectories, problem.starts, problem.goals, strict=True):
        assert t.position[0, :2] == pytest.approx(start[:2], abs=1e-6)
        assert t.position[-1, :2] == pytest.approx(goal[:2], abs=1e-6)


def test_published_auto_keeps_the_distance_where_trees_come_near(make_team):
    robots = [
        ("spirit", (1.8, 4.1, 0.9), (3.1, 2.7, -2.8)),
        ("spirit", (4.0, 1.1, -0.9), (1.6, 5.0, -2.0)),
    ]
    problem = make_team(robots, (6.0, 6.0))
    for seed in range(3):
        plan = plan_team(problem, "auto", PUBLISHED, seed)
        assert not plan.solved or _apart(plan) >= DISTANCE - 0.01


def test_published_joint_plans_keep_bodies_apart(make_team, judged):
    problem = make_team(PAIR, (10.0, 10.0))
    judged(problem, plan_team(problem, "joint", PUBLISHED))


@pytest.mark.parametrize("constraints", ["timed", "static"])
@pytest.mark.parametrize("conflict", ["costly", "earliest", "first"])
def test_every_rule_solves_what_is_simple(make_team, judged, constraints, conflict):
    problem = make_team(PAIR, (10.0, 10.0))
    settings = PlanSettings(constraints=constraints, conflict=conflict)
    judged(problem, plan_team(problem, "cbs", settings))
    judged(problem, plan_team(problem, "sequential", settings))
