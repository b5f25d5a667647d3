"""What tests of several packages share."""

from __future__ import annotations

from collections.abc import Callable
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
