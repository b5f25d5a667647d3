"""Trials on this machine's cores: Pebble's process pool, which survives its processes."""

from __future__ import annotations

import os
import queue
import signal
from concurrent.futures import TimeoutError as FutureTimeout
from multiprocessing import get_context
from types import TracebackType
from typing import Any, Self

from cavalcade.campaign.engines.process import start_worker
from cavalcade.campaign.engines.protocol import Ended, Work

_AHEAD = 1
"""So many jobs wait beside those that run, so that no worker waits for the campaign."""


class LocalEngine:
    """Worker processes on this machine.

    Processes are spawned, not forked: compiled kernels and threads do not survive a fork, and
    a fresh process costs about a second.

    Args:
        workers: How many; None for the number of cores that this process may use.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._workers = workers if workers is not None else _cores()
        self._pool: Any = None  # Pebble's methods have no types
        self._under_way: dict[str, Any] = {}
        self._ended: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()

    @property
    def workers(self) -> int:
        """How many jobs are carried out at a time."""
        return self._workers

    @property
    def room(self) -> int:
        """How many more jobs may be submitted now."""
        return self._workers + _AHEAD - len(self._under_way)

    def submit(self, key: str, work: Work, arguments: tuple[Any, ...], limit: float) -> None:
        """Have `work(*arguments)` carried out; see `Engine.submit`."""
        future = self._living_pool().schedule(work, args=arguments, timeout=limit)
        self._under_way[key] = future
        future.add_done_callback(lambda done: self._ended.put((key, done)))

    def collect(self, timeout: float) -> list[Ended]:
        """The jobs that ended since; waits for one for up to `timeout` s."""
        found: list[Ended] = []
        wait = timeout
        while self._under_way:
            try:
                key, future = self._ended.get(timeout=wait) if wait else self._ended.get_nowait()
            except queue.Empty:
                break
            wait = 0.0
            if self._under_way.get(key) is future:
                del self._under_way[key]
                found.append(_ended(key, future))
        return found

    def __enter__(self) -> Self:
        """Start the workers."""
        self._living_pool()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End every worker at once."""
        self._close()

    def _living_pool(self) -> Any:
        """The pool; a fresh one if it is broken, as it is when an idle worker died."""
        from pebble import ProcessPool

        if self._pool is None or not self._pool.active:
            self._close()
            self._pool = ProcessPool(
                max_workers=self._workers, initializer=start_worker, context=get_context("spawn")
            )
        return self._pool

    def _close(self) -> None:
        if self._pool is not None:
            self._pool.stop()
            self._pool.join()
            self._pool = None


def _ended(key: str, future: Any) -> Ended:
    from pebble import ProcessExpired

    try:
        return Ended(key, "done", future.result())
    except FutureTimeout:
        return Ended(key, "overtime")
    except ProcessExpired as error:
        return Ended(key, "lost", detail=_death(error.exitcode))
    except Exception as error:
        # A broken pool, or a result or a function that cannot travel between processes.
        return Ended(key, "lost", detail=f"{type(error).__name__}: {error}")


def _death(code: int | None) -> str:
    if code is None or code >= 0:
        return f"the worker ended with code {code}"
    try:
        return f"the worker was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was killed by signal {-code}"


def _cores() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1
