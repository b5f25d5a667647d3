"""How far each robot has come in a plan, and how fast it may go on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.execution._precedence import Braking, Progress
from cavalcade.execution.precedence import Precedence, reach_of
from cavalcade.execution.speed_profile import GRAIN, LegLimits, rate_profile
from cavalcade.geometry import Array, wrap_angle
from cavalcade.geometry.trajectory import FLIGHT, Trajectory
from cavalcade.robots import RobotModel
from cavalcade.world import Terrain

ON_TRACK = 0.05
"""A robot is where its reference is if no point of its body is farther off, m."""

_LOOK = 0.025  # step along the plan when looking for where a robot is, s
_HARD = 2.5  # what was not foreseen is braked for this many times as hard as the rest
_BRAKES = (0.5, 4.0)  # least and largest change of a rate, 1/s
_SLOW = 0.05  # a reference slower than this is waiting for its robot, m/s

_STILL = 1e-9


@dataclass(frozen=True)
class FollowSettings:
    """How robots that lag are waited for.

    Attributes:
        in_order: Whether each robot has a pace of its own and the order in which robots pass is
            kept; otherwise all follow the clock, come what may.
        trust: Whether robots that the plan keeps close may rely on each other to stop no faster
            than they do themselves. Otherwise each keeps the distance that it needs to stop.
        lag: Tracking errors between which the rate of progress falls from 1 to 0, m.
        lag_heading: The same of the heading, rad.
        correction: Largest velocity that corrects the position, m/s.
        correction_turn: Largest that corrects the heading, rad/s.
        quiet: Where a robot is to stand, nothing is corrected once it is within the first of
            these distances until it is beyond the second, m; so that legs may stand still.
        quiet_heading: The same of the heading, rad.
        limits: Of legs; None for robots that go as planned.
    """

    in_order: bool = True
    trust: bool = False
    lag: tuple[float, float] = (0.10, 0.25)
    lag_heading: tuple[float, float] = (0.15, 0.30)
    correction: float = 0.3
    correction_turn: float = 0.6
    quiet: tuple[float, float] = (0.01, 0.03)
    quiet_heading: tuple[float, float] = (0.0175, 0.05)
    limits: LegLimits | None = None


EXACT = FollowSettings(trust=True, quiet=(0.0, 0.0), quiet_heading=(0.0, 0.0))
"""For robots that do what they are told, and have nothing against small corrections."""

WALKING = FollowSettings(limits=LegLimits())
"""For robots on legs."""


class TimeScaling:
    """The progress of each robot: plan time minus what it is late by.

    A rate of 1 is the plan's own pace. Rates change no faster than robots brake, come down before
    a place where it is not the robot's turn (`Precedence`), and where the robot is behind its
    reference. What a robot has surely left behind is judged by where it was seen, not by where it
    was sent. Robots that are late leave out what the plan lets them stand for, if it is their
    turn. Over rough `terrain` robots with `limits` go more slowly.
    """

    def __init__(
        self,
        paths: Sequence[Trajectory],
        models: Sequence[RobotModel],
        period: float,
        settings: FollowSettings,
        terrain: Terrain | None = None,
    ) -> None:
        self._paths = paths
        self.period = period
        self._settings = settings
        self._reach = np.array([reach_of(model) for model in models])
        self._unicycle = np.array([model.drive.startswith("unicycle") for model in models])
        self._rests = [_rests(path) for path in paths]
        self._ends = np.array([path.duration for path in paths])
        brake = _brake(paths, models)
        self._braking = Braking(period, brake, settings.trust)
        self._models = models
        self._stop = 2.0 * period + 0.5 / brake
        self._bare: Precedence | None = None
        size = len(paths)
        limits = settings.limits
        self._profiles = [
            np.ones(1) if limits is None else rate_profile(path, limits, brake, terrain)
            for path in paths
        ]
        self.delay = np.zeros(size)
        self.rates = np.array([profile[0] for profile in self._profiles])
        self.sure = np.zeros(size)
        self.caps = np.full(size, math.inf)
        self.held = np.zeros(size, dtype=bool)
        self.arrived_late = np.full(size, np.nan)
        self.precedence: Precedence | None = None
        if settings.in_order:
            self.precedence = Precedence(paths, models, self._stop)
        self._last: float | None = None

    def progress(self, now: float) -> Array:
        """`(N,)` plan times of the references, s."""
        return np.asarray(now - self.delay)

    def bounds(self, margin: bool = True) -> Array:
        """`(N,)` plan times beyond which nobody may go while nobody else moves on, s.

        Without `margin` bodies only do not touch.
        """
        if self.precedence is None:
            return np.full(len(self._paths), math.inf)
        if margin:
            return self.precedence.bounds(self.sure)
        if self._bare is None:
            self._bare = Precedence(self._paths, self._models, self._stop, margin=0.0)
        return self._bare.bounds(self.sure)

    def begin(self, now: float) -> None:
        """The progress since the last cycle; time in which nobody was commanded is no progress."""
        if self._last is not None and self.precedence is not None:
            elapsed = now - self._last
            counted = min(elapsed, 1.5 * self.period)
            self.delay += (1.0 - self.rates) * counted
            if elapsed > counted:
                self.delay += elapsed - counted
                self.rates[:] = 0.0
        self._last = now

    def decide(self, now: float, ages: Array, errors: Array, poses: Array) -> None:
        """Set the rates until the next cycle, `now` s after the start.

        `poses` `(N, 3)` were seen `ages` `(N,)` s ago; `errors` `(N, 3)`, map frame, are what the
        references were ahead of them then.
        """
        if self.precedence is None:
            return
        seen = self.progress(now) - self.rates * ages
        off = np.hypot(errors[:, 0], errors[:, 1]) + self._reach * np.abs(errors[:, 2])
        for robot in np.flatnonzero(~self.held).tolist():
            self.sure[robot] = self._left_behind(robot, off[robot], seen[robot], poses[robot])
        self._skip_rests(now)
        progress = self.progress(now)
        behind = self._behind(errors, poses)
        turned = _ramp(np.abs(errors[:, 2]), self._settings.lag_heading)
        wanted = np.minimum(_ramp(behind, self._settings.lag), turned)
        wanted = np.minimum(wanted, self._profile_rates(progress))
        change = self._braking.deceleration * self.period
        wanted = np.clip(wanted, np.maximum(self.rates - change, 0.0), self.rates + change)
        wanted[self.held] = 0.0
        lowest = np.where(self.held, 0.0, np.maximum(self.rates - _HARD * change, 0.0))
        state = Progress(progress, self.sure, self.caps, lowest)
        self.rates = self.precedence.rates(state, wanted, self._braking)
        late = np.isnan(self.arrived_late) & (progress >= self._ends - _STILL)
        self.arrived_late[late] = self.delay[late]

    @property
    def stopping(self) -> Array:
        """`(N,)` plan time that passes until robots stand that brake after this cycle, s."""
        rates = self.rates
        return np.asarray(rates * self.period + 0.5 * rates * rates / self._braking.deceleration)

    def halt(self, now: float) -> None:
        """Let all come to rest as soon as they can brake; `caps` say where.

        They keep their order on the way, as each could stop there in any case.
        """
        self.caps = np.minimum(self.caps, self.progress(now) + self.stopping)

    def go_on(self, robot: int, now: float, moment: float) -> None:
        """A robot that was held is at this plan time and stands."""
        self.held[robot] = False
        self.delay[robot] = now - moment
        self.sure[robot] = moment
        self.rates[robot] = 0.0

    def _left_behind(self, robot: int, off: float, seen: float, pose: Array) -> float:
        """The plan time that the robot has reached; the reference's if it is there."""
        sure = float(self.sure[robot])
        moments = np.append(np.arange(sure, seen, _LOOK), max(seen, sure))
        if off <= ON_TRACK and (self._settings.trust or self._slow(robot, float(seen))):
            return float(moments[-1])
        away = self._paths[robot].poses_at(moments) - pose
        turn = np.abs(wrap_angle(away[:, 2]))
        far = np.hypot(away[:, 0], away[:, 1]) + self._reach[robot] * turn
        # The first place of several, but the end of a rest that is spent there.
        nearest = int(np.argmin(far))
        while nearest + 1 < len(far) and far[nearest + 1] <= far[nearest] + _STILL:
            nearest += 1
        return float(moments[nearest])

    def _slow(self, robot: int, seen: float) -> bool:
        """Whether the reference all but stands."""
        marks = seen + np.array([0.0, self.rates[robot] * self.period])
        here, there = self._paths[robot].poses_at(marks)
        moved = math.hypot(*(there - here)[:2]) + self._reach[robot] * abs(there[2] - here[2])
        return bool(moved <= _SLOW * self.period)

    def _profile_rates(self, progress: Array) -> Array:
        """`(N,)` the rates of the robots' profiles there."""
        return np.array(
            [
                profile[min(max(int(at / GRAIN), 0), len(profile) - 1)]
                for profile, at in zip(self._profiles, progress, strict=True)
            ]
        )

    def _skip_rests(self, now: float) -> None:
        late = (self.delay > _STILL) & ~self.held
        if not late.any():
            return
        bounds = np.minimum(self.bounds(), self.caps)
        for robot in np.flatnonzero(late).tolist():
            here = now - self.delay[robot]
            for start, end in self._rests[robot]:
                if start - _STILL <= here < end and self.sure[robot] >= start - _STILL:
                    there = min(end, now, bounds[robot])
                    if there > here:
                        if np.isnan(self.arrived_late[robot]) and end == math.inf:
                            self.arrived_late[robot] = self.delay[robot]
                        self.delay[robot] = max(now - there, 0.0)
                        self.sure[robot] = max(self.sure[robot], there)
                    break

    def _behind(self, errors: Array, poses: Array) -> Array:
        """`(N,)` m; of unicycles what they can make up for, which is straight ahead."""
        ahead = np.cos(poses[:, 2]) * errors[:, 0] + np.sin(poses[:, 2]) * errors[:, 1]
        whole = np.hypot(errors[:, 0], errors[:, 1])
        return np.asarray(np.where(self._unicycle, np.maximum(ahead, 0.0), whole))


