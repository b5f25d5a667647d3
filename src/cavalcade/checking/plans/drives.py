"""The motion of robots without legs: unicycles and integrators, of first and second order.

Of first-order drives velocities may jump; then a sample holds that before or that after. Rest at
both ends and limits of speed and yaw rate are checked for robots with legs as well.
"""

from __future__ import annotations

import numpy as np

from cavalcade.checking.limits import TOLERANCE
from cavalcade.checking.plans.motion import POSITION_ROUNDING, SPEED_ROUNDING, Motion
from cavalcade.checking.report import Violation, broken
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel

SIDEWAYS = 0.02
"""A unicycle's sideways speed as a fraction of its largest speed: rounding, and the turning
within one interval."""

_REST = 0.02


def check_driven(motion: Motion, model: RobotModel) -> list[Violation]:
    """Everything about the motion, with increasing times, of a robot without legs."""
    second = model.drive.endswith("-2")
    turning = model.drive.startswith("unicycle")
    violations = _level(motion)
    if second:
        violations += check_rest(motion, motion.speed)
    if len(motion.time) > 1:
        violations += _integrated(motion, model, second)
        violations += check_speed(motion, model.max_speed_x)
        # Nobody can see how a disc that goes anywhere is turned.
        if turning or not model.round:
            violations += check_yaw_rate(motion, model.max_yaw_rate, TOLERANCE)
        if turning:
            violations += _sideways(motion, model)
        if second:
            violations += _accelerations(motion, model, turning)
    return violations


def check_rest(motion: Motion, speeds: Array) -> list[Violation]:
    """A plan begins and ends at rest, of speeds `(T,)` m/s: what comes after it is standing."""
    result = []
    for k, words in ((0, "begins"), (-1, "ends")):
        speed = speeds[k]
        if speed > _REST:
            text = f"robot {motion.robot} {words} its plan at {speed:.3f} m/s instead of at rest"
            result.append(broken("dynamics", motion.time[k], motion.robot, text, speed, _REST))
    return result


def check_speed(motion: Motion, limit: float) -> list[Violation]:
    """At each sample and on average in between, m/s."""
    fastest = motion.speed
    moved = motion.mean_velocity
    fastest[:-1] = np.maximum(fastest[:-1], np.hypot(moved[:, 0], moved[:, 1]))
    words = "moves at {value:.3f} m/s; the limit is {limit:.3f}"
    return motion.excesses("speed", fastest, limit, words, TOLERANCE * limit)


def check_yaw_rate(motion: Motion, limit: float, tolerance: float) -> list[Violation]:
    """In rad/s; it may be exceeded by the fraction `tolerance`."""
    words = "turns at {value:.3f} rad/s; the limit is {limit:.3f}"
    slack = tolerance * limit + SPEED_ROUNDING / motion.steps
    return motion.excesses("yaw-rate", np.abs(motion.yaw_rate), limit, words, slack)


def _level(motion: Motion) -> list[Violation]:
    away = np.abs(motion.position[:, 2] - motion.position[0, 2])
    moving = np.maximum(away, np.abs(motion.velocity[:, 2]))
    words = "rises or sinks by {value:.4f} m or m/s, but has no legs"
    return motion.excesses("dynamics", moving, 0.0, words, 1e-6)


def _integrated(motion: Motion, model: RobotModel, second: bool) -> list[Violation]:
    """Positions must change by the integral of the velocity."""
    dt = motion.steps[:, None]
    one, two = motion.velocity[:-1, :2], motion.velocity[1:, :2]
    moved = np.diff(motion.position[:, :2], axis=0)
    bend = np.zeros_like(dt)
    if model.drive.startswith("unicycle"):
        # Within an interval it may turn one way and back again, moving along all the while.
        bend = model.max_speed_x * model.max_yaw_rate * dt * dt / 4.0
    if second:
        allowed = POSITION_ROUNDING + bend + 2.0 * model.max_acceleration * dt * dt / 8.0
        defect = np.abs(moved - (one + two) / 2.0 * dt)
    else:
        allowed = POSITION_ROUNDING + bend
        low, high = np.minimum(one, two) * dt, np.maximum(one, two) * dt
        defect = np.maximum(np.maximum(low - moved, moved - high), 0.0)
    worst = (defect - allowed).argmax(axis=1)[:, None]
    return motion.excesses(
        "dynamics",
        np.take_along_axis(defect, worst, axis=1)[:, 0],
        np.take_along_axis(np.broadcast_to(allowed, defect.shape), worst, axis=1)[:, 0],
        "is {value:.5f} m off from where its velocity takes it within one interval",
    )


def _sideways(motion: Motion, model: RobotModel) -> list[Violation]:
    """A unicycle moves along its heading, at each sample and on average in between."""
    slack = SIDEWAYS * model.max_speed_x + SPEED_ROUNDING
    words = "moves sideways at {value:.3f} m/s, but is a unicycle"
    sideways = _across(motion.velocity[:, :2], motion.yaw)
    middle = (motion.yaw[1:] + motion.yaw[:-1]) / 2.0
    sideways[:-1] = np.maximum(sideways[:-1], _across(motion.mean_velocity, middle))
    return motion.excesses("dynamics", sideways, 0.0, words, slack)


def _across(vector: Array, yaw: Array) -> Array:
    return np.abs(np.cos(yaw) * vector[:, 1] - np.sin(yaw) * vector[:, 0])


def _accelerations(motion: Motion, model: RobotModel, turning: bool) -> list[Violation]:
    dt, velocity = motion.steps, motion.velocity[:, :2]
    if turning:
        # What changes speed counts, not what changes direction.
        forward = velocity[:, 0] * np.cos(motion.yaw) + velocity[:, 1] * np.sin(motion.yaw)
        change = np.abs(np.diff(forward))
    else:
        step = np.diff(velocity, axis=0)
        change = np.hypot(step[:, 0], step[:, 1])
    words = "accelerates with {value:.3f} m/s²; the limit is {limit:.3f}"
    most = model.max_acceleration
    slack = TOLERANCE * most + SPEED_ROUNDING / dt
    result = motion.excesses("acceleration", change / dt, most, words, slack)
    if not turning:
        return result
    # Yaw rates are known as means only, at the middle of each interval, and are 0 at both ends.
    rate = np.concatenate(([0.0], motion.yaw_rate, [0.0]))
    half = np.concatenate(([0.0], dt, [0.0])) / 2.0
    between = half[1:] + half[:-1]
    change, most = np.abs(np.diff(rate)) / between, model.max_yaw_acceleration
    words = "turns ever faster with {value:.3f} rad/s²; the limit is {limit:.3f}"
    slack = TOLERANCE * most + 2.0 * SPEED_ROUNDING / between
    return result + motion.excesses("yaw-acceleration", change, most, words, slack)
