"""Whether a plan is what the scenario asks for, and its summary says what the plan shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from cavalcade.checking.arrival import DISTANCE, TURN
from cavalcade.checking.plans.motion import Motion
from cavalcade.checking.report import Violation
from cavalcade.geometry import wrap_angle
from cavalcade.robots import RobotModel

Pose = tuple[float, float, float]

START = (1e-3, 1e-3)
"""How far a plan may begin from the scenario's start, m and rad."""

_SLACK = 1e-3
_SHARE = 1e-3
"""Figures of the summary may be off by this much, or by this fraction."""


def heads(model: RobotModel) -> bool:
    """Whether it matters where the robot looks: not for one that goes in all directions."""
    return not model.drive.startswith("integrator")


def check_start(motion: Motion, model: RobotModel, start: Pose) -> list[Violation]:
    """A plan that does not begin where the scenario says."""
    distance, turn = _apart(motion, 0, start)
    if distance <= START[0] and (turn <= START[1] or not heads(model)):
        return []
    text = f"robot {motion.robot} begins {distance:.3f} m and {turn:.3f} rad from its start"
    return [Violation("start", 0.0, (motion.robot,), text, distance, START[0])]


def check_goal(motion: Motion, model: RobotModel, goal: Pose) -> list[Violation]:
    """A plan that is said to solve the problem, but ends elsewhere."""
    distance, turn = _apart(motion, -1, goal)
    end, robot = float(motion.time[-1]), motion.robot
    result = []
    if distance > DISTANCE + _SLACK:
        text = f"robot {robot} ends {distance:.3f} m from its goal"
        result.append(Violation("arrival", end, (robot,), text, distance, DISTANCE))
    if heads(model) and turn > TURN + _SLACK:
        text = f"robot {robot} ends turned by {turn:.3f} rad from its goal"
        result.append(Violation("arrival", end, (robot,), text, turn, TURN))
    return result


def check_missing(motions: tuple[Motion | None, ...], spoken_of: set[int]) -> list[Violation]:
    """Robots without motion in a plan that is said to solve the problem.

    Args:
        motions: Of each robot.
        spoken_of: Robots of whose arrays something is wrong.
    """
    return [
        Violation("plan", 0.0, (robot,), f"robot {robot} has no plan", 0.0, 1.0)
        for robot, motion in enumerate(motions)
        if motion is None and robot not in spoken_of
    ]


def check_figures(
    motions: tuple[Motion | None, ...], summary: Mapping[str, Any]
) -> list[Violation]:
    """Lengths, durations and makespan of a solved plan's summary."""
    lengths = [None if m is None else path_length(m) for m in motions]
    durations = [None if m is None else float(m.time[-1]) for m in motions]
    result = []
    for key, found in (("path_length_m", lengths), ("duration_s", durations)):
        said = summary.get(key)
        if not isinstance(said, list) or len(said) != len(motions):
            text = f"{key} of the summary has no value for each of {len(motions)} robots"
            result.append(Violation("summary", 0.0, (), text, 0.0, float(len(motions))))
            continue
        for robot, (claim, truth) in enumerate(zip(said, found, strict=True)):
            if truth is not None:
                result += _compared(f"{key} of robot {robot}", claim, truth, (robot,))
    whole = [duration for duration in durations if duration is not None]
    if whole:
        everyone = tuple(range(len(motions)))
        result += _compared("makespan_s", summary.get("makespan_s"), max(whole), everyone)
    return result


def path_length(motion: Motion) -> float:
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


def _apart(motion: Motion, sample: int, pose: Pose) -> tuple[float, float]:
    x, y = motion.position[sample, :2] - pose[:2]
    return float(np.hypot(x, y)), float(np.abs(wrap_angle(motion.yaw[sample] - pose[2])))
