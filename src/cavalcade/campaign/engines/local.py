"""Trials on this machine's cores, in processes that may die."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import threading
from collections import deque
from collections.abc import Iterator
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context, parent_process, resource_tracker
from typing import Any, Self

from pebble import ProcessExpired, ProcessPool

from cavalcade.campaign.engines.protocol import Ended, Work, cores, use_one_thread
from cavalcade.errors import CavalcadeError

_AHEAD = 1
"""So many jobs wait beside those that run: `collect` hands them out before it returns."""

_BREAKS = 5
"""A worker may break this often before any job ends."""


def start_worker() -> None:
    """Use one thread, and end this process when the one that started it is gone, however it went.

    A worker that waits for work, or is in the middle of a trial, would not notice otherwise.
    """
    use_one_thread()
    parent = parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, name="parent-watch", daemon=True).start()


class WorkersError(CavalcadeError):
    """Worker processes cannot be started, or die before they take a job."""


class Worker:
    """A process that carries out one job at a time, in a pool of its own, which survives it.

    The processes of one of Pebble's pools share a pipe. Each locks it while it takes a job,
    which includes importing what the job needs, and while it gives a result back. One that is
    killed then leaves it locked for good: the others can neither take a job nor give a result
    back, and after a minute they die of it (https://github.com/noxdafox/pebble/issues/163).
    With one process to a pool there are no others, and the next gets a pool, and so a lock, of
    its own.

    Processes are spawned, not forked: compiled kernels and threads do not survive a fork, and
    a fresh process costs about a second.
    """

    def __init__(self) -> None:
        self._pool: Any = None  # Pebble's methods have no types

    @property
    def broken(self) -> bool:
        """Whether it takes no jobs, as when its process died without one."""
        return self._pool is None or not self._pool.active

    def start(self) -> None:
        """Start a process; nothing of one before is kept.

        Raises:
            WorkersError: That is not possible.
        """
        self.stop()
        self.join()
        self._pool = ProcessPool(
            max_workers=1, initializer=start_worker, context=get_context("spawn")
        )
        try:
            with _interrupts_kept_from_workers():
                self._pool.active  # noqa: B018 - it starts threads and a process
        except (BrokenProcessPool, OSError) as error:
            self.stop()
            self.join()
            why = error.__cause__ or error
            raise WorkersError(f"the worker processes cannot be started: {why}") from None

    def begin(self, work: Work, arguments: tuple[Any, ...], limit: float) -> Any:
        """Have `work(*arguments)` carried out, for up to `limit` s.

        Its future may stay undone if the worker breaks; one that is broken raises RuntimeError.
        """
        return self._pool.schedule(work, args=arguments, timeout=limit)

    def stop(self) -> None:
        """Have it ended; `join` ends it."""
        if self._pool is not None:
            self._pool.stop()

    def join(self) -> None:
        """Wait until the process is gone; to be called after `stop`."""
        if self._pool is not None:
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


@dataclass
class _Job:
    """A job that is under way, and what carries it out unless it waits."""

    work: Work
    arguments: tuple[Any, ...]
    limit: float
    worker: Worker | None = None
    future: Any = None


class LocalEngine:
    """As many worker processes on this machine as said, or as this process may use cores."""

    def __init__(self, workers: int | None = None) -> None:
        self._all = [Worker() for _ in range(workers if workers is not None else cores())]
        self._idle: deque[Worker] = deque()
        self._breaks = dict.fromkeys(self._all, 0)
        self._under_way: dict[str, _Job] = {}
        self._waiting: deque[str] = deque()
        self._ended: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()

    @property
    def room(self) -> int:
        """How many more jobs may be submitted now."""
        return len(self._all) + _AHEAD - len(self._under_way)

    def submit(self, key: str, work: Work, arguments: tuple[Any, ...], limit: float) -> None:
        """Have `work(*arguments)` carried out; see `Engine.submit`."""
        self._under_way[key] = _Job(work, arguments, limit)
        self._waiting.append(key)
        self._hand_out()

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
                self._look_after()
                break
            wait = 0.0
            job = self._under_way.get(key)
            if job is None or job.future is not future or job.worker is None:
                continue
            if _went_down_with_its_worker(future):
                self._replace(job.worker)
                self._waiting.appendleft(key)
            else:
                self._breaks = dict.fromkeys(self._all, 0)
                del self._under_way[key]
                found.append(_ended(key, future))
                if isinstance(future.exception(), ProcessExpired):
                    job.worker.start()
            self._idle.append(job.worker)
            job.worker = None
            self._hand_out()
        return found

    def __enter__(self) -> Self:
        """Start the workers."""
        try:
            for worker in self._all:
                worker.start()
                self._idle.append(worker)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        """End every worker at once."""
        for worker in self._all:
            worker.stop()
        for worker in self._all:
            worker.join()

    def _hand_out(self) -> None:
        """Give the jobs that wait to idle workers."""
        while self._waiting and self._idle:
            key = self._waiting.popleft()
            job = self._under_way[key]
            job.worker = self._idle.popleft()
            job.future = self._begun(job, job.worker)
            job.future.add_done_callback(lambda done, key=key: self._ended.put((key, done)))

    def _begun(self, job: _Job, worker: Worker) -> Any:
        while True:
            try:
                return worker.begin(job.work, job.arguments, job.limit)
            except RuntimeError:  # it died while it was idle
                self._replace(worker)

    def _look_after(self) -> None:
        """Take jobs back from broken workers that have not given them back themselves."""
        for job in self._under_way.values():
            if job.worker is not None and job.worker.broken:
                job.future.cancel()

    def _replace(self, worker: Worker) -> None:
        """Start a worker anew that died without a job, or before its job began."""
        self._breaks[worker] += 1
        if self._breaks[worker] > _BREAKS:
            raise WorkersError("the worker processes end before they take a trial")
        worker.start()


def _went_down_with_its_worker(future: Any) -> bool:
    """Whether a job ended for no fault of its own."""
    return future.cancelled() or isinstance(future.exception(), BrokenProcessPool)


def _ended(key: str, future: Any) -> Ended:
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
