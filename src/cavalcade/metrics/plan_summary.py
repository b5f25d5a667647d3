"""The figures of a plan: its `summary.json`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.locomotion import longest_leg
from cavalcade.metrics.clearance import clearance
from cavalcade.metrics.lower_bound import ShortestWays
from cavalcade.metrics.summary import rounded, versions
from cavalcade.recording.plan_sampling import as_recording
from cavalcade.scenario import Scenario, World


def summarise_plan(
    scenario: Scenario,
    world: World,
    plan: TeamPlan,
    stretches: Sequence[Array],
    wall_time: float,
) -> dict[str, Any]:
    """All keys of `summary.json`, null where they do not apply.

    Distances and collisions are those of the sampled plan until all robots are parked, and null
    without a plan. Beyond the contract's keys there are `detail` and `involved` as for runs,
    `found_by`, the method that `auto` ended with, `iterations` and `counts` of the search,
    `limit_s`, the limit of wall time it had, `margin_m`, by how much bodies were grown, and
    `footholds`: how many there are and how many lie beyond the reach of their leg.

    Args:
        scenario: As it was planned, with the method that was asked for.
        world: Its ground.
        plan: What came out.
        stretches: Per robot `(M,)`: how far its legs stretch to each foothold, m.
        wall_time: Of everything but figures and files, s.
    """
    robots = len(scenario.robots)
    solved = plan.solved
    known = [path for path in plan.trajectories if path is not None]
    near = None
    if solved and known:
        near = clearance(world, as_recording(known), scenario.models)
    collided = near is not None and near.robot_obstacle + near.robot_robot > 0
    durations = [None if path is None else path.duration for path in plan.trajectories]
    lengths = [None if path is None else path.length for path in plan.trajectories]
    unsure: list[float | None] = [None] * robots
    return {
        "name": scenario.name,
        "version": scenario.version,
        "seed": scenario.seed,
        "method": scenario.planner.method,
        "variant": scenario.planner.variant,
        "backend": None,
        "robots": robots,
        "success": solved and not collided,
        "reason": "collision" if collided else plan.reason,
        "detail": plan.detail or None,
        "involved": list(plan.involved),
        "sim_time_s": None,
        "wall_time_s": rounded(wall_time),
        "makespan_s": _round(max((d for d in durations if d is not None), default=None))
        if solved
        else None,
        "min_obstacle_distance_m": None if near is None else rounded(near.obstacle_distance),
        "min_robot_distance_m": None if near is None else rounded(near.robot_distance),
        "min_footprint_gap_m": None if near is None else rounded(near.footprint_gap),
        "collisions": {
            "robot_robot": None if near is None else near.robot_robot,
            "robot_obstacle": None if near is None else near.robot_obstacle,
        },
        "falls": None,
        "formation_error_m": {"mean": None, "p95": None, "max": None},
        "leader_changes": None,
        "role_changes": None,
        "cycle_ms": {"p50": None, "p99": None, "max": None},
        "planning_time_s": rounded(plan.planning_time),
        "path_length_m": [_round(length) for length in lengths] if solved else unsure,
        "lower_bound_m": lower_bounds(scenario, world),
        "duration_s": [_round(duration) for duration in durations] if solved else unsure,
        "goal_error_m": _goal_errors(scenario, plan) if solved else unsure,
        "goal_moved_m": 0.0,
        "found_by": plan.method,
        "iterations": plan.iterations,
        "limit_s": scenario.planner.budget.seconds,
        "counts": dict(plan.counts),
        "margin_m": list(plan.margins) or [0.0] * robots,
        "footholds": _footholds(scenario, stretches),
        "real_time_factor": None,
        "physics": None,
        "commanded": None,
        "versions": versions(),
    }


def lower_bounds(scenario: Scenario, world: World) -> list[float | None]:
    """Per robot the length of its shortest way from start to goal, alone, m."""
    ways: dict[float, ShortestWays] = {}
    found: list[float | None] = []
    for start, goal, model in zip(scenario.starts, scenario.goals, scenario.models, strict=True):
        if model.width not in ways:
            ways[model.width] = ShortestWays(world.map, model.width / 2.0)
        found.append(_round(ways[model.width].length(start[:2], goal[:2])))
    return found


def _goal_errors(scenario: Scenario, plan: TeamPlan) -> list[float | None]:
    errors: list[float | None] = []
    for goal, path in zip(scenario.goals, plan.trajectories, strict=True):
        off = None if path is None else float(np.hypot(*(path.position[-1, :2] - goal[:2])))
        errors.append(_round(off))
    return errors


def _footholds(scenario: Scenario, stretches: Sequence[Array]) -> dict[str, int]:
    beyond = 0
    for model, stretch in zip(scenario.models, stretches, strict=True):
        if model.legs is not None:
            beyond += int(np.count_nonzero(stretch > longest_leg(model.legs)))
    return {"count": sum(len(stretch) for stretch in stretches), "out_of_reach": beyond}


def _round(value: float | None) -> float | None:
    return None if value is None else rounded(value)
