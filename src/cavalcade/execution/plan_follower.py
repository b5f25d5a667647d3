"""Follows planned trajectories: a planner as the control loop takes it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cavalcade.execution.leaping import LeapScheduler
from cavalcade.execution.policy import Policy
from cavalcade.execution.speed_profile import rounded_headings
from cavalcade.execution.time_scaling import EXACT, FollowSettings, TimeScaling
from cavalcade.fleet import LeapingFleet
from cavalcade.geometry import Array, wrap_angle
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.world import Terrain

POSITION_GAIN = 2.0
"""Velocity per error of the position, 1/s."""

HEADING_GAIN = 3.0
"""Yaw rate per error of the heading, 1/s."""

SIDE_GAIN = 6.0
"""Yaw rate of a unicycle per speed and sideways error, rad/m²."""

LOOK = 0.05
"""Between looks at what a robot has before it, s of plan time."""

_STILL = 1e-9

_STOPPED = 1e-3
"""Progress, s, or a rate: less is none."""

_PATH_SPACING = 10
"""Of the samples of a path, every so-many-th is shown."""


class PlanFollower(Policy):
    """Commands the velocity of the plan, and corrects what is off.

    Each robot has a progress of its own, which is the clock's as long as it keeps up. A robot
    that lags is waited for by those whose turn comes after it, and by nobody else; see
    `cavalcade.execution.precedence` and `time_scaling`.

    The velocity of each cycle is the mean of the plan's until the next one, in the body frame.
    Robots that go in all directions are corrected in all of them; unicycles forwards and by
    turning (Kanayama et al. 1990).

    `refusal` says why there is no plan: nobody moves then, and the status says so. The `leaper` is
    the fleet, if its robots leap by themselves; it is told where `terrain` breaks, and robots with
    limits go more slowly where that is rough.
    """

    def __init__(
        self,
        paths: Sequence[Trajectory | None],
        models: Sequence[RobotModel],
        starts: Sequence[Sequence[float]],
        goals: Sequence[Sequence[float]],
        rate: float,
        refusal: str | None = None,
        settings: FollowSettings = EXACT,
        leaper: LeapingFleet | None = None,
        terrain: Terrain | None = None,
    ) -> None:
        self._paths = [
            _standing(start) if path is None or refusal is not None else path
            for path, start in zip(paths, starts, strict=True)
        ]
        if settings.limits is not None:
            window = settings.limits.window
            self._paths = [rounded_headings(path, window) for path in self._paths]
        self._unicycle = np.array([model.drive.startswith("unicycle") for model in models])
        self._period = 1.0 / rate
        self._refusal = refusal
        self._settings = settings
        self._scaling = TimeScaling(self._paths, models, self._period, settings, terrain)
        self._leaps: LeapScheduler | None = None
        if leaper is not None:
            self._leaps = LeapScheduler(self._paths, leaper, terrain, self._scaling)
        self._quiet = np.zeros(len(self._paths), dtype=bool)
        self._trace: list[tuple[float, Array]] = []
        self._start: float | None = None
        self._targets = np.array(goals, dtype=float).reshape(-1, 3)
        for robot, model in enumerate(models):
            # Where one that goes in all directions looks is of no interest.
            if model.drive.startswith("integrator"):
                self._targets[robot, 2] = self._paths[robot].yaw[-1]
        self._lines = [path.position[::_PATH_SPACING, :2] for path in self._paths]
        self._moments = [path.time[::_PATH_SPACING] for path in self._paths]
        self._errors = np.zeros((len(self._paths), 3))
        self._status = self._status_at(0.0)

    @property
    def status(self) -> PlannerStatus:
        """Of the last cycle."""
        return self._status

    @property
    def progress(self) -> Array:
        """`(N,)` plan times up to which the robots were sent in the last cycle, s."""
        return self._scaling.progress(self._last)

    @property
    def delays(self) -> Array:
        """`(N,)` how much later than planned robots were sent to their ends, s; nan until then."""
        return self._scaling.arrived_late.copy()

    def delays_at(self, times: Array) -> Array:
        """`(K, N)` what each robot was behind the plan at times `(K,)` since the start, s."""
        if not self._trace:
            return np.zeros((len(times), len(self._paths)))
        known = np.array([moment for moment, _ in self._trace])
        rows = np.searchsorted(known, times + 1e-6, side="right") - 1
        return np.stack([delay for _, delay in self._trace])[np.maximum(rows, 0)]

    @property
    def errors(self) -> Array:
        """`(N, 3)` what references were ahead of the robots in the last cycle, map frame."""
        return self._errors.copy()

    @property
    def references(self) -> Array:
        """`(N, 3)` the poses where robots were sent in the last cycle."""
        progress = self.progress
        return np.stack(
            [path.poses_at(progress[k : k + 1])[0] for k, path in enumerate(self._paths)]
        )

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """`(N,)` whether robots were sent as far as they may go since `halt`, or are held."""
        scaling = self._scaling
        there = self.progress >= scaling.caps - _STOPPED
        return np.asarray((there & (scaling.rates <= _STOPPED)) | scaling.held)

    def halt(self) -> Array:
        """Let all robots come to rest along the plan, within their limits and in their order.

        Returns:
            `(N, 3)` the poses where they will stand.
        """
        self._scaling.halt(self._last)
        ends = np.minimum(self._scaling.caps, [path.duration for path in self._paths])
        return np.stack([path.poses_at(ends[k : k + 1])[0] for k, path in enumerate(self._paths)])

    def release(self) -> None:
        """Let them go on after `halt`."""
        self._scaling.caps[:] = math.inf

    def hold(self, robot: int) -> None:
        """Command a robot no more; those whose turn is after it wait."""
        self._scaling.held[robot] = True

    def ahead(self, robot: int) -> tuple[Array, int]:
        """What a robot has before it, from where it was sent last.

        Returns:
            Poses `(K, 3)` every `LOOK` s of plan time up to the goal, and how many of them it
            passes at least until it has braked.
        """
        path, scaling = self._paths[robot], self._scaling
        begin = float(scaling.progress(self._last)[robot])
        poses = path.poses_at(np.arange(begin, max(path.duration, begin) + LOOK, LOOK))
        return poses, math.ceil(scaling.stopping[robot] / LOOK) + 1

    def step(self, poses: Array, time: float, stamps: Array) -> Array:
        """Poses `(N, 3)` and their times `(N,)` in, body-frame velocities `(N, 3)` out."""
        if self._start is None:
            self._start = time
        now = time - self._start
        commands = np.zeros((len(poses), 3))
        if self._refusal is not None:
            self._status = self._status_at(now)
            return commands
        scaling = self._scaling
        scaling.begin(now)
        ages = now - (stamps - self._start)
        if self._leaps is not None:
            self._leaps.step(now, poses)
        seen = scaling.progress(now) - scaling.rates * ages
        errors = (
            np.stack([path.poses_at(seen[k : k + 1])[0] for k, path in enumerate(self._paths)])
            - poses
        )
        errors[:, 2] = wrap_angle(errors[:, 2])
        self._errors = errors
        scaling.decide(now, ages, errors, poses)
        if self._leaps is not None:
            self._leaps.hand_over(now)
        self._status = self._status_at(now)
        self._trace.append((now, scaling.delay.copy()))
        progress = scaling.progress(now)
        for robot in np.flatnonzero(~scaling.held).tolist():
            marks = progress[robot] + np.array([0.0, scaling.rates[robot] * self._period])
            here, there = self._paths[robot].poses_at(marks)
            commands[robot] = self._command(robot, here, there, errors[robot], poses[robot, 2])
        return commands

    @property
    def _last(self) -> float:
        """The time of the last cycle, s since the first one."""
        return self._trace[-1][0] if self._trace else 0.0

    def _command(
        self, robot: int, here: Array, there: Array, error: Array, heading: float
    ) -> Array:
        """Body-frame velocity from one planned pose to the next, with what corrects the error."""
        rate = (there - here) / self._period
        if self._rests(robot, rate, error):
            return np.zeros(3)
        wanted = _bounded(POSITION_GAIN * error[:2], self._settings.correction)
        most = self._settings.correction_turn
        if self._unicycle[robot]:
            return _unicycle(rate, wanted, error, heading, 0.5 * (here[2] + there[2]), most)
        return _free(rate, wanted, error, heading, self._period, most)

    def _rests(self, robot: int, rate: Array, error: Array) -> bool:
        """Whether the robot is to stand and is near enough to where."""
        standing = bool(np.abs(rate).max() < _STILL)
        which = 1 if self._quiet[robot] else 0
        far, turned = self._settings.quiet[which], self._settings.quiet_heading[which]
        near = math.hypot(error[0], error[1]) < far and abs(error[2]) < turned
        self._quiet[robot] = standing and near
        return bool(self._quiet[robot])

    def _status_at(self, now: float) -> PlannerStatus:
        progress = self._scaling.progress(now)
        left = np.array(
            [max(path.duration - s, 0.0) for path, s in zip(self._paths, progress, strict=True)]
        )
        state, message = "final", ""
        involved: tuple[int, ...] = ()
        if self._refusal is not None:
            state, message = "infeasible", self._refusal
        elif self._leaps is not None and self._leaps.trouble is not None:
            state = "stuck"
            message, involved = self._leaps.trouble
        return PlannerStatus(
            state=state,
            roles=np.arange(len(self._paths)),
            goals=self._targets[:, :2],
            paths=tuple(
                line[int(np.searchsorted(moments, s)) :]
                for line, moments, s in zip(self._lines, self._moments, progress, strict=True)
            ),
            eta=left,
            arrived=bool((left <= 0.0).all()) and self._refusal is None,
            involved=involved,
            message=message,
            targets=self._targets,
        )


def _bounded(vector: Array, most: float) -> Array:
    """The vector, shortened to this length if it is longer."""
    length = math.hypot(vector[0], vector[1])
    return vector if length <= most else vector * (most / length)


def _free(
    rate: Array, wanted: Array, error: Array, heading: float, period: float, most: float
) -> Array:
    """Command of a robot that goes in all directions, for its heading in mid-period."""
    turn = rate[2] + min(max(HEADING_GAIN * error[2], -most), most)
    x, y = rate[:2] + wanted
    middle = heading + 0.5 * turn * period
    c, s = np.cos(middle), np.sin(middle)
    return np.array([c * x + s * y, c * y - s * x, turn])


def _unicycle(
    rate: Array, wanted: Array, error: Array, heading: float, planned: float, most: float
) -> Array:
    """Command of a robot that goes forwards, backwards and turns."""
    speed = float(np.cos(planned) * rate[0] + np.sin(planned) * rate[1])
    c, s = np.cos(heading), np.sin(heading)
    aside = c * error[1] - s * error[0]
    forwards = speed * np.cos(error[2]) + c * wanted[0] + s * wanted[1]
    correction = SIDE_GAIN * speed * aside + HEADING_GAIN * np.sin(error[2])
    return np.array([forwards, 0.0, rate[2] + min(max(correction, -most), most)])


def _standing(pose: Sequence[float]) -> Trajectory:
    """A robot that stays where it is."""
    x, y, yaw = pose
    return Trajectory(
        np.zeros(1), np.array([[x, y, 0.0]]), np.zeros((1, 3)), np.array([yaw]),
        np.zeros(1, dtype=np.int8),
    )  # fmt: skip
