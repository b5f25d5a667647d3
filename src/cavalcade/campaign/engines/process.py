"""What every worker process does first, whatever engine it belongs to.

Imports nothing that starts threads: their number is set here, before numpy and numba come in.
"""

from __future__ import annotations

import os
import threading

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
    for name in ONE_THREAD:
        os.environ[name] = "1"


def end_with_parent() -> None:
    """End this process when the one that started it is gone, however it went.

    A worker that waits for work, or is in the middle of a trial, would not notice otherwise.
    """
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, name="parent-watch", daemon=True).start()


def start_worker() -> None:
    """Both."""
    use_one_thread()
    end_with_parent()
