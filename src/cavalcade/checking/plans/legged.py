"""The motion of a legged robot's body: dynamics, forces, ballistics, speed, heading.

All is judged by means over intervals. Accelerations that a friction cone or a largest force
allows form convex sets, so the mean of allowed ones is allowed: a sound plan passes whatever its
sampling.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.plans.drives import TOLERANCE, check_rest, check_speed, check_yaw_rate
from cavalcade.checking.plans.motion import (
    FLIGHT,
    POSITION_ROUNDING,
    SPEED_ROUNDING,
    WALK,
    Motion,
)
from cavalcade.checking.report import Violation
from cavalcade.checking.stretches import excesses, stretches
from cavalcade.geometry import GRAVITY, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.model import LegModel

YAW_TOLERANCE = 0.05
"""Yaw rates may exceed their limit by this fraction."""

HEADING = 0.1
"""Largest angle between a walking body and its velocity, rad."""

STROLL = 0.1
"""Slower than this the heading is free, m/s."""

BACKWARDS = 0.305
"""No faster than this robots may walk backwards, m/s."""

SEAM = 4.0
"""Largest jump of vertical speed before and after a leap of the published model, m/s."""

SWAY = 0.65
"""Largest vertical acceleration in walking, over `WINDOW` seconds, in g."""

WINDOW = 0.15

Bools = NDArray[np.bool_]


def check_legged(motion: Motion, model: RobotModel, published: bool) -> list[Violation]:
    """Everything about a body's motion, with increasing times, that needs no ground.

    If the published model holds, vertical speed may jump before and after a leap, and yaw follows
    the velocity however fast that turns.
    """
    if model.legs is None:
        raise ValueError(f"{model.name} has no legs")
    legs = model.legs
    violations = check_rest(
        motion, [float(np.sqrt((motion.velocity[k] ** 2).sum())) for k in (0, -1)]
    )
    if len(motion.time) < 2:
        return violations
    seam = _seams(motion) if published else np.zeros(len(motion.time) - 1, dtype=bool)
    violations += _integrated(motion, legs, seam)
    violations += _walking_forces(motion, legs, seam)
    violations += _leaping_forces(motion, legs, seam)
    violations += _ballistics(motion)
    violations += check_speed(motion, legs.v_max)
    if not published:
        violations += check_yaw_rate(motion, legs.yaw_rate, YAW_TOLERANCE)
    return violations + _heading(motion)


def top_speed(model: RobotModel) -> float:
    """The largest speed of a robot with a goal of its own, m/s."""
    if model.drive == "legged" and model.legs is not None:
        return model.legs.v_max
    return model.max_speed_x


def _seams(motion: Motion) -> Bools:
    """`(T - 1,)` intervals next to the beginning or the end of a leap."""
    leaping = motion.phase[:-1] != WALK
    change = np.flatnonzero(np.diff(leaping)) + 1
    seam = np.zeros(len(leaping), dtype=bool)
    seam[change] = True
    seam[change - 1] = True
    # A leap may begin with the plan, end with it, and follow another one at once.
    seam[0] |= leaping[0]
    seam[-1] |= leaping[-1]
    again = np.flatnonzero(np.diff(motion.phase[:-1]) < 0) + 1
    seam[again] = True
    seam[again - 1] = True
    return seam


def _integrated(motion: Motion, legs: LegModel, seam: Bools) -> list[Violation]:
    """Positions must change by the integral of the velocity.

    The mean of both ends' velocities is that integral but for what the acceleration changes on
    the way: by A at most, that is A dt² / 8.
    """
    dt, phase = motion.steps, motion.phase[:-1]
    mean = (motion.velocity[1:] + motion.velocity[:-1]) / 2.0
    defect = np.diff(motion.position, axis=0) - mean * dt[:, None]
    walking, flying = phase == WALK, phase == FLIGHT
    hard = legs.grf_max * GRAVITY
    across = np.where(walking, 2.0 * legs.mu * GRAVITY, 2.0 * legs.mu * hard)
    along = np.where(walking, 2.0 * GRAVITY, hard)
    allowed = POSITION_ROUNDING + np.where(flying, 0.0, across) * dt * dt / 8.0
    allowed_z = POSITION_ROUNDING + np.where(flying, 0.0, along) * dt * dt / 8.0
    # A jump within the interval moves the body by at most half of it times the interval.
    allowed_z = allowed_z + np.where(seam, SEAM * dt / 2.0, 0.0)
    words = "is {value:.5f} m off from where its velocity takes it within one interval"
    result = motion.excesses("dynamics", np.hypot(defect[:, 0], defect[:, 1]), allowed, words)
    words = words.replace(" off", " higher or lower")
    return result + motion.excesses("dynamics", np.abs(defect[:, 2]), allowed_z, words)


def _walking_forces(motion: Motion, legs: LegModel, seam: Bools) -> list[Violation]:
    """The friction cone of level ground, feet that only push, and a level gait."""
    walking = motion.phase[:-1] == WALK
    mean, rounding = motion.acceleration, SPEED_ROUNDING / motion.steps
    most = legs.mu * GRAVITY
    across = np.where(walking, np.hypot(mean[:, 0], mean[:, 1]), 0.0)
    words = "needs {value:.2f} m/s² across while walking; friction gives {limit:.2f}"
    result = motion.excesses("force", across, most, words, TOLERANCE * most + rounding)
    force = (mean[:, 2] + GRAVITY) / GRAVITY
    far = np.where(walking & ~seam, np.abs(force - legs.grf_max / 2.0), 0.0)
    words = (
        "needs a vertical force {value:.2f} body weights from the middle of what its legs give, "
        "{limit:.2f} either way"
    )
    slack = TOLERANCE * legs.grf_max + rounding / GRAVITY
    result += motion.excesses("force", far, legs.grf_max / 2.0, words, slack)
    return result + _sway(motion, seam)


def _sway(motion: Motion, seam: Bools) -> list[Violation]:
    """Vertical acceleration over windows that lie within one stretch of walking."""
    time, result = motion.time, []
    words = "rises or sinks with {value:.2f} m/s² while walking; {limit:.2f} is moderate"
    for begin, end in stretches((motion.phase[:-1] == WALK) & ~seam):
        if time[end] - time[begin] < WINDOW:
            continue
        first = time[begin : end + 1]
        first = first[first <= time[end] - WINDOW]
        rise = motion.velocity[begin : end + 1, 2]
        later = np.interp(first + WINDOW, time[begin : end + 1], rise)
        sway = np.abs(later - rise[: len(first)]) / WINDOW
        result += excesses("force", motion.robot, first, sway, SWAY * GRAVITY, words)
    return result


def _leaping_forces(motion: Motion, legs: LegModel, seam: Bools) -> list[Violation]:
    """Ground reaction force in take-off and landing: within the cone and the legs' strength."""
    phase = motion.phase[:-1]
    pushing = (phase != WALK) & (phase != FLIGHT)
    if not pushing.any():
        return []
    force = motion.acceleration / GRAVITY + np.array([0.0, 0.0, 1.0])
    across = np.hypot(force[:, 0], force[:, 1])
    rounding = SPEED_ROUNDING / (motion.steps * GRAVITY)
    judged = pushing & ~seam
    cone = legs.mu * np.maximum(force[:, 2], 0.0)
    words = "needs {value:.2f} body weights across in a leap; friction gives {limit:.2f}"
    sideways = np.where(judged, across, 0.0)
    result = motion.excesses("force", sideways, cone, words, TOLERANCE * cone + rounding)
    words = "would have to pull at the ground with {value:.2f} body weights in a leap"
    pull = np.where(judged, -force[:, 2], -1.0)
    result += motion.excesses("force", pull, 0.0, words, TOLERANCE + rounding)
    words = "needs {value:.2f} body weights in a leap; its legs give {limit:.2f}"
    size = np.where(judged, np.hypot(across, force[:, 2]), 0.0)
    slack = TOLERANCE * legs.grf_max + rounding
    return result + motion.excesses("force", size, legs.grf_max, words, slack)


def _ballistics(motion: Motion) -> list[Violation]:
    """In flight nothing but gravity acts."""
    flying = motion.phase[:-1] == FLIGHT
    if not flying.any():
        return []
    wrong = motion.acceleration + np.array([0.0, 0.0, GRAVITY])
    size = np.where(flying, np.sqrt((wrong * wrong).sum(axis=1)), 0.0)
    words = "accelerates in flight with {value:.3f} m/s² beside gravity"
    return motion.excesses("ballistics", size, 0.0, words, 1e-3 + 1e-5 / motion.steps)


def _heading(motion: Motion) -> list[Violation]:
    """While it walks, the body looks where it goes; slowly it may also step straight back."""
    speed = motion.speed
    off = np.abs(wrap_angle(np.arctan2(motion.velocity[:, 1], motion.velocity[:, 0]) - motion.yaw))
    off = np.where(speed <= BACKWARDS, np.minimum(off, np.pi - off), off)
    off = np.where((motion.phase == WALK) & (speed > STROLL), off, 0.0)
    words = "walks {value:.3f} rad off from where it looks"
    return motion.excesses("heading", off, 0.0, words, HEADING)
