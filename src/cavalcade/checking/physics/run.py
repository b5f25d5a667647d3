"""The verdict on a run in physics: what its recording shows, and what the run says of itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from cavalcade.checking.contact import FARTHEST, bodies, common_clock, find_contacts
from cavalcade.checking.ground import Floor
from cavalcade.checking.heights import Heights, floor_of
from cavalcade.checking.physics.contacts import touched
from cavalcade.checking.physics.feet import slides
from cavalcade.checking.physics.judge import Conditions, Push, judge_robots
from cavalcade.checking.physics.kinematics import posture
from cavalcade.checking.physics.momentum import carried_part
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import roll_pitch_yaw
from cavalcade.checking.report import PhysicsFigures, Violation, broken, excesses
from cavalcade.checking.solids import Scene
from cavalcade.checking.tracks import Track
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.scenario import Scenario

SPARSE = 0.05
"""Most seconds between samples of bodies: what is finer is the recording's grain."""

SAME = (1e-3, 1e-3)
"""The planar pose is the body's within m and rad at a common stamp."""

SWAY = (20.0, 100.0)
"""Accelerations in m/s² and rad/s² between stamps of the planar pose, if bodies have others."""

DISTANCE = 0.01
"""Smallest distances may be claimed this much too large, m: between samples robots sway."""


def judge_motion(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    records: tuple[RobotRecord, ...],
    summary: Mapping[str, Any],
    scene: Scene,
    heights: Heights | None,
) -> tuple[list[Violation], float, PhysicsFigures]:
    """Violations of bodies, joints, contacts and claims; smallest gap of footprints, m; figures.

    Footprints may touch here: of robots with legs and walls, their solid parts count.

    Raises:
        RecordingError: A robot has no description.
    """
    places = np.concatenate([record.base[:, :2] for record in records])
    floor = floor_of(heights, places)
    descriptions = _descriptions(scenario)
    said = scenario.execution.physics
    conditions = Conditions(
        said.friction * (1.0 + said.variation), said.variation, _pushes(scenario)
    )
    result = judge_robots(records, descriptions, floor, scene, conditions)
    result += _sparse(records)
    for record, track in zip(records, tracks, strict=True):
        result += _check_poses(record, track)
        result += _short(record, track)
    ticks = common_clock(tracks, scene.solids)
    end, everyone = float(ticks[-1]), tuple(range(len(records)))
    kinds = [violation.kind for violation in result]
    counts = {
        "falls": kinds.count("fall"),
        "robot_robot": kinds.count("robot-robot"),
        "robot_obstacle": kinds.count("robot-obstacle"),
    }
    result += _check_counts(summary, counts, end, everyone)
    _, gap = find_contacts(scene, bodies(tracks, scenario.models, ticks), ticks)
    distances = {
        "min_robot_distance_m": _pair_distance(tracks, ticks),
        "min_obstacle_distance_m": _obstacle_distance(scene, tracks, scenario.models, ticks),
        "min_footprint_gap_m": gap if gap < 1.0 else np.inf,
    }
    result += _check_distances(summary, distances, end, everyone)
    return result, gap, _measured(records, descriptions, floor)


def _pushes(scenario: Scenario) -> tuple[Push, ...]:
    """Those of the scenario's events; they begin with the cycle that follows."""
    period, result = 1.0 / scenario.execution.rate, []
    for event in scenario.execution.events:
        if event.push is not None:
            said = event.push
            begin = math.ceil(event.at / period - 1e-6) * period
            x, y = (part / said.duration for part in said.impulse)
            result.append(Push(said.robot, begin, begin + said.duration, (x, y, 0.0)))
    return tuple(result)


def _descriptions(scenario: Scenario) -> list[QuadrupedDescription]:
    result = []
    for number, (model, robot) in enumerate(zip(scenario.models, scenario.robots, strict=True)):
        if robot.mjcf is not None:
            raise RecordingError(
                "a robot out of a file of one's own cannot be judged: its masses are unknown",
                key=f"robots[{number}].mjcf",
            )
        if model.description is None:
            raise RecordingError(
                f"there is no description of {model.name} to judge physics by",
                key=f"robots[{number}].model",
            )
        result.append(model.description)
    return result


def _sparse(records: tuple[RobotRecord, ...]) -> list[Violation]:
    time, gaps, everyone = records[0].time, records[0].steps, tuple(range(len(records)))
    long = gaps > SPARSE + 1e-6
    if not long.any():
        return []
    k = int(long.argmax())
    text, gap = f"bodies have no samples for {gaps[k]:.3f} s", float(gaps[k])
    return [Violation("samples", float(time[k]), everyone, text, gap, SPARSE)]


def _short(record: RobotRecord, track: Track) -> list[Violation]:
    """Bodies are recorded for as long as poses are."""
    missing = max(float(record.time[0] - track.time[0]), float(track.time[-1] - record.time[-1]))
    if missing <= SPARSE + 1e-6:
        return []
    text = f"robot {record.robot} has poses for {missing:.2f} s without its body"
    return [broken("samples", record.time[-1], record.robot, text, missing, SPARSE)]


