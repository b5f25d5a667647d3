"""Robots in a thread of their own that do what they are told, with faults on purpose."""

from __future__ import annotations

import threading
import time as wall

import numpy as np

from cavalcade.fleet import Observation
from cavalcade.fleet.schedule import Schedule


class FakeFleet:
    """A `LiveFleet` of integrators that keeps what it was sent.

    `speed` is how much faster its time goes than the wall's.
    """

    def __init__(self, starts, speed: float = 2.0) -> None:
        self._poses = np.array(starts, dtype=float)
        self._command = np.zeros_like(self._poses)
        self._begin, self._speed = wall.monotonic(), speed
        self._lock = threading.Lock()
        self._moved = 0.0
        self._schedule = Schedule()
        self.sent: list[tuple[float, np.ndarray]] = []
        self.closed = False
        self.frozen: set[int] = set()
        self.garbled: set[int] = set()
        self.silent: dict[int, float] = {}
        self.faults: tuple = ()
        self.deaf: set[int] = set()
        self.break_observe: Exception | None = None

    @property
    def size(self) -> int:
        return len(self._poses)

    @property
    def time(self) -> float:
        return self._speed * (wall.monotonic() - self._begin)

    def start(self, timeout: float) -> None:
        return

    def close(self) -> None:
        self.send(np.zeros((self.size, 3)))
        self.closed = True

    def observe(self) -> Observation:
        if self.break_observe is not None:
            raise self.break_observe
        with self._lock:
            self._go_on()
            now, poses = self.time, self._poses.copy()
        stamps = np.full(self.size, now - 0.01)
        for robot in self.garbled:
            poses[robot] = np.nan
        for robot, since in self.silent.items():
            stamps[robot] = since
        return Observation(now, poses, stamps, self.faults)

    def send(self, commands) -> None:
        with self._lock:
            self._go_on()
            self._command = np.array(commands, dtype=float)
            for robot in self.deaf:
                self._command[robot] = 0.0
            self.sent.append((self.time, np.array(commands, dtype=float)))

    def advance(self, dt: float) -> None:
        self._schedule.wait(dt, lambda: self.time)

    def true_poses(self):
        with self._lock:
            self._go_on()
            return self._poses.copy()

    def true_velocities(self):
        with self._lock:
            return self._command.copy()

    def _go_on(self) -> None:
        now = self.time
        dt, self._moved = now - self._moved, now
        x, y, turn = self._command.T
        c, s = np.cos(self._poses[:, 2]), np.sin(self._poses[:, 2])
        self._poses += dt * np.column_stack([c * x - s * y, s * x + c * y, turn])


def until(condition, limit: float = 30.0) -> None:
    """Wait until it holds; the limit of the wall's time is generous."""
    end = wall.monotonic() + limit
    while not condition():
        assert wall.monotonic() < end, "it did not come to that"
        wall.sleep(0.01)
