"""Stops live robots when whoever plans for them does not deliver, or their clock fails."""

from __future__ import annotations

import logging
import time
from threading import Event, Lock, Thread, current_thread

import numpy as np

from cavalcade.execution.supervisor import Supervisor, leap
from cavalcade.fleet import LiveFleet
from cavalcade.geometry import Array

_LOG = logging.getLogger(__name__)


class CommandGuard:
    """A thread beside the planner's through which commands leave; it sends zeros when they don't.

    A cycle that has delivered no command two deadlines after it began, or was to begin, stops the
    team (`deadline`), and zeros leave again and again until commands come; those are zero, too,
    until an operator resumes. The same for a clock that is set, or stands still for longer than
    the age limit, and for a planner's thread that ends without a word. If the guard itself fails
    the team has stopped for good.

    Args:
        fleet: Where commands go.
        supervisor: Told what is wrong; its gate stands before every command.
        period: Of the control cycle, in the fleet's time, s.
    """

    def __init__(self, fleet: LiveFleet, supervisor: Supervisor, period: float) -> None:
        self._fleet = fleet
        self._supervisor = supervisor
        self._period = period
        self._lock = Lock()  # held while a command leaves, so that no late one follows zeros
        self._end = Event()
        self._due: float | None = None
        self._planner = current_thread()
        # No daemon: it ends with the planner's thread, and with zeros.
        self._thread = Thread(target=self._watch, name="cavalcade-guard")

    def start(self) -> None:
        """Begin to watch; the first cycle may take its time."""
        self._thread.start()

    def begin(self, now: float) -> None:
        """A cycle begins at `now` s of the fleet's clock, in the thread that calls."""
        self._planner = current_thread()
        self._due = now + 2.0 * (self._supervisor.supervision.deadline or self._period)

    def send(self, commands: Array) -> Array:
        """Send admitted commands `(N, 3)` as far as nothing has happened since; what was sent."""
        with self._lock:
            sent = self._supervisor.gate(commands)
            self._fleet.send(sent)
            if self._due is not None:  # not before the first cycle
                # The next one begins a period after this one did, and has as long.
                self._due += self._period
        return sent

    def close(self) -> None:
        """End the watch; the last that the thread does is to send zeros."""
        self._end.set()
        if self._thread.ident is not None:
            self._thread.join()

    def _watch(self) -> None:
        try:
            self._watch_until_end()
        except Exception as error:
            _LOG.exception("the guard of the team has failed")
            self._supervisor.stop("guard", f"{type(error).__name__}: {error}")
            self._supervisor.close()  # nobody is driven without
        finally:
            self._send_zeros()

    def _watch_until_end(self) -> None:
        last, since = self._fleet.time, time.monotonic()
        while not self._end.wait(0.25 * self._period):
            if not self._planner.is_alive():
                self._supervisor.stop("planner", "its thread has ended")
                return
            now, wall = self._fleet.time, time.monotonic()
            if now < last - 1e-9:
                self._supervisor.stop("clock-back", f"by {last - now:.3g} s")
                with self._lock:
                    self._due = None
            still = wall - since > self._supervisor.supervision.max_age and now <= last
            if still:
                self._supervisor.stop("clock-still", f"at {now:.3f} s")
            due = self._due
            late = due is not None and now > due
            if late:
                leapt = leap(now - last, wall - since, self._supervisor.supervision)
                if leapt:
                    self._supervisor.stop("clock-forward", f"by {leapt:.3g} s")
                else:
                    self._supervisor.stop("deadline", "no commands came in time")
            if now != last:
                last, since = now, wall
            if still or late:
                self._send_zeros()

    def _send_zeros(self) -> None:
        with self._lock:
            self._fleet.send(np.zeros((self._fleet.size, 3)))
