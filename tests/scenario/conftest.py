"""A small valid scenario as plain data, for tests to change."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

_DATA: dict[str, Any] = {
    "version": 1,
    "name": "small",
    "world": {
        "empty": {"size": [8, 5]},
        "obstacles": [
            {"box": {"center": [4, 2], "size": [1.0, 0.4], "yaw": 0.3}},
            {"circle": {"center": [6, 4], "radius": 0.2}},
            {"polygon": {"points": [[3, 4], [4, 4], [3, 5]]}},
        ],
    },
    "robots": [
        {"model": "go1", "start": [1.5, 2.5, 0.0]},
        {"model": "go1", "start": [0.7, 2.5, 0.0]},
    ],
    "task": {"formation": {"shape": "line", "spacing": 0.9}, "goals": [[6.5, 2.5, 0.0]]},
}


@pytest.fixture
def data() -> dict[str, Any]:
    return copy.deepcopy(_DATA)


@pytest.fixture
def events(data: dict[str, Any]) -> Callable[..., dict[str, Any]]:
    """The small scenario with these events."""

    def with_events(*found: dict[str, Any]) -> dict[str, Any]:
        return {**data, "execution": {"events": list(found)}}

    return with_events
