"""Trials on a cluster: Ray actors, one per core, each a process that carries trials out.

A job is given only to an actor that has answered, so its time counts from its start, and only it
is lost with its process or its node. An actor that is gone is replaced as soon as the cluster has
room for another; until then the others go on.
"""

from __future__ import annotations

import os
import socket
import time as clock
from dataclasses import dataclass
from typing import Any, Self

from cavalcade.campaign.engines.protocol import Ended, Work, use_one_thread
from cavalcade.errors import CavalcadeError, InputError

_STILLBORN = 10
"""So many processes may die one after the other before any of them answers."""

_CONNECTING = 10.0
"""How long a cluster may take to accept a connection, s."""

_ANSWER = 0.5
"""Ray is asked for results at least this often while deadlines run, s."""


class ClusterError(CavalcadeError):
    """The cluster cannot be reached, or its nodes cannot carry trials out."""


@dataclass
class _Seat:
    """One actor with what it does.

    `answer` is what is waited for: its first sign of life, then the result of its job. The job's
    `key` is None before the first sign of life and between jobs; `deadline` is monotonic, s.
    """

    actor: Any
    answer: Any
    key: str | None = None
    deadline: float = 0.0

    @property
    def ready(self) -> bool:
        return self.answer is None


class RayEngine:
    """Worker processes on a Ray cluster.

    The cluster is that of `RAY_ADDRESS`; where there is none, one is started on this machine for
    as long as the campaign goes on.

    Attributes:
        workers: How many jobs are carried out at a time; by default the cluster's cores, 0 until
            it is joined.
    """

    def __init__(self, workers: int | None = None) -> None:
        try:
            import ray
        except ImportError:
            raise InputError(
                "ray is not installed: pip install cavalcade[cluster]", key="--engine"
            ) from None
        self._ray: Any = ray  # its types are not looked at: most installations do without it
        self._asked = workers
        self.workers = workers or 0
        self._seats: list[_Seat] = []
        self._started = False
        self._stillborn = 0

    @property
    def room(self) -> int:
        """How many actors wait for a job."""
        return sum(seat.ready for seat in self._seats)

    def submit(self, key: str, work: Work, arguments: tuple[Any, ...], limit: float) -> None:
        """Have `work(*arguments)` carried out; see `Engine.submit`."""
        seat = next(seat for seat in self._seats if seat.ready)
        seat.answer = seat.actor.carry_out.remote(work, arguments)
        seat.key, seat.deadline = key, clock.monotonic() + limit

    def collect(self, timeout: float) -> list[Ended]:
        """The jobs that ended since; waits for one for up to `timeout` s."""
        until = clock.monotonic() + timeout
        while True:
            waiting = [seat.answer for seat in self._seats if not seat.ready]
            left = max(0.0, min(until - clock.monotonic(), _ANSWER))
            done = self._ray.wait(waiting, num_returns=1, timeout=left)[0] if waiting else []
            found: list[Ended] = []
            awake = 0
            for place, seat in enumerate(self._seats):
                if seat.answer is not None and seat.answer in done:
                    awake += seat.key is None
                    found += self._answered(place, seat)
                elif seat.key is not None and clock.monotonic() > seat.deadline:
                    found.append(Ended(seat.key, "overtime"))
                    self._replace(place)
            if found or awake or clock.monotonic() >= until or not waiting:
                return found

    def __enter__(self) -> Self:
        """Join or start the cluster and ask for the actors."""
        use_one_thread()
        # Nothing is sent to Ray's makers, and no page is served.
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        self._started = not self._ray.is_initialized()
        if self._started:
            quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
            address = os.environ.get("RAY_ADDRESS")
            if address:
                _check_reachable(address)
            else:
                quiet |= {"include_dashboard": False, "num_cpus": self._asked}
            try:
                self._ray.init(**quiet)
            except (ConnectionError, RuntimeError, ValueError, OSError) as error:
                raise ClusterError(f"the Ray cluster cannot be reached: {error}") from None
        cores = int(self._ray.cluster_resources().get("CPU", 0))
        self.workers = self._asked or max(cores, 1)
        self._seats = [self._seat() for _ in range(self.workers)]
        return self

    def __exit__(self, *error: object) -> None:
        """End every actor at once, and the cluster if it was started here."""
        for seat in self._seats:
            self._ray.kill(seat.actor)
        self._seats = []
        if self._started:
            self._ray.shutdown()

    def _seat(self) -> _Seat:
        options = {"num_cpus": 1, "max_restarts": 0, "max_task_retries": 0}
        actor = self._ray.remote(**options)(_Worker).remote()
        return _Seat(actor, actor.answer.remote())

    def _replace(self, place: int) -> None:
        self._ray.kill(self._seats[place].actor)
        self._seats[place] = self._seat()

    def _answered(self, place: int, seat: _Seat) -> list[Ended]:
        key, faults = seat.key, self._ray.exceptions
        try:
            value = self._ray.get(seat.answer)
        except faults.RayTaskError as error:
            # The actor lives: the work, or this package, cannot be had there.
            text = str(error.cause or error)
            if key is None:
                raise ClusterError(f"a node cannot carry trials out: {text}") from None
            seat.key = seat.answer = None
            return [Ended(key, "lost", detail=text)]
        except faults.RayError as error:
            self._stillborn += key is None
            if self._stillborn > _STILLBORN + self.workers:
                raise ClusterError(f"the cluster's processes do not start: {error}") from None
            self._replace(place)
            detail = f"the worker or its node is gone ({type(error).__name__})"
            return [] if key is None else [Ended(key, "lost", detail=detail)]
        seat.key = seat.answer = None
        self._stillborn = 0
        return [] if key is None else [Ended(key, "done", value)]


class _Worker:
    """The actor: one process on some node."""

    def __init__(self) -> None:
        use_one_thread()

    def answer(self) -> bool:
        """A sign of life, once what a trial needs can be imported."""
        from cavalcade.campaign import trial_runner  # noqa: F401

        return True

    def carry_out(self, work: Work, arguments: tuple[Any, ...]) -> Any:
        """Do one job."""
        return work(*arguments)


def _check_reachable(address: str) -> None:
    """Refuse an address where nobody answers; Ray itself would try for ten minutes."""
    host, separator, port = address.removeprefix("ray://").rpartition(":")
    if not separator or not port.isdecimal():
        return  # such as `auto`
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_CONNECTING).close()
    except (OSError, OverflowError) as error:
        raise ClusterError(
            f"the Ray cluster cannot be reached: RAY_ADDRESS={address}: {error}"
        ) from None
