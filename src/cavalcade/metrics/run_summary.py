"""The summary of a run, from its recording."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cavalcade.execution.arrival import ArrivalTolerance, has_goal, slot_poses, tolerance_of
from cavalcade.execution.loop import Outcome
from cavalcade.geometry import Array, wrap_angle
from cavalcade.metrics.clearance import clearance
from cavalcade.metrics.formation_error import formation_errors
from cavalcade.metrics.lower_bound import ShortestWays
from cavalcade.metrics.physics_summary import summarise_physics
from cavalcade.metrics.summary import (
    Collisions,
    CycleTimes,
    FormationError,
    Summary,
    package_versions,
    rounded,
    rounded_each,
)
from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario, World


def summarise(scenario: Scenario, world: World, recording: Recording, outcome: Outcome) -> Summary:
    """The summary of a run, whatever its task."""
    near = clearance(world, recording, scenario.models)
    collisions = Collisions(near.robot_robot, near.robot_obstacle)
    track, physics = recording.physics, None
    if track is not None:
        physics = summarise_physics(track, scenario.models)
        collisions = Collisions(
            max(near.robot_robot, physics.contacts.robot_robot),
            max(near.robot_obstacle, physics.contacts.robot_obstacle),
        )
    reason = outcome.reason
    if (collisions.robot_robot or collisions.robot_obstacle) and reason != "fallen":
        reason = "collision"
    arrived = outcome.reason == "arrived"
    ends = _ends(recording)
    durations = _durations(recording, ends, tolerance_of(scenario))
    return Summary(
        **job_keys(scenario),
        backend=scenario.execution.backend,
        success=reason in ("arrived", "done"),
        reason=reason,
        detail=outcome.detail or None,
        involved=outcome.involved,
        sim_time_s=rounded(recording.time[-1] if len(recording.time) else 0.0),
        wall_time_s=rounded(outcome.wall_time),
        makespan_s=_makespan(durations) if arrived else None,
        min_obstacle_distance_m=rounded(near.obstacle_distance),
        min_robot_distance_m=rounded(near.robot_distance),
        min_footprint_gap_m=rounded(near.footprint_gap),
        collisions=collisions,
        falls=0 if track is None else len(track.falls),
        formation_error_m=_formation_error(recording),
        leader_changes=leader_changes(recording),
        role_changes=role_changes(recording),
        cycle_ms=_cycle_times(outcome.planning * 1e3),
        planning_time_s=rounded(outcome.planning.sum()),
        path_length_m=rounded_each(_path_lengths(recording)),
        lower_bound_m=_lower_bounds(scenario, world, recording),
        duration_s=durations,
        goal_error_m=_goal_errors(recording, ends),
        goal_moved_m=_goal_moved(recording),
        real_time_factor=_real_time_factor(recording, outcome),
        physics=physics,
        versions=package_versions(() if track is None else ("mujoco",)),
    )


def job_keys(scenario: Scenario) -> dict[str, Any]:
    """What summaries say of the scenario."""
    return {
        "name": scenario.name,
        "version": scenario.version,
        "seed": scenario.seed,
        "method": scenario.planner.method,
        "variant": scenario.planner.variant,
        "robots": len(scenario.robots),
    }


def leader_changes(recording: Recording) -> int:
    """How often another robot took the lead."""
    leaders = [status.leader for status in recording.status if status.leader >= 0]
    return sum(a != b for a, b in pairwise(leaders))


def role_changes(recording: Recording) -> int:
    """How often a robot changed from one slot to another of the same shape, over all robots."""
    count = 0
    for before, after in pairwise(recording.status):
        if before.roles is after.roles or not np.array_equal(before.slots, after.slots):
            continue
        changed = (before.roles != after.roles) & (before.roles >= 0) & (after.roles >= 0)
        count += int(np.count_nonzero(changed))
    return count


def _real_time_factor(recording: Recording, outcome: Outcome) -> float | None:
    """Simulated by wall time of a run in physics."""
    if recording.physics is None or not len(recording.time) or outcome.wall_time <= 0.0:
        return None
    return rounded(recording.time[-1] / outcome.wall_time)


def _ends(recording: Recording) -> Array | None:
    """Poses `(N, 3)` of the slots that were driven to last; infinite for a robot without one."""
    for status in reversed(recording.status):
        if has_goal(status):
            return slot_poses(status)
    return None


def _durations(
    recording: Recording, ends: Array | None, limit: ArrivalTolerance
) -> tuple[float | None, ...]:
    """When each robot was at its last slot for good, s; null if it was not at the end."""
    robots = recording.poses.shape[1]
    if ends is None or not len(recording.time):
        return (None,) * robots
    result: list[float | None] = []
    for robot in range(robots):
        if not np.isfinite(ends[robot]).all():
            result.append(None)
            continue
        off = recording.poses[:, robot] - ends[robot]
        there = np.hypot(off[:, 0], off[:, 1]) <= limit.position
        there &= np.abs(wrap_angle(off[:, 2])) <= limit.heading
        away = np.flatnonzero(~there)
        first = 0 if len(away) == 0 else int(away[-1]) + 1
        result.append(rounded(recording.time[first]) if first < len(there) else None)
    return tuple(result)


def _makespan(durations: Sequence[float | None]) -> float | None:
    known = [duration for duration in durations if duration is not None]
    return max(known, default=None)


def _goal_errors(recording: Recording, ends: Array | None) -> tuple[float | None, ...]:
    robots = recording.poses.shape[1]
    if ends is None or not len(recording.time):
        return (None,) * robots
    off = recording.poses[-1, :, :2] - ends[:, :2]
    return rounded_each(np.hypot(off[:, 0], off[:, 1]))


def _goal_moved(recording: Recording) -> float | None:
    moved = [status.goal_moved for status in recording.status if has_goal(status)]
    return rounded(max(moved)) if moved else None


def _formation_error(recording: Recording) -> FormationError:
    errors, taking_part = formation_errors(recording)
    values = errors[taking_part]
    if not len(values):
        return FormationError()
    return FormationError(
        rounded(values.mean()), rounded(np.percentile(values, 95)), rounded(values.max())
    )


def _cycle_times(cycles: Array) -> CycleTimes:
    if not len(cycles):
        return CycleTimes()
    return CycleTimes(
        rounded(np.percentile(cycles, 50)),
        rounded(np.percentile(cycles, 99)),
        rounded(cycles.max()),
    )


def _path_lengths(recording: Recording) -> Array:
    steps = np.diff(recording.poses[..., :2], axis=0)
    return np.asarray(np.hypot(steps[..., 0], steps[..., 1]).sum(axis=0))


def _lower_bounds(
    scenario: Scenario, world: World, recording: Recording
) -> tuple[float | None, ...]:
    """Per robot over the legs that the team was to drive, on the ground as it was at the start.

    A leg ends at the robot's own slot of each goal that was reached before the next one, and of
    the last goal.
    """
    ends = _leg_ends(recording)
    ways: dict[float, ShortestWays] = {}
    result: list[float | None] = []
    for robot, model in enumerate(scenario.models):
        stops = [np.asarray(scenario.starts[robot][:2])]
        stops += [end[robot, :2] for end in ends if np.isfinite(end[robot]).all()]
        if len(stops) < 2:
            result.append(None)
            continue
        if model.width not in ways:
            ways[model.width] = ShortestWays(world.map, model.width / 2.0)
        legs = [ways[model.width].length(a, b) for a, b in pairwise(stops)]
        known = [leg for leg in legs if leg is not None]
        result.append(rounded(sum(known)) if len(known) == len(legs) else None)
    return tuple(result)


def _leg_ends(recording: Recording) -> list[Array]:
    """Slot poses `(N, 3)` at every goal that was reached before the next, and at the last."""
    driven = [status for status in recording.status if has_goal(status)]
    ends = []
    for before, after in pairwise(driven):
        if after.waypoint == before.waypoint + 1:
            ends.append(slot_poses(before))
    if driven:
        ends.append(slot_poses(driven[-1]))
    return [end for end in ends if end is not None]
