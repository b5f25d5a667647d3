"""The verdict on a plan: what it is, whether the scenario asks for it, what it says of itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.arrival import IDEAL
from cavalcade.checking.contact import bodies, common_clock, find_contacts
from cavalcade.checking.heights import Heights, floor_of, read_heights
from cavalcade.checking.limits import with_own_limits
from cavalcade.checking.places import check_places
from cavalcade.checking.plans.body import check_body
from cavalcade.checking.plans.drives import check_driven
from cavalcade.checking.plans.footholds import check_footholds
from cavalcade.checking.plans.legged import check_legged
from cavalcade.checking.plans.motion import FLIGHT, Motion, read_motions
from cavalcade.checking.report import Figures, Report, Violation, broken, make_report
from cavalcade.checking.solids import Scene, build_scene
from cavalcade.checking.tracks import Pose, off_start
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario

START = (1e-3, 1e-3)
"""How far a plan may begin from the scenario's start, m and rad."""

_SLACK = 1e-3
_SHARE = 1e-3
"""Figures of the summary may be off by this much, or by this fraction."""


def judge_plan(
    scenario: Scenario,
    arrays: Mapping[str, NDArray[Any]],
    summary: Mapping[str, Any],
    *,
    figures: bool = True,
) -> Report:
    """The verdict on a plan, nothing written or read but the ground's own files.

    If the summary claims success, every robot must have a motion that ends at its goal, and none
    may touch another. Otherwise what there is is partial knowledge, each robot's motion
    regardless of the others: then each is judged by itself.

    Args:
        scenario: A resolved one with a goal for each robot.
        arrays: As in `plan.npz`.
        summary: What the plan says of itself.
        figures: Whether its lengths and durations are those of the plan.

    Raises:
        RecordingError: A file of the ground cannot be read.
    """
    models = scenario.models
    motions, violations = read_motions(arrays, models)
    spoken_of = {robot for violation in violations for robot in violation.robots}
    known = tuple(motion for motion in motions if motion is not None)
    solved = bool(summary.get("success"))
    heights = read_heights(scenario)
    bellies: list[float] = []
    for motion in known:
        violations += _alone(scenario, motion, models[motion.robot], heights, bellies)
    gap = np.inf
    if known:
        scene = build_scene(scenario, heights)
        contacts, gap = _contacts(scene, models, known, solved)
        violations += contacts + check_places(scenario, scene, solved, contacts)
    if solved:
        for motion in known:
            violations += _check_goal(motion, models[motion.robot], scenario.goals[motion.robot])
        violations += [
            broken("plan", 0.0, robot, f"robot {robot} has no plan", 0.0, 1.0)
            for robot, motion in enumerate(motions)
            if motion is None and robot not in spoken_of
        ]
        if figures:
            violations += _check_figures(known, len(models), summary)
    return make_report(violations, _figures(known, models, gap, bellies) if known else None)


def _alone(
    scenario: Scenario,
    motion: Motion,
    model: RobotModel,
    heights: Heights | None,
    bellies: list[float],
) -> list[Violation]:
    """What is wrong with a robot's motion without looking at the others.

    The least clearance of its belly goes into `bellies`.
    """
    robot, pose = motion.robot, motion.track.pose[0]
    violations = off_start(robot, 0.0, pose, scenario.starts[robot], START, _heads(model))
    if model.legs is None or model.drive != "legged":
        return violations + check_driven(motion, model)
    places = np.vstack((motion.position[:, :2], motion.footholds[:, 3:5]))
    ground = floor_of(heights, places)
    violations += check_legged(motion, model.legs, scenario.planner.variant == "published")
    found, clearance = check_body(motion, model.legs, ground)
    bellies.append(clearance)
    return violations + found + check_footholds(motion, model.legs, ground)


def _contacts(
    scene: Scene, models: tuple[RobotModel, ...], motions: tuple[Motion, ...], solved: bool
) -> tuple[list[Violation], float]:
    """Contact of swept footprints until the last robot stands: then nothing moves any more."""
    tracks = tuple(motion.track for motion in motions)
    ticks = common_clock(tracks, scene.solids)
    own = tuple(models[motion.robot] for motion in motions)
    team = tuple(
        replace(body, index=motion.robot)
        for body, motion in zip(bodies(tracks, own, ticks), motions, strict=True)
    )
    found, gap = find_contacts(scene, team, ticks, among=solved)
    by_robot = {motion.robot: motion for motion in motions}
    return [_named(violation, by_robot) for violation in found], gap


