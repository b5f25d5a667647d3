"""A plan as it was driven, for figures and the replay: trajectories and footholds of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK, Trajectory
from cavalcade.metrics.plan_summary import PlanResult
from cavalcade.recording.frames import Recording
from cavalcade.recording.physics_track import LOADED, PhysicsTrack, yaw_of
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.scenario import Scenario

PUSHING = 0.1
"""With all feet on the ground before or after a flight, a trunk faster than this leaps, m/s."""


def driven_plan(
    made: PlanResult, recording: Recording, follower: PlanFollower, scenario: Scenario
) -> PlanResult:
    """The plan with the motion that came of it.

    A robot's trajectory ends with the cycle in which its plan ends, or with the run. In physics
    heights, flights and footholds are those that were measured. Ideal robots have those of the
    plan at the moments of their progress in it.
    """
    delays = follower.delays_at(recording.time)
    trajectories: list[Trajectory | None] = list(made.trajectories)
    footholds = list(made.footholds)
    for robot, path in enumerate(made.trajectories):
        if path is None:
            continue
        progress = recording.time - delays[:, robot]
        cycles = 1 + int(np.searchsorted(progress, path.duration - 1e-9))
        time, progress = recording.time[:cycles], progress[:cycles]
        legs = scenario.models[robot].description
        if recording.physics is not None and legs is not None:
            track, end = recording.physics, float(time[-1])
            trajectories[robot] = measured_trajectory(track, robot, end)
            footholds[robot] = measured_footholds(track, robot, legs)
            continue
        trajectories[robot] = _followed(path, time, progress, recording.poses[:cycles, robot])
        footholds[robot] = footholds[robot].copy()
        footholds[robot][:, :2] = np.interp(footholds[robot][:, :2], progress, time)
    plan = replace(made.plan, trajectories=tuple(trajectories))
    return replace(made, plan=plan, footholds=tuple(footholds))


def _followed(path: Trajectory, time: Array, progress: Array, poses: Array) -> Trajectory:
    """The poses `(K, 3)` that were driven, at the heights and phases of the plan."""
    height = np.interp(progress, path.time, path.position[:, 2])
    before = np.clip(np.searchsorted(path.time, progress + 1e-9) - 1, 0, len(path.time) - 1)
    position = np.column_stack([poses[:, :2], height])
    return _trajectory(time, position, np.unwrap(poses[:, 2]), path.phase[before])


def measured_trajectory(track: PhysicsTrack, robot: int, end: float) -> Trajectory:
    """The trunk's motion until `end`, with the phases of its leaps."""
    count = max(1, int(np.searchsorted(track.time, end + 1e-9)))
    time, base = track.time[:count], track.base[:count, robot]
    yaw = np.unwrap(yaw_of(base[:, 3:]))
    return _trajectory(time, base[:, :3], yaw, _phases(track, robot)[:count])


def _phases(track: PhysicsTrack, robot: int) -> NDArray[np.int8]:
    """`(T,)` what the robot does from each sample to the next."""
    flies = track.flying[1:, robot]
    steps = np.linalg.norm(np.diff(track.base[:, robot, :3], axis=0), axis=1)
    pushes = steps > PUSHING * np.diff(track.time)
    pushes &= (track.foot_forces[1:, robot, :, 2] >= LOADED).all(axis=1)
    phase = np.full(len(track.time), WALK, dtype=np.int8)
    phase[:-1][flies] = FLIGHT
    for sample in np.flatnonzero(np.diff(flies.astype(np.int8), prepend=0) > 0):
        k = int(sample) - 1
        while k >= 0 and pushes[k]:
            phase[k], k = TAKE_OFF, k - 1
    for sample in np.flatnonzero(np.diff(flies.astype(np.int8), append=0) < 0):
        k = int(sample) + 1
        while k < len(flies) and pushes[k]:
            phase[k], k = LANDING, k + 1
    return phase


def measured_footholds(track: PhysicsTrack, robot: int, description: QuadrupedDescription) -> Array:
    """`(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame) of every stance of a foot."""
    base, found = track.base[:, robot], []
    places = description.foot_places(track.joints[:, robot])
    carries = track.foot_forces[:, robot, :, 2] >= LOADED
    for leg in range(4):
        edges = np.flatnonzero(np.diff(carries[:, leg].astype(np.int8), prepend=0, append=0))
        for first, last in edges.reshape(-1, 2).tolist():
            middle = (first + last - 1) // 2
            w, axis, arm = base[middle, 3], base[middle, 4:], places[middle, leg]
            turned = 2.0 * np.cross(axis, arm)
            place = base[middle, :3] + arm + w * turned + np.cross(axis, turned)
            ground = place - (0.0, 0.0, description.foot_radius)
            # A sample tells of the time since the one before.
            found.append([track.time[max(first - 1, 0)], track.time[last - 1], leg, *ground])
    return np.array(sorted(found), dtype=float).reshape(-1, 6)


def _trajectory(time: Array, position: Array, yaw: Array, phase: NDArray[np.int8]) -> Trajectory:
    velocity = np.gradient(position, time, axis=0) if len(time) > 1 else np.zeros((1, 3))
    return Trajectory(time, position, velocity, yaw, phase)
