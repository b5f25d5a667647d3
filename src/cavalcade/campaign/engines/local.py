"""Trials on this machine's cores: Pebble's process pool, which survives its processes."""

from __future__ import annotations

import contextlib
import queue
import signal
from collections.abc import Iterator
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context, resource_tracker
from types import TracebackType
from typing import Any, Self

from cavalcade.campaign.engines.process import cores, start_worker
from cavalcade.campaign.engines.protocol import Ended, Work
from cavalcade.errors import CavalcadeError

_AHEAD = 1
"""So many jobs wait beside those that run, so that no worker waits for the campaign."""

_BREAKS = 5
"""The pool may break this often in a row before any job ends."""


class WorkersError(CavalcadeError):
    """Worker processes cannot be started, or die before they take a job."""


@dataclass
class _Job:
    """A job that is under way, with its latest future."""

    work: Work
    arguments: tuple[Any, ...]
    limit: float
    future: Any = None


class LocalEngine:
    """Worker processes on this machine.

    Processes are spawned, not forked: compiled kernels and threads do not survive a fork, and
    a fresh process costs about a second.

    Args:
        workers: How many; None for the number of cores that this process may use.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._workers = workers if workers is not None else cores()
        self._pool: Any = None  # Pebble's methods have no types
        self._under_way: dict[str, _Job] = {}
        self._ended: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self._breaks = 0

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
        self._under_way[key] = job = _Job(work, arguments, limit)
        self._schedule(key, job)

    def collect(self, timeout: float) -> list[Ended]:
        """The jobs that ended since; waits for one for up to `timeout` s.

        Raises:
            WorkersError: The worker processes do not start.
        """
        found: list[Ended] = []
        wait = timeout
        while self._under_way:
            try:
                key, future = self._ended.get(timeout=wait) if wait else self._ended.get_nowait()
            except queue.Empty:
                self._living_pool()
                break
            wait = 0.0
            job = self._under_way.get(key)
            if job is None or job.future is not future:
                continue
            if _went_down_with_the_pool(future):
                self._schedule(key, job)
            else:
                self._breaks = 0
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

    def _schedule(self, key: str, job: _Job) -> None:
        job.future = self._living_pool().schedule(job.work, args=job.arguments, timeout=job.limit)
        job.future.add_done_callback(lambda done: self._ended.put((key, done)))

    def _living_pool(self) -> Any:
        """The pool; a fresh one if it is broken, as it is when an idle worker died."""
        if self._pool is not None and not self._pool.active:
            self._close()
            for job in self._under_way.values():
                if job.future is not None:
                    job.future.cancel()  # where the pool has not ended it
            self._breaks += 1
            if self._breaks > _BREAKS:
                raise WorkersError("the worker processes end before they take a trial")
        if self._pool is None:
            self._start()
        return self._pool

    def _start(self) -> None:
        from pebble import ProcessPool

        self._pool = ProcessPool(
            max_workers=self._workers, initializer=start_worker, context=get_context("spawn")
        )
        try:
            with _interrupts_kept_from_workers():
                self._pool.active  # noqa: B018 - it starts threads and processes
        except BrokenProcessPool as error:
            self._close()
            why = error.__cause__ or error
            raise WorkersError(f"the worker processes cannot be started: {why}") from None

    def _close(self) -> None:
        if self._pool is not None:
            self._pool.stop()
            self._pool.join()
            self._pool = None


@contextlib.contextmanager
def _interrupts_kept_from_workers() -> Iterator[None]:
    """Threads and processes started within never see the terminal's Ctrl-C; this thread does.

    The workers are told by the campaign. One that is just starting would say where it was.
    """
    if not hasattr(signal, "pthread_sigmask"):  # not on every system
        yield
        return
    resource_tracker.ensure_running()  # starting it would change the mask
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _went_down_with_the_pool(future: Any) -> bool:
    """Whether a job ended for no fault of its own process."""
    return future.cancelled() or isinstance(future.exception(), BrokenProcessPool)


def _ended(key: str, future: Any) -> Ended:
    from pebble import ProcessExpired

    try:
        return Ended(key, "done", future.result())
    except FutureTimeout:
        return Ended(key, "overtime")
    except ProcessExpired as error:
        return Ended(key, "lost", detail=_death(error.exitcode))
    except Exception as error:
        # A result or a function that cannot travel between processes.
        return Ended(key, "lost", detail=f"{type(error).__name__}: {error}")


def _death(code: int | None) -> str:
    if code is None or code >= 0:
        return f"the worker ended with code {code}"
    try:
        return f"the worker was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was killed by signal {-code}"