def _named(contact: Violation, motions: Mapping[int, Motion]) -> Violation:
    """Contact between robots of which one flies: over the other or into it, it must not be."""
    if contact.kind != "robot-robot":
        return contact
    for robot in contact.robots:
        if motions[robot].phase_at(contact.time) == FLIGHT:
            other = next(k for k in contact.robots if k != robot)
            text = f"robot {robot} flies over robot {other}, or into it: {contact.message}"
            return replace(contact, kind="flight-over-robot", message=text)
    return contact


def _figures(
    motions: tuple[Motion, ...],
    models: tuple[RobotModel, ...],
    gap: float,
    bellies: list[float],
) -> Figures:
    def largest(values: Array) -> float:
        return float(values.max(initial=0.0))

    top_speeds = [with_own_limits(model, False).max_speed_x for model in models]
    return Figures(
        robots=len(motions),
        duration_s=max(_duration(motion) for motion in motions),
        min_footprint_gap_m=gap,
        max_speed_ratio=max(largest(m.speed) / top_speeds[m.robot] for m in motions),
        max_yaw_rate=max(largest(np.abs(m.yaw_rate)) for m in motions),
        max_acceleration=max(largest(np.hypot(*m.acceleration[:, :2].T)) for m in motions),
        max_yaw_acceleration=max(largest(_yaw_accelerations(m)) for m in motions),
        min_belly_clearance_m=min(bellies, default=None),
    )


def _yaw_accelerations(motion: Motion) -> Array:
    dt = motion.steps
    return np.abs(np.diff(motion.yaw_rate)) / ((dt[1:] + dt[:-1]) / 2.0)


def _heads(model: RobotModel) -> bool:
    """Whether it matters where the robot looks: not for one that goes in all directions."""
    return not model.drive.startswith("integrator")


def _check_goal(motion: Motion, model: RobotModel, goal: Pose) -> list[Violation]:
    """A plan that is said to solve the problem, but ends elsewhere."""
    x, y = motion.position[-1, :2] - goal[:2]
    distance, turn = np.hypot(x, y), np.abs(wrap_angle(motion.yaw[-1] - goal[2]))
    end, robot = motion.time[-1], motion.robot
    result = []
    if distance > IDEAL.distance + _SLACK:
        text = f"robot {robot} ends {distance:.3f} m from its goal"
        result.append(broken("arrival", end, robot, text, distance, IDEAL.distance))
    if _heads(model) and turn > IDEAL.turn + _SLACK:
        text = f"robot {robot} ends turned by {turn:.3f} rad from its goal"
        result.append(broken("arrival", end, robot, text, turn, IDEAL.turn))
    return result


def _check_figures(
    motions: Sequence[Motion], robots: int, summary: Mapping[str, Any]
) -> list[Violation]:
    """Lengths, durations and makespan of a solved plan's summary."""
    result = []
    for key, measure in (("path_length_m", _path_length), ("duration_s", _duration)):
        said = summary.get(key)
        if not isinstance(said, list) or len(said) != robots:
            text = f"{key} of the summary has no value for each of {robots} robots"
            result.append(Violation("summary", 0.0, (), text, 0.0, float(robots)))
            continue
        for motion in motions:
            robot = motion.robot
            result += _compared(f"{key} of robot {robot}", said[robot], measure(motion), (robot,))
    if motions:
        everyone, last = tuple(range(robots)), max(_duration(motion) for motion in motions)
        result += _compared("makespan_s", summary.get("makespan_s"), last, everyone)
    return result


def _duration(motion: Motion) -> float:
    return float(motion.time[-1])


def _path_length(motion: Motion) -> float:
    """Of the way of the body's centre in space, m."""
    steps = np.diff(motion.position, axis=0)
    return float(np.sqrt((steps * steps).sum(axis=1)).sum())


def _compared(key: str, claim: Any, truth: float, robots: tuple[int, ...]) -> list[Violation]:
    number = isinstance(claim, int | float) and not isinstance(claim, bool)
    if number and math.isclose(claim, truth, rel_tol=_SHARE, abs_tol=_SLACK):
        return []
    said = f"{claim:.4g}" if number else repr(claim)[:40]
    text = f"{key} is {said} in the summary, {truth:.4g} in the plan"
    value = float(claim) if number else math.nan
    return [Violation("summary", 0.0, robots, text, value, truth)]
