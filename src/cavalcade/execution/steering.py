"""A simulated run that somebody watches and changes on its way: pace, pauses and events.

What is changed becomes an event of the scenario at the time of the cycle in which it happens, so
that the same run can be had again from a file.
"""

from __future__ import annotations

import logging
import threading
import time as wall
from typing import Any, Literal

from cavalcade.errors import InputError, ScenarioError
from cavalcade.fleet import Fleet
from cavalcade.scenario import Event, Scenario, scenario_with_event
from cavalcade.values import number_in, whole_number

_LOG = logging.getLogger(__name__)

SPEEDS = (0.1, 10.0)
"""Slowest and fastest pace, simulated seconds per second."""

LATEST = 0.5
"""A run that is late by less catches up, s of the wall's clock."""

TASK_KINDS = ("goals", "formation", "rejoin")
"""Events that give the team something to do."""

Phase = Literal["new", "running", "paused", "waiting", "ended"]


class Steering:
    """Steers one simulated run from other threads.

    Hand it to `cv.run(..., steering=...)`, which may go on in a thread of its own. Where the run
    would end because the team has arrived or is stuck, it waits instead, its clock standing
    still, until an event gives the team something to do, or `finish` ends it.

    Args:
        speed: Simulated seconds per second, see `speed`.
        paused: Whether it begins paused.
    """

    def __init__(self, speed: float | None = 1.0, paused: bool = False) -> None:
        self._lock = threading.Condition()
        self._scenario: Scenario | None = None
        self._fleet: Fleet | None = None
        self._submitted: list[dict[str, Any]] = []
        self._refused: tuple[str, ...] = ()
        self._time = 0.0
        self._steps = 0
        self._paused = paused
        self._finishing = False
        self._phase: Phase = "new"
        self._reason = ""
        self._due: float | None = None
        self.speed = speed

    # From any thread.

    @property
    def phase(self) -> Phase:
        """What the run does: `waiting` where it has come to its end, for now."""
        with self._lock:
            return self._phase

    @property
    def reason(self) -> str:
        """Why the run waits or has ended, as in its summary; empty before."""
        with self._lock:
            return self._reason

    @property
    def time(self) -> float:
        """Of the present cycle, s since the run began."""
        with self._lock:
            return self._time

    @property
    def speed(self) -> float | None:
        """Simulated seconds per second; None is as fast as it can."""
        with self._lock:
            return self._speed

    @speed.setter
    def speed(self, value: float | None) -> None:
        speed = None if value is None else number_in(value, "speed", *SPEEDS)
        with self._lock:
            self._speed = speed
            self._due = None
            self._lock.notify_all()

    @property
    def scenario(self) -> Scenario:
        """The scenario that is run, with all events that have happened.

        Raises:
            InputError: The run has not begun.
        """
        with self._lock:
            if self._scenario is None:
                raise InputError("the run has not begun")
            return self._scenario

    @property
    def fleet(self) -> Fleet | None:
        """The robots, for sinks of the run to look at; None before it begins."""
        with self._lock:
            return self._fleet

    @property
    def pending(self) -> int:
        """How many events wait for a cycle; while the run waits there is none."""
        with self._lock:
            return len(self._submitted)

    @property
    def refused(self) -> tuple[str, ...]:
        """Why events that were submitted could not happen any more when their cycle came."""
        with self._lock:
            return self._refused

    def pause(self) -> None:
        """Stop the clock before the next cycle."""
        with self._lock:
            self._paused, self._steps = True, 0
            self._lock.notify_all()

    def resume(self) -> None:
        """Let the clock run."""
        with self._lock:
            self._paused, self._due = False, None
            self._lock.notify_all()

    def step(self, cycles: int = 1) -> None:
        """Carry out so many cycles, then pause."""
        count = whole_number(cycles, "cycles", 1, 100_000)
        with self._lock:
            self._paused = True
            self._steps += count
            self._lock.notify_all()

    def finish(self) -> None:
        """End the run with the next cycle; its results are kept."""
        with self._lock:
            self._finishing = True
            self._lock.notify_all()

    def submit(self, **event: Any) -> None:
        """Let something happen in the next cycle: one key and value of the file's `events`.

        `submit(goals=[[4.0, 2.0, 0.0]])`, `submit(lose=2)`, `submit(add={"circle": ...})`.

        Raises:
            ScenarioError: It is refused, in the words in which the file would be.
            InputError: The run has not begun, or is over.
        """
        with self._lock:
            if self._phase == "ended":
                raise InputError("the run is over")
            known = self.scenario
            for earlier in self._submitted:
                known, _ = scenario_with_event(known, {"at": self._time, **earlier})
            scenario_with_event(known, {"at": self._time, **event})
            self._submitted.append(event)
            self._lock.notify_all()

    # From the loop.

    def begin(self, scenario: Scenario, fleet: Fleet) -> None:
        """The run of this scenario with these robots begins."""
        with self._lock:
            if self._phase != "new":
                raise InputError("a Steering is for one run", key="steering")
            self._scenario, self._fleet, self._phase = scenario, fleet, "running"

    def turn(self, time: float, period: float) -> tuple[Event, ...]:
        """Wait until the cycle at `time` s is to be carried out, and what is to happen in it."""
        with self._lock:
            self._time = time
            while self._paused and not self._steps and not self._finishing:
                self._phase = "paused"
                self._lock.wait()
            self._phase = "running"
            self._steps = max(self._steps - 1, 0)
            self._keep_pace(period)
            events = []
            for said in self._submitted:
                try:
                    self._scenario, event = scenario_with_event(self.scenario, {"at": time, **said})
                except ScenarioError as error:  # an obstacle that has moved meanwhile, say
                    _LOG.warning("left out at %g s: %s", time, error)
                    self._refused += (error.message,)
                    continue
                events.append(event)
            self._submitted = []
            return tuple(events)

    def goes_on(self, reason: str) -> bool:
        """Whether a run that has come to this end goes on; waits until somebody says so."""
        with self._lock:
            self._reason = reason
            if reason not in ("arrived", "stuck", "infeasible"):
                return False
            while not self._finishing:
                kinds = [kind for said in self._submitted for kind in said]
                if any(kind in TASK_KINDS or reason != "arrived" for kind in kinds):
                    self._reason, self._due = "", None
                    return True
                self._phase = "waiting"
                self._lock.wait()
            return False

    @property
    def finishing(self) -> bool:
        """Whether somebody wants the run to end."""
        with self._lock:
            return self._finishing

    def end(self) -> None:
        """The run is over."""
        with self._lock:
            self._phase = "ended"
            self._lock.notify_all()

    def _keep_pace(self, period: float) -> None:
        """Wait for the wall's clock; who is late by more than a moment does not catch up."""
        while self._speed is not None and not self._finishing:
            now = wall.monotonic()
            if self._due is None or self._due < now - max(period / self._speed, LATEST):
                self._due = now
            left = self._due - now
            if left <= 0.0:
                self._due += period / self._speed
                return
            self._lock.wait(left)