def _ramp(value: Array, limits: tuple[float, float]) -> Array:
    """1 up to the first limit, 0 from the second on."""
    low, high = limits
    return np.clip((high - value) / (high - low), 0.0, 1.0)


def _brake(paths: Sequence[Trajectory], models: Sequence[RobotModel]) -> float:
    """Change of a rate per s that all robots manage at the largest speed of their plans."""
    brakes = [_BRAKES[1]]
    for path, model in zip(paths, models, strict=True):
        walking = path.velocity[path.phase != FLIGHT, :2]
        speed = float(np.hypot(walking[:, 0], walking[:, 1]).max(initial=0.0))
        legs = model.legs if model.drive == "legged" else None
        limit = model.max_acceleration if legs is None else legs.acceleration
        brakes.append(limit / max(speed, 1e-6))
    return min(max(min(brakes), _BRAKES[0]), _BRAKES[1])


def _rests(path: Trajectory) -> list[tuple[float, float]]:
    """When the plan lets a robot stand, from, to; the last time for good."""
    still = (np.abs(np.diff(path.position, axis=0)) <= _STILL).all(axis=1)
    still &= np.abs(np.diff(path.yaw)) <= _STILL
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still, [1, 0]]).astype(np.int8)))
    rests = [(float(path.time[a]), float(path.time[min(b, len(path.time) - 1)]))
             for a, b in zip(edges[::2], edges[1::2], strict=True)]  # fmt: skip
    return [*rests[:-1], (rests[-1][0], math.inf)]
