"""One control cycle: observe, supervise, decide, command. Usable with any fleet and any policy."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cavalcade.execution.guard import CommandGuard
from cavalcade.execution.policy import Degradable, Policy
from cavalcade.execution.statistics import CycleStatistics
from cavalcade.execution.supervisor import Supervision, Supervisor, SupervisorReport
from cavalcade.fleet import Fleet, LeapingFleet, LiveFleet, Observation
from cavalcade.formation import FormationPlanner
from cavalcade.geometry import Array


@dataclass(frozen=True)
class Cycle:
    """What one cycle saw and decided.

    Attributes:
        observation: What the fleet reported.
        report: What the supervisor made of it.
        commands: `(N, 3)` body-frame velocities to send, as the supervisor admits them.
        planning: Time spent in the policy, s of wall time.
    """

    observation: Observation
    report: SupervisorReport
    commands: Array
    planning: float


class ControlLoop:
    """Runs policy and supervisor over a fleet.

    Use it as a context: however it is left, the last command that the fleet gets is zero.

    While the supervisor objects, every robot is commanded to stop in the very cycle in which the
    fault is seen, and the policy is paused. `resume` lets the team go on, from the next cycle
    in which all data are fresh. Live fleets, which wait for nobody, get a guard beside the
    planner's thread, a deadline for each cycle, and figures of how well it was kept.

    One thread runs `plan` and `send`; any thread may call the other methods.
    """

    def __init__(self, policy: Policy, fleet: Fleet, supervisor: Supervisor) -> None:
        self.policy = policy
        self.fleet = fleet
        self.supervisor = supervisor
        self.statistics = CycleStatistics(supervisor.period)
        self._guard: CommandGuard | None = None
        deadline: float | None = None
        if isinstance(fleet, LiveFleet):
            deadline = supervisor.period
            self._guard = CommandGuard(fleet, supervisor, supervisor.period)
        supervisor.supervision = fitted(supervisor.supervision, policy, deadline)
        # Looked up once: it takes longer than a robot's part of a cycle.
        self._leaper = fleet if isinstance(fleet, LeapingFleet) else None
        self._paused = False
        self._sound = SoundReports(fleet.size)

    @property
    def policy(self) -> Policy:
        """What decides; another one may be set between cycles."""
        return self._policy

    @policy.setter
    def policy(self, policy: Policy) -> None:
        self._policy = policy
        # Asked once and not in each cycle: it takes as long as a small kernel.
        self._degradable = policy if isinstance(policy, Degradable) else None

    def __enter__(self) -> Self:
        if self._guard is not None:
            self._guard.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def plan(self) -> Cycle:
        """Observe and decide; nothing is sent yet."""
        observation = self.fleet.observe()
        if self._guard is not None:
            self._guard.begin(observation.time)
        busy: Sequence[int] = ()
        if self._leaper is not None:
            busy = np.flatnonzero(self._leaper.leaping).tolist()
        report = self.supervisor.check(observation, busy)
        if self._degradable is not None:
            for robot in report.unresponsive:
                self._degradable.lose(robot)
        wanted = np.zeros((self.fleet.size, 3))
        planning = 0.0
        if report.ok:
            if self._paused:
                self.policy.resume()
                self._paused = False
            poses, stamps = self._sound.update(observation.poses, observation.stamps)
            start = time.perf_counter()
            with failing(self.supervisor):
                wanted = np.array(self.policy.step(poses, observation.time, stamps), dtype=float)
            planning = time.perf_counter() - start
        elif not self._paused:
            self.policy.pause()
            self._paused = True
        took = self.fleet.time - observation.time  # nothing in simulated time
        commands = self.supervisor.admit(wanted, took)
        if report.ok:
            tell_sent(self.policy, wanted, commands)
        return Cycle(observation, report, commands, planning)

    def send(self, commands: Array, cycle: Cycle | None = None) -> Array:
        """Command the fleet; nothing but zeros leaves if something happened since `plan`.

        Args:
            commands: `(N, 3)`, as the supervisor admitted them.
            cycle: That they come from, for the figures of live fleets.

        Returns:
            What was sent.
        """
        if self._guard is None:
            sent = self.supervisor.gate(commands)
            self.fleet.send(sent)
            return sent
        sent = self._guard.send(commands)
        if cycle is not None:
            seen, now = cycle.observation, self.fleet.time
            stamps = np.delete(seen.stamps, self.supervisor.lost)
            age = now - float(stamps.min()) if len(stamps) else np.nan
            self.statistics.add(seen.time, now - seen.time, age)
        return sent

    def stop(self, detail: str = "") -> None:
        """The e-stop: zeros leave at once, and nothing else until `reset_stop` and `resume`."""
        self.supervisor.stop(detail=detail)
        self._send_zeros()

    def reset_stop(self) -> None:
        """Lift the e-stop; the team stands until `resume`."""
        self.supervisor.reset_stop()

    def resume(self) -> None:
        """Let the team move again after a fault, as soon as the next cycle finds none."""
        self.supervisor.resume()

    def lose(self, robot: int) -> None:
        """The robot is known to be lost: no fault, no commands, and the others go on."""
        self.supervisor.lose(robot)
        if self._degradable is not None:
            self._degradable.lose(robot)

    def rejoin(self, robot: int) -> None:
        """The robot is back."""
        self.supervisor.rejoin(robot)
        if self._degradable is not None:
            self._degradable.rejoin(robot)

    def close(self) -> None:
        """Command every robot to stop, for good; a second call does the same again."""
        self.supervisor.close()
        try:
            if self._guard is not None:
                self._guard.close()
        finally:
            self._send_zeros()

    def _send_zeros(self) -> None:
        zeros = np.zeros((self.fleet.size, 3))
        if self._guard is None:
            self.fleet.send(zeros)
        else:
            self._guard.send(zeros)


class SoundReports:
    """The last poses and stamps of a team that were numbers, where lost robots report others."""

    def __init__(self, size: int) -> None:
        self._known = np.zeros((size, 3)), np.zeros(size)

    def update(self, poses: Array, stamps: Array) -> tuple[Array, Array]:
        """Poses `(N, 3)` and stamps `(N,)` as planners may have them, as own arrays."""
        good = np.isfinite(poses).all(axis=1) & np.isfinite(stamps)
        self._known = (
            np.where(good[:, None], poses, self._known[0]),
            np.where(good, stamps, self._known[1]),
        )
        return self._known[0].copy(), self._known[1].copy()


@contextmanager
def failing(supervisor: Supervisor) -> Iterator[None]:
    """Stop the team if the planner raises something."""
    try:
        yield
    except BaseException as error:
        supervisor.stop("planner", type(error).__name__)
        raise


def tell_sent(policy: Policy, wanted: Array, admitted: Array) -> None:
    """Let a planner that reckons with its commands know what became of them."""
    if isinstance(policy, FormationPlanner) and not np.array_equal(wanted, admitted):
        policy.commanded(admitted)


def fitted(supervision: Supervision, policy: Policy, deadline: float | None) -> Supervision:
    """What is allowed with this policy: there is one age limit, and who can do without whom.

    `deadline` holds where the supervision names none.
    """
    if isinstance(policy, FormationPlanner):
        policy.limit_age(supervision.max_age)
    unresponsive = supervision.unresponsive if isinstance(policy, Degradable) else "stop"
    if supervision.deadline is not None:
        deadline = supervision.deadline
    return replace(supervision, unresponsive=unresponsive, deadline=deadline)