def _check_poses(record: RobotRecord, track: Track) -> list[Violation]:
    """The planar pose is the trunk's place and heading."""
    expected = track.at(record.time)
    # Between stamps a straight line is off by half the acceleration times what is left and right.
    after = np.searchsorted(track.time, record.time).clip(1, len(track.time) - 1)
    left = np.maximum(record.time - track.time[after - 1], 0.0)
    right = np.maximum(track.time[after] - record.time, 0.0)
    between = np.where(np.minimum(left, right) > 1e-6, 0.5 * left * right, 0.0)
    away = np.hypot(*(record.base[:, :2] - expected[:, :2]).T)
    turned = np.abs(wrap_angle(roll_pitch_yaw(record.turn)[:, 2] - expected[:, 2]))
    robot, time = record.robot, record.time
    words = "has its pose {value:.3f} m from its body"
    slack = SAME[0] + SWAY[0] * between
    result = excesses("pose", robot, time, away, 0.0, words, slack)
    # Of a trunk that stands upright, heading is not defined.
    turned = np.where(np.abs(record.turn[:, 2, 0]) < 0.95, turned, 0.0)
    words = "has its pose turned by {value:.3f} rad from its body"
    slack = SAME[1] + SWAY[1] * between
    return result + excesses("pose", robot, time, turned, 0.0, words, slack)


def _check_counts(
    summary: Mapping[str, Any], found: Mapping[str, int], end: float, everyone: tuple[int, ...]
) -> list[Violation]:
    """Falls and contacts that the summary does not admit, though they were found."""
    collisions = summary.get("collisions")
    told = dict(collisions) if isinstance(collisions, Mapping) else {}
    told["falls"] = summary.get("falls")
    result = []
    for key, count in found.items():
        claim = told.get(key)
        if count > 0 and not (isinstance(claim, int) and claim > 0):
            words = key.replace("_", "-") + (" contacts" if key != "falls" else "")
            text = f"the summary says {claim} {words}; the recording shows {count}"
            result.append(Violation("summary", end, everyone, text, float(claim or 0), count))
    if summary.get("success") and found.get("falls"):
        text = "the summary claims success; a robot has fallen"
        result.append(Violation("summary", end, everyone, text, 1.0, 0.0))
    return result


def _check_distances(
    summary: Mapping[str, Any], found: Mapping[str, float], end: float, everyone: tuple[int, ...]
) -> list[Violation]:
    """Smallest distances, inf where nothing was near, that the summary says are larger."""
    result = []
    for key, distance in found.items():
        claim = summary.get(key)
        if isinstance(claim, bool) or not isinstance(claim, int | float):
            claim = math.inf
        if math.isfinite(distance) and claim > distance + DISTANCE:
            text = f"the summary says {key} {claim:.3f}; the recording shows {distance:.3f}"
            result.append(Violation("summary", end, everyone, text, float(claim), distance))
    return result


def _pair_distance(tracks: tuple[Track, ...], ticks: Array) -> float:
    """Smallest distance in m of two robots' centres that move evenly; inf for one robot."""
    least = np.inf
    places = [track.at(ticks)[:, :2] for track in tracks]
    for one, two in combinations(places, 2):
        begin, change = (one - two)[:-1], np.diff(one - two, axis=0)
        square = np.maximum((change * change).sum(axis=1), 1e-300)
        part = np.clip(-(begin * change).sum(axis=1) / square, 0.0, 1.0)
        closest = np.hypot(*(begin + part[:, None] * change).T)
        least = min(least, float(closest.min()))
    return least


def _obstacle_distance(
    scene: Scene, tracks: tuple[Track, ...], models: tuple[RobotModel, ...], ticks: Array
) -> float:
    """Smallest distance in m of a centre to obstacles, map and border; inf beyond 1 m."""
    points = tuple(model.with_limits(length=0.0, width=0.0, round=True) for model in models)
    _, gap = find_contacts(scene, bodies(tracks, points, ticks), ticks, among=False)
    return gap if gap < FARTHEST else np.inf


def _measured(
    records: Sequence[RobotRecord], descriptions: Sequence[QuadrupedDescription], floor: Floor
) -> PhysicsFigures:
    """The figures of a team."""
    carried: list[float | None] = []
    torque, slide = 0.0, 0.0
    for record, description in zip(records, descriptions, strict=True):
        links = posture(record, description, floor=floor)
        nothing = np.zeros((len(record.time) - 1, 3))
        carried.append(carried_part(record, links, nothing, touched(record)))
        ratio = np.abs(record.torques) / description.torque_limits
        torque = max(torque, float(ratio.max(initial=0.0)))
        slide = max(slide, float(slides(record, links).max(initial=0.0)))
    return PhysicsFigures(tuple(carried), torque, slide)
