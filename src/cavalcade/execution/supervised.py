"""A policy under a supervisor, for control loops of one's own."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.execution.control import SoundReports, failing, fitted, tell_sent
from cavalcade.execution.policy import Degradable, Policy
from cavalcade.execution.supervisor import Supervision, Supervisor, SupervisorReport
from cavalcade.fleet import Fault, Observation
from cavalcade.formation import FormationPlanner, Imperfections
from cavalcade.formation.cycle import named
from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel, robot_model
from cavalcade.values import described, instance_of, number_in, plain_number, real_array
from cavalcade.world import OccupancyMap

_FROZEN = 0.1
"""A robot whose pose has not changed in the last digit while it was told to go so far, m, is not
located any more, where nobody says when poses were measured."""

_DOUBTED = 0.02
"""After so much of it nobody says that it has arrived, m."""

_ARM = 0.3
"""Turning counts with this lever, m."""


class SupervisedPlanner(Policy):
    """Lets a policy's commands pass only while nothing is wrong with what it is told.

    Call `step` in the place of the policy's, and send what it returns. From the first fault on
    (see `Supervision`) every command is zero and `report` says why, until `resume` is called and
    all data are good. Set goals, maps and shapes at the policy as before, and lose robots here.

    Args:
        policy: A `FormationPlanner` or another policy.
        supervision: What is allowed.
        models: One model per robot, by name or as a `RobotModel`. A `FormationPlanner` knows this
            and what follows; of other policies it has to be said.
        rate: Cycles per second.
        area: The map that robots have to stay on; None for anywhere.

    Raises:
        InputError: An argument of another kind, or one is missing.
    """

    def __init__(
        self,
        policy: Policy,
        supervision: Supervision | None = None,
        *,
        models: Sequence[RobotModel | str] | None = None,
        rate: float | None = None,
        area: OccupancyMap | None = None,
    ) -> None:
        if not isinstance(policy, Policy):
            raise InputError(f"expected a policy, got {described(policy)}", key="policy")
        given = Supervision() if supervision is None else supervision
        instance_of(given, Supervision, "supervision")
        self._policy = policy
        self._degradable = policy if isinstance(policy, Degradable) else None
        self._own_area = area
        expected = Imperfections()
        if isinstance(policy, FormationPlanner):
            models = [policy.model] * policy.robots if models is None else models
            rate = policy.rate if rate is None else rate
            expected = policy.expected
        if models is None or rate is None:
            missing = "models" if models is None else "rate"
            raise InputError("has to be said of a policy that is no FormationPlanner", key=missing)
        robots = [robot_model(model) for model in models]
        period = 1.0 / number_in(rate, "rate", 0.1, 1000.0, "Hz")
        self._supervisor = Supervisor(
            robots, period, fitted(given, policy, None), self._area, expected
        )
        self._report = SupervisorReport(False, (), ())
        self._halted = self._paused = False
        self._unresponsive: set[int] = set()
        swiftest = max(model.max_speed_x for model in robots)
        self._located = _Located(len(robots), period, _FROZEN + expected.delay * swiftest)
        self._size = len(robots)
        self._sound = SoundReports(self._size)

    @property
    def supervisor(self) -> Supervisor:
        """What judges; any thread may stop the team by it."""
        return self._supervisor

    @property
    def report(self) -> SupervisorReport:
        """Whether the team may move, as of the last cycle and what came since."""
        cause = self._supervisor.cause
        if cause == self._report.cause:
            return self._report
        return replace(self._report, ok=False, cause=cause)

    @property
    def status(self) -> PlannerStatus:
        """The policy's, of its last cycle; `stopped`, with the cause, while the team is stopped.

        It has not arrived while it is stopped, or while poses may be frozen.
        """
        status = self._policy.status
        cause = self._supervisor.cause
        if cause:
            involved = tuple(sorted({f.robot for f in cause if f.robot is not None}))
            message = f"stopped: {self.report.message}; resume when it is over"
            return replace(
                status, state="stopped", arrived=False, involved=involved, message=message
            )
        lost = self._supervisor.lost
        arrived = status.arrived and not self._located.doubted(lost)
        message, involved = status.message, status.involved
        if self._unresponsive and not message:
            involved = tuple(sorted(self._unresponsive))
            message = f"{named(involved)}: no motion as commanded; the others go on"
        state = "paused" if self._paused else status.state
        return replace(status, state=state, arrived=arrived, message=message, involved=involved)

    def step(self, poses: ArrayLike, time: float, stamps: ArrayLike | None = None) -> Array:
        """One cycle.

        Args:
            poses: `(N, 3)` x, y in m and yaw in rad of all robots, as last reported. What is not
                finite is a fault, not an error.
            time: Now, s, by a clock that advances.
            stamps: `(N,)` when each pose was measured, s, by the same clock; None where that is
                not known. Then a pose that stays the same to the last digit while its robot is
                told to go is taken for stale.

        Returns:
            `(N, 3)` body-frame velocities to send, m/s, m/s, rad/s; zeros while stopped.

        Raises:
            InputError: Poses or stamps of the wrong shape. No command must leave then.
        """
        began = clock.perf_counter()
        seen = _rows(poses, "poses", (self._size, 3))
        now = plain_number(time, "time")
        faults: tuple[Fault, ...] = ()
        if stamps is None:
            measured = np.full(self._size, now)
            faults = self._located.faults(seen)
        else:
            measured = _rows(stamps, "stamps", (self._size,))
            self._located.trust()
        supervisor = self._supervisor
        supervisor.area = self._area
        self._report = supervisor.check(Observation(now, seen, measured, faults))
        if self._degradable is not None:
            for robot in self._report.unresponsive:
                self._degradable.lose(robot)
                self._unresponsive.add(robot)
        wanted = np.zeros((self._size, 3))
        if not self._report.ok:
            self._halt()
        elif not self._paused:
            self._go_on()
            wanted = self._wanted(seen, now, measured, stamps is not None)
        commands = supervisor.admit(wanted, clock.perf_counter() - began)
        if self._report.ok:
            tell_sent(self._policy, wanted, commands)
        self._located.commanded(commands)
        return commands

    def stop(self, detail: str = "") -> None:
        """The e-stop: every command is zero until `reset_stop` and `resume`."""
        self._supervisor.stop(detail=detail)

    def reset_stop(self) -> None:
        """Lift the e-stop; the team stands until `resume`."""
        self._supervisor.reset_stop()

    def pause(self) -> None:
        """Stop until `resume`; the goals stay."""
        self._paused = True
        self._halt()

    def resume(self) -> None:
        """Go on after `pause` or a fault, from the next cycle on, if that finds all data good.

        If it does not, the request is dropped: nothing starts by itself later.
        """
        self._paused = False
        if self._supervisor.cause:
            self._supervisor.resume()

    def lose(self, robot: int) -> None:
        """Go on without a robot: it is not commanded, and its poses do not count."""
        self._supervisor.lose(robot)
        if self._degradable is not None:
            self._degradable.lose(robot)

    def rejoin(self, robot: int) -> None:
        """Take a lost robot back."""
        self._supervisor.rejoin(robot)
        self._unresponsive.discard(robot)
        if self._degradable is not None:
            self._degradable.rejoin(robot)

    def close(self) -> None:
        """No command but zero from now on."""
        self._supervisor.close()

    @property
    def _area(self) -> OccupancyMap | None:
        if self._own_area is None and isinstance(self._policy, FormationPlanner):
            return self._policy.map
        return self._own_area

    def _halt(self) -> None:
        if not self._halted:
            self._policy.pause()
            self._halted = True

    def _go_on(self) -> None:
        if self._halted:
            self._policy.resume()
            self._halted = False

    def _wanted(self, poses: Array, now: float, stamps: Array, known: bool) -> Array:
        """The policy's commands; if it fails the team stops."""
        poses, stamps = self._sound.update(poses, stamps)
        with failing(self._supervisor):
            if not known and isinstance(self._policy, FormationPlanner):
                return np.array(self._policy.step(poses, now), dtype=float)
            return np.array(self._policy.step(poses, now, stamps), dtype=float)


class _Located:
    """Tells robots that stand from those that are not located any more, where stamps are missing.

    `allowance` is how far robots may be told to go before it shows, m.
    """

    def __init__(self, robots: int, period: float, allowance: float) -> None:
        self._period = period
        self._allowance = allowance
        self._poses = np.full((robots, 3), np.nan)
        self._told = np.zeros(robots)  # m, since a pose changed last

    def faults(self, poses: Array) -> tuple[Fault, ...]:
        """The robots whose poses `(N, 3)` are frozen."""
        self._told[(poses != self._poses).any(axis=1)] = 0.0
        self._poses = poses.copy()
        frozen = np.flatnonzero(self._told >= self._allowance).tolist()
        return tuple(Fault(robot, "stale", "its pose never changes") for robot in frozen)

    def trust(self) -> None:
        """Stamps are known: they say it."""
        self._told[:] = 0.0

    def commanded(self, commands: Array) -> None:
        """Body-frame commands `(N, 3)` that hold for the next period."""
        speeds = np.hypot(commands[:, 0], commands[:, 1]) + _ARM * np.abs(commands[:, 2])
        self._told += self._period * speeds

    def doubted(self, lost: Sequence[int]) -> bool:
        """Whether somebody who takes part may be elsewhere by now."""
        return bool((np.delete(self._told, lost) >= _DOUBTED).any())


def _rows(values: ArrayLike, key: str, shape: tuple[int, ...]) -> Array:
    """Numbers of a shape as an own array; nan for what is masked."""
    array = np.array(real_array(values, key, f"numbers of shape {shape}"), dtype=float)
    if array.shape != shape:
        raise InputError(f"expected numbers of shape {shape}, got {array.shape}", key=key)
    return array
