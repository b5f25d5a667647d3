"""Makes a process fit for control cycles that robots wait for."""

from __future__ import annotations

import gc
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

SWITCH = 0.0005
"""A thread that computes in Python lets others run after so long, s; Python's own is ten times as
long, and a cycle may have to wait for it again and again."""


def prepare_process() -> None:
    """Keep pauses of Python's own out of what follows; call it once everything is compiled.

    A full collection looks at all objects that imports and compilation made, some 75 ms long; they
    stay, so that nobody need look at them again.
    """
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(SWITCH)


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Have SIGTERM and SIGHUP raise KeyboardInterrupt meanwhile, so that robots are stopped first.

    In another thread than the main one, which alone hears signals, it changes nothing.
    """
    before = {}
    if threading.current_thread() is threading.main_thread():
        names = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
        before = {name: signal.signal(name, _interrupt) for name in names}
    try:
        yield
    finally:
        for name, handler in before.items():
            signal.signal(name, handler)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt
