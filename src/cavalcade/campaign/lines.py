"""A trial's line: what is kept of a finished trial, one JSON object in `trials.jsonl`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cavalcade.campaign.draws.model import EXPECTED, SOLVED
from cavalcade.campaign.trial import Trial

Line = dict[str, Any]

CRASHED, REFUSED, OVERTIME = "crashed", "refused", "overtime"
"""Outcomes beside those of `summary.json` and the checker's `collision` and `invalid`."""

TIMES = (
    "wall_time_s",
    "planning_time_s",
    "cycle_ms",
    "real_time_factor",
    "versions",
    "single_time_ratio",
)
"""What differs in the summaries and measures of two runs of the same scenario."""


def failure_line(
    trial: Trial,
    outcome: str,
    detail: str,
    feasible: bool = True,
    level: float | None = None,
    expected: str = SOLVED,
) -> Line:
    """The line of a trial without a run.

    Args:
        trial: Which one.
        outcome: Why.
        detail: One line about it.
        feasible: Whether its world is; a failure in an unknown world counts as one.
        level: Of its world.
        expected: Of its world, as in `Drawn`.
    """
    return {
        "trial": trial.id,
        "suite": trial.suite,
        "scenario": trial.group,
        "variant": trial.variant,
        "disturbance": trial.disturbance,
        "seed": trial.seed,
        "outcome": outcome,
        "detail": " ".join(detail.split()),
        "success": outcome in EXPECTED.get(expected, ()),
        "feasible": feasible,
        "expected": expected,
        "level": level,
        "level_name": trial.draw.level_name,
        "contacts": 0,
        "avoidable": 0,
        "violations": [],
        "measured": {"time_ratio": None},
        "summary": {},
    }


def without_times(line: Mapping[str, Any]) -> Line:
    """The line without what differs when its trial is repeated."""
    summary = {key: value for key, value in line["summary"].items() if key not in TIMES}
    measured = {key: value for key, value in line["measured"].items() if key not in TIMES}
    return {**line, "summary": summary, "measured": measured}
