"""A plan with its footholds and its summary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.coordination.result import TeamPlan
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory, team_poses
from cavalcade.locomotion import longest_leg
from cavalcade.metrics.clearance import clearance
from cavalcade.metrics.lower_bound import lower_bounds
from cavalcade.metrics.run_summary import job_keys
from cavalcade.metrics.summary import (
    Collisions,
    FootholdCount,
    Summary,
    package_versions,
    rounded,
    rounded_each,
)
from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario, World


@dataclass(frozen=True)
class PlanResult:
    """What planning came to.

    Attributes:
        plan: The coordinator's answer.
        footholds: Per robot `(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame); empty for
            robots without legs and where there is no trajectory.
        summary: Its metrics.
    """

    plan: TeamPlan
    footholds: tuple[Array, ...]
    summary: Summary

    @property
    def solved(self) -> bool:
        """Whether every robot has a trajectory and none meets anything."""
        return self.summary.success

    @property
    def reason(self) -> str:
        """`solved`, `infeasible` or `budget`, as in `summary.json`."""
        return self.summary.reason

    @property
    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """One per robot, map frame; see `TeamPlan.trajectories` for unsolved problems."""
        return self.plan.trajectories


def summarise_plan(
    scenario: Scenario,
    world: World,
    plan: TeamPlan,
    stretches: Sequence[Array],
    wall_time: float,
) -> Summary:
    """The summary of a plan.

    Distances and collisions are those of the sampled plan until all robots are parked, and null
    without a plan.

    `stretches`: per robot `(M,)` how far its legs stretch to each foothold, m. `wall_time`: of
    everything but figures and files, s.
    """
    robots = len(scenario.robots)
    solved = plan.solved
    known = [path for path in plan.trajectories if path is not None]
    near, collisions = None, Collisions()
    if solved and known:
        near = clearance(world, as_recording(known), scenario.models)
        collisions = Collisions(near.robot_robot, near.robot_obstacle)
    collided = bool(collisions.robot_obstacle or collisions.robot_robot)
    ends = [
        (start[:2], goal[:2]) for start, goal in zip(scenario.starts, scenario.goals, strict=True)
    ]
    durations = [None if path is None else path.duration for path in plan.trajectories]
    lengths = [None if path is None else path.length for path in plan.trajectories]
    errors = [
        None if path is None else float(np.hypot(*(path.position[-1, :2] - goal)))
        for (_, goal), path in zip(ends, plan.trajectories, strict=True)
    ]
    unsure = (None,) * robots
    makespan = max((d for d in durations if d is not None), default=None) if solved else None
    return Summary(
        **job_keys(scenario),
        success=solved and not collided,
        reason="collision" if collided else plan.reason,
        detail=plan.detail or None,
        involved=tuple(plan.involved),
        wall_time_s=rounded(wall_time),
        makespan_s=rounded(makespan),
        min_obstacle_distance_m=None if near is None else rounded(near.obstacle_distance),
        min_robot_distance_m=None if near is None else rounded(near.robot_distance),
        min_footprint_gap_m=None if near is None else rounded(near.footprint_gap),
        collisions=collisions,
        planning_time_s=rounded(plan.planning_time),
        path_length_m=rounded_each(lengths) if solved else unsure,
        lower_bound_m=lower_bounds(world.map, scenario.models, ends),
        duration_s=rounded_each(durations) if solved else unsure,
        goal_error_m=rounded_each(errors) if solved else unsure,
        goal_moved_m=0.0,
        found_by=plan.method,
        iterations=plan.iterations,
        limit_s=scenario.planner.budget.seconds,
        counts=dict(plan.counts),
        margin_m=tuple(plan.margins) or (0.0,) * robots,
        footholds=_footholds(scenario, stretches),
        versions=package_versions(),
    )


def as_recording(trajectories: Sequence[Trajectory]) -> Recording:
    """The plan as if it had been carried out to the letter; without commands and status.

    Its times are those of all samples of all robots, so that nothing is left out in between.
    """
    times = np.unique(np.concatenate([trajectory.time for trajectory in trajectories]))
    poses = team_poses(trajectories, times)
    return Recording(times, poses, poses, np.zeros_like(poses), (), (), ())


def _footholds(scenario: Scenario, stretches: Sequence[Array]) -> FootholdCount:
    beyond = 0
    for model, stretch in zip(scenario.models, stretches, strict=True):
        if model.legs is not None:
            beyond += int(np.count_nonzero(stretch > longest_leg(model.legs)))
    return FootholdCount(sum(len(stretch) for stretch in stretches), beyond)
