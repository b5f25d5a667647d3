"""How who shows a drive is told that there is something new, without being waited for."""

from __future__ import annotations

import threading


class Changes:
    """A number that grows with all that may be shown anew; any thread may use it."""

    def __init__(self) -> None:
        self._grown = threading.Condition()
        self._count = 0

    @property
    def count(self) -> int:
        """How often there was something new."""
        return self._count

    def tell(self) -> None:
        """There is something new."""
        with self._grown:
            self._count += 1
            self._grown.notify_all()

    def wait(self, known: int, longest: float) -> int:
        """Wait for something newer than `known`, for `longest` s at most; the present count."""
        with self._grown:
            self._grown.wait_for(lambda: self._count != known, longest)
            return self._count
