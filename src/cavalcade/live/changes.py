"""Changes of what a team is to do, which may take longer than a control cycle."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable

_LOG = logging.getLogger(__name__)

_ENDING = 5.0
"""The thread's end is waited for so long, s."""


class Changes:
    """Carries changes out in order, in a thread of its own.

    Changes of the task are counted, so that it can be told of a cycle which ones it knew.

    Args:
        on_failure: Called with what a change raised; those that follow are carried out.

    Attributes:
        asked: How many changes of the task have been asked for.
        done: How many of them are in effect.
    """

    def __init__(self, on_failure: Callable[[Exception], None]) -> None:
        self.asked = self.done = 0
        self._on_failure = on_failure
        self._lock = threading.Lock()
        self._waiting: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="cavalcade-changes", daemon=True)

    def start(self) -> None:
        """Begin to carry out."""
        self._thread.start()

    def close(self) -> None:
        """Carry out what waits, and no more."""
        self._waiting.put(None)
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(_ENDING)

    def put(self, change: Callable[[], None]) -> None:
        """Have something carried out; from any thread."""
        self._waiting.put(change)

    def put_task(self, change: Callable[[], None]) -> None:
        """Have a change of the task carried out; from any thread."""
        with self._lock:
            self.asked += 1
            number = self.asked

            def act() -> None:
                change()
                self.done = number

            self._waiting.put(act)

    def _work(self) -> None:
        while (change := self._waiting.get()) is not None:
            try:
                change()
            except Exception as error:
                _LOG.exception("a change of the team's task has failed")
                self._on_failure(error)
