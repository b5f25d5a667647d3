"""One control cycle: observe, watch, decide, command. Usable with any fleet and any policy."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Self

import numpy as np

from cavalcade.execution.policy import Policy, Reconfigurable
from cavalcade.fleet import Fleet, Observation, Watchdog, WatchdogReport
from cavalcade.geometry import Array


@dataclass(frozen=True)
class Cycle:
    """What one cycle saw and decided.

    Attributes:
        observation: What the fleet reported.
        report: What the watchdog made of it.
        commands: `(N, 3)` body-frame velocities to send.
        planning: Time spent in the policy, s of wall time.
    """

    observation: Observation
    report: WatchdogReport
    commands: Array
    planning: float


class ControlLoop:
    """Runs policy and watchdog over a fleet.

    Use it as a context: however it is left, the last command that the fleet gets is zero.

    While the watchdog objects, every robot is commanded to stop in the very cycle in which the
    fault is seen, and the policy is paused. `resume` lets the team go on, from the next cycle
    in which all data are fresh.
    """

    def __init__(self, policy: Policy, fleet: Fleet, watchdog: Watchdog) -> None:
        self.policy = policy
        self.fleet = fleet
        self.watchdog = watchdog
        self._paused = False
        self._known: tuple[Array, Array] | None = None
        self._lost = np.zeros(fleet.size, dtype=bool)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def plan(self) -> Cycle:
        """Observe and decide; nothing is sent yet."""
        observation = self.fleet.observe()
        report = self.watchdog.check(observation)
        commands = np.zeros((self.fleet.size, 3))
        planning = 0.0
        if report.ok:
            if self._paused:
                self.policy.resume()
                self._paused = False
            poses, stamps = self._usable(observation)
            start = time.perf_counter()
            wanted = self.policy.step(poses, observation.time, stamps)
            commands = np.array(wanted, dtype=float)
            planning = time.perf_counter() - start
            commands[self._lost] = 0.0
        elif not self._paused:
            self.policy.pause()
            self._paused = True
        return Cycle(observation, report, commands, planning)

    def send(self, commands: Array) -> None:
        """Command the fleet."""
        self.fleet.send(commands)

    def stop(self) -> None:
        """Command every robot to stop."""
        self.fleet.send(np.zeros((self.fleet.size, 3)))

    def resume(self) -> None:
        """Let the team move again after a fault, as soon as the next cycle finds none."""
        self.watchdog.resume()

    def lose(self, robot: int) -> None:
        """The robot is known to be lost: no fault, no commands, and the others go on."""
        self._lost[robot] = True
        self.watchdog.lose(robot)
        if isinstance(self.policy, Reconfigurable):
            self.policy.lose(robot)

    def rejoin(self, robot: int) -> None:
        """The robot is back."""
        self._lost[robot] = False
        self.watchdog.rejoin(robot)
        if isinstance(self.policy, Reconfigurable):
            self.policy.rejoin(robot)

    def _usable(self, observation: Observation) -> tuple[Array, Array]:
        """Poses and stamps; where a lost robot reports nonsense, those of its last sound report."""
        poses, stamps = observation.poses, observation.stamps
        sound = np.isfinite(poses).all(axis=1) & np.isfinite(stamps)
        known = self._known or (np.zeros_like(poses), np.zeros_like(stamps))
        self._known = (
            np.where(sound[:, None], poses, known[0]),
            np.where(sound, stamps, known[1]),
        )
        return self._known[0].copy(), self._known[1].copy()
