"""The motion of a legged robot's body: dynamics, forces, ballistics, speed, heading.

All is judged by means over intervals. Accelerations that a friction cone or a largest force
allows form convex sets, so the mean of allowed ones is allowed: a sound plan passes whatever its
sampling.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.plans.motion import FLIGHT, GRAVITY, WALK, Motion
from cavalcade.checking.plans.stretches import excesses
from cavalcade.checking.report import Violation
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.legs import LegModel

TOLERANCE = 0.02
"""Speeds and forces may exceed their limits by this fraction."""

YAW_TOLERANCE = 0.05
"""Likewise yaw rates."""

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

_ROUNDING = 2e-5
_SPEED_ROUNDING = 1e-4
_REST = 0.02

Bools = NDArray[np.bool_]


def check_legged(motion: Motion, model: RobotModel, published: bool) -> list[Violation]:
    """Everything about a body's motion that needs no ground.

    Args:
        motion: With increasing times and known phases.
        model: Of a legged robot.
        published: Whether the published model holds: vertical speed may jump before and after a
            leap, and yaw follows the velocity however fast that turns.
    """
    legs = _legs(model)
    violations = _rest(motion)
    if len(motion.time) < 2:
        return violations
    seam = _seams(motion) if published else np.zeros(len(motion.time) - 1, dtype=bool)
    violations += _integrated(motion, legs, seam)
    violations += _walking_forces(motion, legs, seam)
    violations += _leaping_forces(motion, legs, seam)
    violations += _ballistics(motion)
    violations += _speeds(motion, legs)
    if not published:
        violations += _yaw_rates(motion, legs)
    violations += _heading(motion)
    return violations


def top_speed(model: RobotModel) -> float:
    """The largest speed of a robot with a goal of its own, m/s."""
    if model.drive == "legged" and model.legs is not None:
        return model.legs.v_max
    return model.max_speed_x


def _legs(model: RobotModel) -> LegModel:
    if model.legs is None:
        raise ValueError(f"{model.name} has no legs")
    return model.legs


def _rest(motion: Motion) -> list[Violation]:
    """A plan begins and ends at rest: what comes after it is standing."""
    result = []
    for k, words in ((0, "begins"), (-1, "ends")):
        speed = float(np.sqrt((motion.velocity[k] ** 2).sum()))
        if speed > _REST:
            text = f"robot {motion.robot} {words} its plan at {speed:.3f} m/s instead of at rest"
            time = float(motion.time[k])
            result.append(Violation("dynamics", time, (motion.robot,), text, speed, _REST))
    return result


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
    allowed = _ROUNDING + np.where(flying, 0.0, across) * dt * dt / 8.0
    allowed_z = _ROUNDING + np.where(flying, 0.0, along) * dt * dt / 8.0
    # A jump within the interval moves the body by at most half of it times the interval.
    allowed_z = allowed_z + np.where(seam, SEAM * dt / 2.0, 0.0)
    words = "is {value:.5f} m off from where its velocity takes it within one interval"
    time = motion.time[:-1]
    result = excesses(
        "dynamics", motion.robot, time, np.hypot(defect[:, 0], defect[:, 1]), allowed, words
    )
    height = words.replace(" off", " higher or lower")
    return result + excesses(
        "dynamics", motion.robot, time, np.abs(defect[:, 2]), allowed_z, height
    )


def _walking_forces(motion: Motion, legs: LegModel, seam: Bools) -> list[Violation]:
    """The friction cone of level ground, feet that only push, and a level gait."""
    walking = motion.phase[:-1] == WALK
    mean, time, dt = motion.acceleration, motion.time[:-1], motion.steps
    rounding = _SPEED_ROUNDING / dt
    most = legs.mu * GRAVITY
    result = excesses(
        "force",
        motion.robot,
        time,
        np.where(walking, np.hypot(mean[:, 0], mean[:, 1]), 0.0),
        most,
        "needs {value:.2f} m/s² across while walking; friction gives {limit:.2f}",
        TOLERANCE * most + rounding,
    )
    force = (mean[:, 2] + GRAVITY) / GRAVITY
    judged = walking & ~seam
    far = np.abs(force - legs.grf_max / 2.0)
    result += excesses(
        "force",
        motion.robot,
        time,
        np.where(judged, far, 0.0),
        legs.grf_max / 2.0,
        "needs a vertical force {value:.2f} body weights from the middle of what its legs give, "
        "{limit:.2f} either way",
        TOLERANCE * legs.grf_max + rounding / GRAVITY,
    )
    return result + _sway(motion, seam)


def _sway(motion: Motion, seam: Bools) -> list[Violation]:
    """Vertical acceleration over windows that lie within one stretch of walking."""
    time, result = motion.time, []
    free = (motion.phase[:-1] == WALK) & ~seam
    edges = np.flatnonzero(np.diff(np.concatenate(([False], free, [False])).astype(np.int8)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if time[end] - time[begin] < WINDOW:
            continue
        first = time[begin : end + 1]
        first = first[first <= time[end] - WINDOW]
        rise = motion.velocity[begin : end + 1, 2]
        later = np.interp(first + WINDOW, time[begin : end + 1], rise)
        sway = np.abs(later - rise[: len(first)]) / WINDOW
        words = "rises or sinks with {value:.2f} m/s² while walking; {limit:.2f} is moderate"
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
    rounding = _SPEED_ROUNDING / (motion.steps * GRAVITY)
    judged, time, robot = pushing & ~seam, motion.time[:-1], motion.robot
    cone = legs.mu * np.maximum(force[:, 2], 0.0)
    result = excesses(
        "force",
        robot,
        time,
        np.where(judged, across, 0.0),
        cone,
        "needs {value:.2f} body weights across in a leap; friction gives {limit:.2f}",
        TOLERANCE * cone + rounding,
    )
    result += excesses(
        "force",
        robot,
        time,
        np.where(judged, -force[:, 2], -1.0),
        0.0,
        "would have to pull at the ground with {value:.2f} body weights in a leap",
        TOLERANCE + rounding,
    )
    return result + excesses(
        "force",
        robot,
        time,
        np.where(judged, np.hypot(across, force[:, 2]), 0.0),
        legs.grf_max,
        "needs {value:.2f} body weights in a leap; its legs give {limit:.2f}",
        TOLERANCE * legs.grf_max + rounding,
    )


def _ballistics(motion: Motion) -> list[Violation]:
    """In flight nothing but gravity acts."""
    flying = motion.phase[:-1] == FLIGHT
    if not flying.any():
        return []
    wrong = motion.acceleration + np.array([0.0, 0.0, GRAVITY])
    size = np.sqrt((wrong * wrong).sum(axis=1))
    return excesses(
        "ballistics",
        motion.robot,
        motion.time[:-1],
        np.where(flying, size, 0.0),
        0.0,
        "accelerates in flight with {value:.3f} m/s² beside gravity",
        1e-3 + 1e-5 / motion.steps,
    )


def _speeds(motion: Motion, legs: LegModel) -> list[Violation]:
    robot, time = motion.robot, motion.time
    words = "moves at {value:.3f} m/s; the limit is {limit:.3f}"
    slack = TOLERANCE * legs.v_max
    said = np.hypot(motion.velocity[:, 0], motion.velocity[:, 1])
    moved = np.diff(motion.position[:, :2], axis=0) / motion.steps[:, None]
    fastest = said.copy()
    fastest[:-1] = np.maximum(said[:-1], np.hypot(moved[:, 0], moved[:, 1]))
    return excesses("speed", robot, time, fastest, legs.v_max, words, slack)


def _yaw_rates(motion: Motion, legs: LegModel) -> list[Violation]:
    return excesses(
        "yaw-rate",
        motion.robot,
        motion.time[:-1],
        np.abs(motion.yaw_rate),
        legs.yaw_rate,
        "turns at {value:.3f} rad/s; the limit is {limit:.3f}",
        YAW_TOLERANCE * legs.yaw_rate + _SPEED_ROUNDING / motion.steps,
    )


def _heading(motion: Motion) -> list[Violation]:
    """While it walks, the body looks where it goes; slowly it may also step straight back."""
    x, y = motion.velocity[:, 0], motion.velocity[:, 1]
    off = np.abs(wrap_angle(np.arctan2(y, x) - motion.yaw))
    speed = np.hypot(x, y)
    off = np.where(speed <= BACKWARDS, np.minimum(off, np.pi - off), off)
    moving: Array = (motion.phase == WALK) & (speed > STROLL)
    return excesses(
        "heading",
        motion.robot,
        motion.time,
        np.where(moving, off, 0.0),
        0.0,
        "walks {value:.3f} rad off from where it looks",
        HEADING,
    )
