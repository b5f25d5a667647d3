"""A goal's slot lay so near to a lost robot that the rule for pairs kept the others out of it."""

from __future__ import annotations

from cavalcade.jobs.running import run
from cavalcade.scenario import parse_scenario


def test_the_slot_is_taken() -> None:
    data = {
        "version": 1,
        "name": "beside",
        "world": {"empty": {"size": [7, 4]}},
        "robots": [{"model": "go1", "start": [x, y, 0.0]} for x, y in ((1, 2.5), (1, 1.5), (5, 2))],
        "task": {
            "formation": {"shape": "line", "spacing": 1.0},
            "goals": [[5.0, 1.0, 0.0]],
        },
        "execution": {"timeout": 40, "events": [{"at": 0.1, "lose": 2}]},
    }
    result = run(parse_scenario(data))
    assert result.reason == "arrived"
    away = result.recording.poses[-1, :2, :2] - result.recording.poses[-1, 2, :2]
    assert (away**2).sum(axis=1).min() < 0.6**2
