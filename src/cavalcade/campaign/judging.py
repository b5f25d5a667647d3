"""The verdict on one trial's run, by the independent checker; nothing is written or read back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from cavalcade.campaign.avoidable import audit, lost_since
from cavalcade.campaign.verdict import Verdict, contacts_of, verdict_of
from cavalcade.checking.check import judge, judge_physics
from cavalcade.checking.heights import read_heights
from cavalcade.checking.physics.leaps import leap_reason
from cavalcade.checking.physics.record import RobotRecord, Touch, records_from
from cavalcade.checking.tracks import Track
from cavalcade.execution.arrival import tolerance_of
from cavalcade.geometry import Array
from cavalcade.recording.frames import Recording
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.scenario import Scenario, World

_BREAKS = ("gap", "step")
"""Terrain with one break, across the whole width."""

_BEFORE = 0.9
"""A leap is judged from when the robot was last so far before the far edge, m."""


def tracks_of(recording: Recording) -> tuple[Track, ...]:
    """Each robot's true motion, to the bit as it would be read from the recording's file.

    There, times are whole nanoseconds and headings quaternions.
    """
    from cavalcade.recording.cdr import planar_poses

    time = _as_stamped(recording.time)
    poses = planar_poses(recording.poses)
    yaw = np.unwrap(2.0 * np.arctan2(poses[..., 5], poses[..., 6]), axis=0)
    return tuple(
        Track(time, np.column_stack((poses[:, robot, :2], yaw[:, robot])))
        for robot in range(recording.poses.shape[1])
    )


def records_of(track: PhysicsTrack) -> tuple[RobotRecord, ...]:
    """Each robot's bodies, joints and contacts, to the bit as from the recording's file."""
    time = _as_stamped(track.time)
    touches = [
        [
            Touch(contact.time, contact.part, contact.other)
            for contact in track.contacts
            if contact.robot == robot
        ]
        for robot in range(track.size)
    ]
    motion = (track.base, track.joints, track.joint_rates, track.torques, track.foot_forces)
    return records_from(time, *motion, touches)


def _as_stamped(time: Array) -> Array:
    """Seconds as they come out of the stamps of messages."""
    from cavalcade.recording.cdr import nanoseconds, stamps_of

    seconds, rest = stamps_of(nanoseconds(time)).T
    return np.asarray(seconds + 1e-9 * rest)


def judged(
    scenario: Scenario, world: World, recording: Recording, summary: Mapping[str, Any]
) -> Verdict:
    """The verdict on a run.

    Args:
        scenario: The resolved one that was run.
        world: Its world.
        recording: What happened.
        summary: What the run says of itself.
    """
    tracks = tracks_of(recording)
    if recording.physics is None:
        report = judge(scenario, tracks, dict(summary))
    else:
        report = judge_physics(scenario, tracks, records_of(recording.physics), dict(summary))
    contacts = contacts_of(report)
    avoidable, why = 0, ""
    if contacts and not scenario.execution.events:  # all could have been avoided
        avoidable, why = len(contacts), contacts[0].message
    elif contacts:
        found = audit(scenario, world, recording, report)
        avoidable = sum(one.avoidable for one in found)
        why = "; ".join(dict.fromkeys(one.why for one in found))
    arrived = bool(summary["success"]) or (bool(contacts) and _ended_there(scenario, summary))
    clean = not avoidable and len(contacts) == len(report.violations)
    detail = str(summary["detail"] or why)
    return verdict_of(
        report, str(summary["reason"]), detail, success=arrived and clean, avoidable=avoidable
    )


def time_ratio(scenario: Scenario, summary: Mapping[str, Any]) -> float | None:
    """Makespan over the longest lower bound at top speed; None where there is neither."""
    models = scenario.models
    least = [
        bound / model.max_speed_x
        for bound, model in zip(summary["lower_bound_m"], models, strict=True)
        if bound is not None
    ]
    makespan = summary["makespan_s"]
    if makespan is None or not least or max(least) <= 0.0:
        return None
    return round(float(makespan) / max(least), 6)


def crossings(scenario: Scenario, recording: Recording) -> dict[str, int]:
    """How many robots came across, and how many of them as a leap has to be.

    `crossings` and `strict_crossings`: of the break in the middle of the ground; nothing on other
    ground and without physics.
    """
    source = scenario.world.generate
    if recording.physics is None or source is None or source.kind not in _BREAKS:
        return {}
    heights = read_heights(scenario)
    if heights is None:
        return {}
    middle = source.size[0] / 2.0 if source.at is None else source.at
    half = (source.width or 0.0) / 2.0
    found = {"crossings": 0, "strict_crossings": 0}
    for record, model in zip(records_of(recording.physics), scenario.models, strict=True):
        first, last = record.base[0, 0], record.base[-1, 0]
        sign = 1.0 if first < middle else -1.0
        if model.description is None or sign * (last - middle) < half:
            continue
        found["crossings"] += 1
        past = sign * (record.base[:, 0] - middle) - half
        before = np.flatnonzero(past < -_BEFORE)
        begin = float(record.time[before[-1]]) if len(before) else float(record.time[0])
        y = float(np.interp(begin, record.time, record.base[:, 1]))
        end = np.array([middle + sign * (half + 0.6), y])
        reason = leap_reason(record, model.description, heights, end, begin)
        found["strict_crossings"] += not reason
    return found


def _ended_there(scenario: Scenario, summary: Mapping[str, Any]) -> bool:
    """Whether the team was at its goal in the end; with a collision the run does not say so.

    A collision takes the place of `arrived` as the reason, but the team drives on.
    """
    if summary["reason"] not in ("collision", "arrived"):
        return False
    if summary["sim_time_s"] >= scenario.execution.timeout:
        return False
    lost = lost_at_the_end(scenario)
    errors = [e for k, e in enumerate(summary["goal_error_m"]) if k not in lost]
    within = tolerance_of(scenario).position
    return all(error is not None and error <= within for error in errors)


def lost_at_the_end(scenario: Scenario) -> frozenset[int]:
    """The robots that were lost and did not come back."""
    events, robots = scenario.execution.events, range(len(scenario.robots))
    return frozenset(k for k in robots if lost_since(events, k, math.inf) is not None)
