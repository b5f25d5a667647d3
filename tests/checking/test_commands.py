"""Claims of robots under commands to have done what they were told."""

from __future__ import annotations

from typing import Any

import numpy as np

from cavalcade.checking.arrival import check_commands
from cavalcade.checking.tracks import Track
from cavalcade.scenario import parse_scenario

SCENARIO: Any = parse_scenario(
    {
        "version": 1,
        "name": "walk",
        "world": {"empty": {"size": [8, 5]}},
        "robots": [{"start": [1, 1, 0]}, {"start": [1, 3, 0]}],
        "task": {
            "commands": [
                {"at": 0, "to": [6, 4]},
                {"at": 1, "robot": 0, "velocity": [0.1, 0, 0]},
            ],
            "duration": 4,
        },
    }
)


def ending(first: Any, second: Any, end: float) -> tuple[Track, ...]:
    time = np.array([0.0, end])
    return tuple(
        Track(time, np.array([[*start, 0.0], [*last, 0.0]]))
        for start, last in (((1, 1), first), ((1, 3), second))
    )


def test_only_who_was_sent_somewhere_last_has_to_be_there() -> None:
    assert check_commands(SCENARIO, ending((2, 2), (5.9, 4.1), 4.0)) == []
    (away,) = check_commands(SCENARIO, ending((6, 4), (5.5, 4.0), 4.0))
    assert (away.kind, away.robots, away.value) == ("arrival", (1,), 0.5)


def test_a_task_takes_its_time() -> None:
    (short,) = check_commands(SCENARIO, ending((2, 2), (6, 4), 3.9))
    assert short.robots == (0, 1)
    assert "after 3.90 s of 4.00 s" in short.message
