"""Velocities from poses, and the team's state when the next command takes effect.

`VelocityTracker` is for robots that are located and reached perfectly. For others, poses arrive
noisy, and now and then not at all; commands take effect late, and now and then not at all. The
motion model, driven by the commands that are in effect by then, bridges both: `StateEstimator`
carries the estimate from report to report, and on from now to the moment that a command sent now
reaches the robot (a Smith predictor). Reports correct it with the gain of a steady Kalman filter
whose state drifts at random.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import MotionLimits, limits_of, predict_team
from cavalcade.values import number_in

_DRIFT = 0.08  # m/s and rad/s that a robot departs from the model at random
_STEADY = 0.2  # largest share of a cycle's surprise that is put down to the velocity
_WINDOW = 5  # cycles over which a tracker compares prediction and poses
_TRUSTED = 0.025  # m and rad: displacements over the window that differ by less agree
_STEP = 0.0125  # s: step of the prediction
_LONGEST = 0.5  # s without a cycle after which a robot stands
_ELSEWHERE = 0.5  # m or rad from the prediction where the robot must have been moved,
_OUTLIER = 5.0  # if that is also so many standard deviations of the reports
_FORESEEN = 0.1  # m and rad from the prediction at which a robot is taken to be where it should
_SIGMAS = 3.0  # standard deviations of the estimate that count as its error


MAX_AGE = 0.5
"""Age of a pose from which on nobody may be driven by it, s, where nothing else is said."""

_MOST = {"delay": 10.0, "jitter": 10.0, "drop": 1.0}


@dataclass(frozen=True)
class Imperfections:
    """What a planner expects of the localisation and of the radio.

    Attributes:
        position, heading: Standard deviations of the reported poses, m and rad.
        delay, jitter: Mean and standard deviation of the time from a command's being sent to its
            taking effect, s.
        drop: Fraction of the messages that are lost.
        tracking_error: How far a robot may be from where its motion model foresees it, m.
        max_age: Age that the last pose of a robot may have before it, and with it the team, is
            stopped, s; looked at where `FormationPlanner.step` is told stamps.

    Raises:
        InputError: A value that is no number or out of range.
    """

    position: float = 0.0
    heading: float = 0.0
    delay: float = 0.0
    jitter: float = 0.0
    drop: float = 0.0
    tracking_error: float = 0.0
    max_age: float = MAX_AGE

    def __post_init__(self) -> None:
        for field in fields(self):
            number_in(getattr(self, field.name), field.name, 0.0, _MOST.get(field.name, 100.0))
        if self.max_age == 0.0:
            raise InputError("expected a number above 0", key="max_age")

    @property
    def none(self) -> bool:
        """Robots are located and reached perfectly."""
        return not (self.position or self.heading or self.delay or self.jitter or self.drop)

    def error(self, period: float, reach: float) -> float:
        """How far a point of a robot, `reach` from its centre, may be from where it is taken, m."""
        number_in(period, "period", 1e-3, 10.0, "s")
        number_in(reach, "reach", 0.0)
        place = self.position * math.sqrt(_gain(self.position, period))
        turn = self.heading * math.sqrt(_gain(self.heading, period))
        return _SIGMAS * math.hypot(place, reach * turn) + self.tracking_error

    def held(self, period: float) -> int:
        """Cycles that a command may stay in effect before the next one arrives, at least 1.

        As many messages in a row as are lost once in a thousand times, and two standard
        deviations of the jitter.
        """
        number_in(period, "period", 1e-3, 10.0, "s")
        lost = 0 if self.drop == 0.0 else math.ceil(math.log(1e-3) / math.log(min(self.drop, 0.5)))
        # The last of them costs at most the difference of two successive commands.
        return max(1, lost) + math.ceil(2.0 * self.jitter / period)


def longest_gap(period: float) -> float:
    """Seconds between cycles of `period` s from which on what was known of the team is past."""
    return max(_LONGEST, 2.5 * period)


class VelocityTracker:
    """Estimates the team's velocities; poses are taken as they are.

    A robot that moves as the model predicts from its commands has the predicted velocity, without
    the noise of differences. One that does not (late or lost commands, a slip) has the velocity
    that its last poses tell. Updates are expected every `period` s.
    """

    def __init__(self, model: RobotModel, period: float = 0.05) -> None:
        self._longest = longest_gap(period)
        self._limits = limits_of(model)
        self._poses: Array = np.empty((0, 3))
        self._velocities: Array = np.empty((0, 3))
        self._commands: Array = np.empty((0, 3))
        self._time = 0.0
        self._stamps: Array | None = None
        # Per cycle: seconds, displacement seen and displacement predicted.
        self._history: deque[tuple[float, Array, Array]] = deque(maxlen=_WINDOW)

    def update(self, poses: Array, time: float, stamps: Array | None = None) -> tuple[Array, Array]:
        """The poses `(N, 3)`, and velocities `(N, 3)` in their frame, m/s, m/s, rad/s, now.

        Of `stamps` `(N,)`, when the poses were measured, s, only long gaps count: a robot that is
        located again after one has not come there within a cycle.
        """
        elapsed = time - self._time
        if len(self._poses) != len(poses) or not 0.0 < elapsed < self._longest:
            velocities = np.zeros_like(poses)
            self._history.clear()
        else:
            states = _predicted(
                self._poses, self._velocities, self._commands, elapsed, self._limits
            )
            seen = poses - self._poses
            seen[:, 2] = wrap_angle(seen[:, 2])
            if stamps is not None and self._stamps is not None:
                seen[stamps - self._stamps > self._longest] = 0.0
            self._history.append((elapsed, seen, states[:, :3] - self._poses))
            span = sum(entry[0] for entry in self._history)
            moved = sum((entry[1] for entry in self._history), np.zeros_like(poses))
            expected = sum((entry[2] for entry in self._history), np.zeros_like(poses))
            agree = np.abs(moved - expected).max(axis=1) < _TRUSTED
            velocities = np.where(agree[:, None], states[:, 3:], moved / span)
        self._poses, self._velocities, self._time = poses.copy(), velocities.copy(), time
        self._stamps = stamps
        return poses, velocities

    def foresees(self, poses: Array, time: float) -> bool:
        """Whether all robots would be about at poses `(N, 3)` at a later time, s."""
        elapsed = time - self._time
        states = _predicted(self._poses, self._velocities, self._commands, elapsed, self._limits)
        return _near(poses, states, _FORESEEN)

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that hold from now on."""
        self._commands = commands.copy()


