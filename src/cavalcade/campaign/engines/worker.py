"""One worker process of this machine, and what every worker does first, whatever its engine.

Imports nothing that starts threads: their number is set here, before numpy and numba come in.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process, resource_tracker
from typing import Any

from cavalcade.campaign.engines.protocol import Work
from cavalcade.errors import CavalcadeError

ONE_THREAD = (
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
)
"""A trial is one core's work; the campaign has as many as it has cores."""


def cores() -> int:
    """How many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def use_one_thread() -> None:
    """Let numerical packages that are imported from now on use one thread."""
    os.environ |= dict.fromkeys(ONE_THREAD, "1")


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
        from pebble import ProcessPool

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
