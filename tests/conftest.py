"""What tests of several packages share."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

_SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Path of a file below `../shared/data`; skips the test where it is not there."""

    def path_of(relative: str) -> Path:
        path = _SHARED_DATA / relative
        if not path.exists():
            pytest.skip(f"shared/data/{relative} is not here")
        return path

    return path_of


@pytest.fixture(scope="session", autouse=True)
def _interruptible() -> Iterator[None]:
    """Let the programs that tests start be interrupted, also where a shell runs us aside.

    Shells start what is put aside with the signal of Ctrl-C ignored, and that is inherited.
    """
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