class StateEstimator:
    """Estimates a team's poses and velocities at the time that a command sent now arrives.

    Attributes:
        max_age: A robot whose last pose is older, s, stays in the estimate where it was then.
    """

    def __init__(self, model: RobotModel, period: float, expected: Imperfections) -> None:
        self.max_age = expected.max_age
        self._limits = limits_of(model)
        self._longest = longest_gap(period)
        self._delay = expected.delay
        place, turn = _gain(expected.position, period), _gain(expected.heading, period)
        self._gain = np.array([place, place, turn])
        deviation = np.array([expected.position, expected.position, expected.heading])
        self._elsewhere = np.maximum(_ELSEWHERE, _OUTLIER * deviation)
        self._foreseen = np.maximum(_FORESEEN, _OUTLIER * deviation)
        self._swift = np.minimum(self._gain**2 / (2.0 - self._gain), _STEADY)
        self._states: Array = np.empty((0, 6))
        self._time = 0.0
        self._reported: Array = np.empty((0, 3))
        self._stamps: Array = np.empty(0)
        # When each command takes effect, in order, and the one in effect now.
        self._coming: deque[tuple[float, Array]] = deque()
        self._current: Array = np.empty((0, 3))

    def update(self, poses: Array, time: float, stamps: Array | None = None) -> tuple[Array, Array]:
        """Poses and velocities `(N, 3)` at `time` and the delay: m and rad, m/s and rad/s.

        `stamps` `(N,)` say when the poses `(N, 3)`, those reported last, were measured, s. Where
        nobody says, a pose that has not changed at all counts as not reported anew, up to the age
        limit.
        """
        elapsed = time - self._time
        old = None if stamps is None else time - stamps > self.max_age + 1e-9
        if len(self._states) != len(poses) or not 0.0 < elapsed < self._longest:
            self._restart(poses, time, stamps)
        else:
            before = self._states
            self._states = self._carried(before, self._time, time, use_up=True)
            self._hold(before, self._states, old)
            self._correct(poses, time, elapsed, stamps)
        self._time = time
        self._reported = poses.copy()
        ahead = self._carried(self._states, time, time + self._delay, use_up=False)
        self._hold(self._states, ahead, old)
        return ahead[:, :3].copy(), ahead[:, 3:].copy()  # without delay it is the estimate itself

    def foresees(self, poses: Array, time: float) -> bool:
        """Whether all robots would be about at poses `(N, 3)` at a later time, s."""
        states = self._carried(self._states, self._time, time, use_up=False)
        return _near(poses, states, self._foreseen)

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that are sent now."""
        self._coming.append((self._time + self._delay, commands.copy()))

    def _restart(self, poses: Array, time: float, stamps: Array | None) -> None:
        self._states = np.column_stack([poses, np.zeros_like(poses)])
        self._stamps = np.full(len(poses), time) if stamps is None else np.array(stamps, float)
        self._coming.clear()
        self._current = np.zeros_like(poses)

    def _carried(self, states: Array, start: float, end: float, use_up: bool) -> Array:
        """States `(N, 6)` at `start` carried on to `end`, s, by the commands that take effect.

        Those that are in the past then are forgotten if `use_up` says so.
        """
        current = self._current
        for due, commands in self._coming:
            if due > end - 1e-9:
                break
            states = self._moved(states, current, due - start)
            start, current = max(start, due), commands
        states = self._moved(states, current, end - start)
        if use_up:
            while self._coming and self._coming[0][0] <= end - 1e-9:
                self._current = self._coming.popleft()[1]
        return states

    @staticmethod
    def _hold(before: Array, states: Array, old: NDArray[np.bool_] | None) -> None:
        """Robots of which nothing has been heard for too long are not carried on blindly."""
        if old is not None and old.any():
            states[old] = before[old]
            states[old, 3:] = 0.0

    def _moved(self, states: Array, commands: Array, elapsed: float) -> Array:
        if elapsed <= 1e-9:
            return states
        poses, velocities = np.ascontiguousarray(states[:, :3]), np.ascontiguousarray(states[:, 3:])
        return _predicted(poses, velocities, commands, elapsed, self._limits)

    def _correct(self, poses: Array, time: float, elapsed: float, stamps: Array | None) -> None:
        states = self._states
        if stamps is None:
            # One that stays where it is longer than reports get lost for does stand there.
            changed = (poses != self._reported).any(axis=1)
            stamps = np.where(changed, time, self._stamps)
            fresh: NDArray[np.bool_] = changed | (time - stamps > self.max_age)
            age = np.zeros(len(poses))
        else:
            fresh = stamps > self._stamps
            age = np.clip(time - stamps, 0.0, self.max_age)
        gathered = np.maximum(stamps - self._stamps, elapsed)  # more than a cycle after losses
        self._stamps = np.array(stamps, float)
        surprise = poses + states[:, 3:] * age[:, None] - states[:, :3]
        surprise[:, 2] = wrap_angle(surprise[:, 2])
        moved = fresh & (np.abs(surprise) > self._elsewhere).any(axis=1)
        states[moved, :3], states[moved, 3:] = poses[moved], 0.0
        surprise[moved | ~fresh] = 0.0
        states[:, :3] += self._gain * surprise
        states[:, 3:] += self._swift * surprise / gathered[:, None]


def _predicted(
    poses: Array, velocities: Array, commands: Array, elapsed: float, limits: MotionLimits
) -> Array:
    """States `(N, 6)` after `elapsed` s of these commands."""
    steps = max(1, int(np.ceil(elapsed / _STEP - 1e-9)))
    return predict_team(poses, velocities, commands, elapsed / steps, steps, limits)


def _near(poses: Array, states: Array, bound: float | Array) -> bool:
    """Whether poses `(N, 3)` are within a bound of those of states `(N, 6)`, m and rad."""
    away = poses - states[:, :3]
    away[:, 2] = wrap_angle(away[:, 2])
    return bool((np.abs(away) < bound).all())


def _gain(deviation: float, period: float) -> float:
    """Share of a report's surprise that a steady filter of a random walk believes."""
    if deviation == 0.0:
        return 1.0
    ratio = _DRIFT * period / deviation
    return 0.5 * ratio * (math.sqrt(ratio * ratio + 4.0) - ratio)
