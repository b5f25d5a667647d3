"""Verdicts on trials by the independent checker, and figures; nothing is written or read back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cavalcade.campaign.avoidable import audit, contacts_of, lost_since
from cavalcade.campaign.samplers import EXPECTED, SOLVED
from cavalcade.checking import judge_plan
from cavalcade.checking.check import judge, judge_physics
from cavalcade.checking.heights import read_heights
from cavalcade.checking.physics.leaps import leap_reason
from cavalcade.checking.physics.record import RobotRecord, Touch, records_from
from cavalcade.checking.report import Report
from cavalcade.checking.tracks import Track
from cavalcade.execution.arrival import tolerance_of
from cavalcade.geometry import Array
from cavalcade.jobs import JobResult
from cavalcade.recording.frames import Recording
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.recording.plan_file import plan_arrays
from cavalcade.scenario import Scenario, World

MOST_VIOLATIONS = 5
"""So many of the checker's lines are kept."""

_BREAKS = ("gap", "step")
"""Terrain with one break, across the whole width."""

_BEFORE = 0.9
"""A leap is judged from when the robot was last so far before the far edge, m."""

_ALONE = "cbs"
"""Of a single robot: the course that all methods but the joint one begin with."""


@dataclass(frozen=True)
class Verdict:
    """What the checker and the audit say of a run or a plan.

    Attributes:
        outcome: Its own reason, `collision` or `invalid`.
        detail: One line.
        success: As it should be, without an avoidable collision or another violation.
        contacts: How many collisions there were.
        avoidable: How many of them could have been avoided.
        violations: The checker's lines, the first few.
    """

    outcome: str
    detail: str
    success: bool
    contacts: int
    avoidable: int
    violations: tuple[str, ...]


def verdict_of(
    report: Report, reason: str, detail: str, *, success: bool, avoidable: int
) -> Verdict:
    """The verdict on what ended for a `reason` of its own, unless the checker knows better."""
    contacts = contacts_of(report)
    if reason == "fallen" or not report.violations:  # whatever was touched in a fall
        outcome = reason
    else:
        outcome = "collision" if contacts else "invalid"
    first = report.violations[:MOST_VIOLATIONS]
    lines = tuple(f"{v.time:.2f} s {v.kind}: {v.message}" for v in first)
    return Verdict(outcome, detail, success, len(contacts), avoidable, lines)


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
    return records_from(time, motion, touches)


def _as_stamped(time: Array) -> Array:
    """Seconds as they come out of the stamps of messages."""
    from cavalcade.recording.cdr import nanoseconds, stamps_of

    seconds, rest = stamps_of(nanoseconds(time)).T
    return np.asarray(seconds + 1e-9 * rest)


def judged(
    scenario: Scenario, world: World, recording: Recording, summary: Mapping[str, Any]
) -> Verdict:
    """The verdict on a run of a resolved scenario; `summary` is what it says of itself."""
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
    events = scenario.execution.events
    errors = [
        error
        for robot, error in enumerate(summary["goal_error_m"])
        if lost_since(events, robot, math.inf) is None
    ]
    within = tolerance_of(scenario).position
    return all(error is not None and error <= within for error in errors)


def judged_plan(result: JobResult, expected: str = SOLVED) -> Verdict:
    """The verdict on a plan; where none is expected, see `Instance`, refusing is the success."""
    # Also of a plan whose own summary finds contact, all that the coordinator claims is judged.
    claimed = {**result.summary, "success": result.plan is not None and result.plan.solved}
    arrays = plan_arrays(result.trajectories, result.footholds)
    report = judge_plan(result.scenario, arrays, claimed)
    solved = result.solved and not report.violations
    detail, avoidable = result.summary.detail or "", len(contacts_of(report))
    found = verdict_of(report, result.reason, detail, success=solved, avoidable=avoidable)
    if expected == SOLVED:
        return found
    return replace(found, success=found.outcome in EXPECTED[expected])


def measured_plan(result: JobResult) -> dict[str, float | None]:
    """Figures beside those of the summary; null where there is no plan, or only one robot.

    `length_ratio`: the summed lengths over the summed lower bounds; `makespan_ratio`: the
    makespan over that of the slowest robot planned alone with the same options;
    `single_time_ratio`: the planning time over that of all these single plans.
    """
    summary = result.summary
    names = ("time_ratio", "length_ratio", "makespan_ratio", "single_time_ratio")
    found: dict[str, float | None] = dict.fromkeys(names)
    if not result.solved:
        return found
    lengths, bounds = summary["path_length_m"], summary["lower_bound_m"]
    if None not in bounds and sum(bounds) > 0.0:
        found["length_ratio"] = round(sum(lengths) / sum(bounds), 6)
    if len(result.scenario.robots) < 2:
        return found
    durations, seconds = _alone(result.scenario, result.world)
    slowest = max((time for time in durations if time is not None), default=0.0)
    if None not in durations and slowest > 0.0:
        found["makespan_ratio"] = round(summary["makespan_s"] / slowest, 6)
    if seconds > 0.0:
        found["single_time_ratio"] = round(summary["planning_time_s"] / seconds, 6)
    return found


def _alone(scenario: Scenario, world: World) -> tuple[list[float | None], float]:
    """Durations of the robots' plans if each were alone, s, and the time to plan them all, s."""
    # These load kernels, which trials without plans need not.
    from cavalcade.coordination import TeamProblem, plan_team, problem_of
    from cavalcade.jobs.planning import settings_of

    problem, settings = problem_of(scenario, world), settings_of(scenario)
    durations: list[float | None] = []
    seconds = 0.0
    for k in range(len(problem.models)):
        single: TeamProblem = replace(
            problem,
            models=problem.models[k : k + 1],
            starts=problem.starts[k : k + 1],
            goals=problem.goals[k : k + 1],
        )
        found = plan_team(single, _ALONE, settings, scenario.seed)
        seconds += found.planning_time
        path = found.trajectories[0]
        durations.append(path.duration if found.solved and path is not None else None)
    return durations, seconds
