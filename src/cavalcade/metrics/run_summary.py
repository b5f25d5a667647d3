"""The summary of a run, from its recording."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.execution.arrival import ArrivalTolerance, has_goal, slot_poses, tolerance_of
from cavalcade.execution.loop import Outcome
from cavalcade.geometry import Array, wrap_angle
from cavalcade.metrics.clearance import clearance
from cavalcade.metrics.leaps import leaps
from cavalcade.metrics.lower_bound import lower_bounds
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
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario, World
from cavalcade.scenario.rules import LIVE


def summarise(scenario: Scenario, world: World, recording: Recording, outcome: Outcome) -> Summary:
    """The summary of a run, whatever its task."""
    leapt = np.zeros((max(len(recording.time) - 1, 0), len(scenario.models)), dtype=bool)
    if scenario.execution.backend in LIVE:
        leapt = leaps(recording, scenario.models, scenario.execution.rate)
    near = clearance(world, recording, scenario.models, leapt)
    collisions = Collisions(near.robot_robot, near.robot_obstacle)
    track, physics, factor = recording.physics, None, None
    if track is not None:
        physics = summarise_physics(track, scenario.models)
        collisions = Collisions(
            max(near.robot_robot, physics.contacts.robot_robot),
            max(near.robot_obstacle, physics.contacts.robot_obstacle),
        )
        if len(recording.time) and outcome.wall_time > 0.0:
            factor = rounded(recording.time[-1] / outcome.wall_time)
    reason = outcome.reason
    if (collisions.robot_robot or collisions.robot_obstacle) and reason != "fallen":
        reason = "collision"
    arrived = outcome.reason == "arrived"
    steps = np.diff(recording.poses[..., :2], axis=0)
    steps[leapt] = 0.0
    driven = [status for status in recording.status if has_goal(status)]
    durations, goal_errors = _in_place(recording, driven, tolerance_of(scenario))
    return Summary(
        **job_keys(scenario),
        backend=scenario.execution.backend,
        success=reason in ("arrived", "done"),
        reason=reason,
        detail=outcome.detail or None,
        involved=outcome.involved,
        sim_time_s=rounded(recording.time[-1] if len(recording.time) else 0.0),
        wall_time_s=rounded(outcome.wall_time),
        makespan_s=max((d for d in durations if d is not None), default=None) if arrived else None,
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
        path_length_m=rounded_each(np.hypot(steps[..., 0], steps[..., 1]).sum(axis=0)),
        lower_bound_m=lower_bounds(world.map, scenario.models, _stops(scenario, driven)),
        duration_s=durations,
        goal_error_m=goal_errors,
        goal_moved_m=rounded(max((status.goal_moved for status in driven), default=None)),
        real_time_factor=factor,
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


def _in_place(
    recording: Recording, driven: Sequence[PlannerStatus], limit: ArrivalTolerance
) -> tuple[tuple[float | None, ...], tuple[float | None, ...]]:
    """Per robot when it was at its last slot for good, s, and how far off it is at the end, m.

    Null where it had no slot, and the time also where it was not there at the end.
    """
    robots = recording.poses.shape[1]
    ends = slot_poses(driven[-1]) if driven else None
    if ends is None or not len(recording.time):
        return (None,) * robots, (None,) * robots
    off = recording.poses - np.where(np.isfinite(ends), ends, np.nan)
    there = np.hypot(off[..., 0], off[..., 1]) <= limit.position
    there &= np.abs(wrap_angle(off[..., 2])) <= limit.heading
    durations: list[float | None] = []
    for robot in range(robots):
        away = np.flatnonzero(~there[:, robot])
        first = 0 if len(away) == 0 else int(away[-1]) + 1
        durations.append(rounded(recording.time[first]) if first < len(there) else None)
    return tuple(durations), rounded_each(np.hypot(off[-1, :, 0], off[-1, :, 1]))


def placement_errors(positions: Array, slots: Array, taking_part: NDArray[np.bool_]) -> Array:
    """Distance of each robot to its own slot of the best-fit placement of the shape.

    The placement is the rotation and translation (no scaling, no reflection) with the least sum
    of squared distances. Positions and slots (in the formation's frame) are `(T, N, 2)` m, and
    `(T, N)` says which robots have a slot; the others have an error of 0.
    """
    weight = taking_part[..., None].astype(float)
    count = np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    p = (positions - (positions * weight).sum(axis=1, keepdims=True) / count) * weight
    q = (slots - (slots * weight).sum(axis=1, keepdims=True) / count) * weight
    along = (p * q).sum(axis=(1, 2))
    across = (q[..., 0] * p[..., 1] - q[..., 1] * p[..., 0]).sum(axis=1)
    turn = np.arctan2(across, along)[:, None]
    c, s = np.cos(turn), np.sin(turn)
    dx = p[..., 0] - (c * q[..., 0] - s * q[..., 1])
    dy = p[..., 1] - (s * q[..., 0] + c * q[..., 1])
    return np.asarray(np.hypot(dx, dy))


def _formation_error(recording: Recording) -> FormationError:
    """For true poses and the roles of each cycle."""
    cycles, robots = recording.poses.shape[:2]
    slots = np.zeros((cycles, robots, 2))
    taking_part = np.zeros((cycles, robots), dtype=bool)
    for k, status in enumerate(recording.status):
        has_slot = (status.roles >= 0) & (status.roles < len(status.slots))
        taking_part[k] = has_slot
        slots[k, has_slot] = status.slots[status.roles[has_slot]]
    values = placement_errors(recording.poses[..., :2], slots, taking_part)[taking_part]
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


def _stops(scenario: Scenario, driven: Sequence[PlannerStatus]) -> list[list[Array]]:
    """Per robot its start and the ends `(2,)` of the legs that the team was to drive.

    A leg ends at the robot's own slot of each goal that was reached before the next one, and of
    the last goal.
    """
    reached = [a for a, b in pairwise(driven) if b.waypoint == a.waypoint + 1]
    ends = [slot_poses(status) for status in (*reached, *driven[-1:])]
    stops = [[np.asarray(start[:2])] for start in scenario.starts]
    for end in ends:
        for robot, visited in enumerate(stops):
            if end is not None and np.isfinite(end[robot]).all():
                visited.append(end[robot, :2])
    return stops
