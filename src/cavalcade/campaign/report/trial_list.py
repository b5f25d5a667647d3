"""All trials as the page's table shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cavalcade.campaign.report.page import trial_rows
from cavalcade.campaign.report.trials import Order, Trial


def all_trials(trials: Sequence[Trial], order: Order) -> dict[str, Any]:
    """What the page's table of trials shows."""
    arranged = order.sorted(trials)
    planned = bool(trials) and all(trial.planned for trial in trials)
    columns: list[tuple[str, int | None]] = [
        ("trial", None),
        ("feasible", None),
        ("success", None),
        ("outcome", None),
        ("level", _level_digits(arranged)),
        ("end (s)", 1),
        ("over alone" if planned else "over bound", 2),
        ("planned in (s)", 3) if planned else ("error (cm)", 1),
        ("gap (m)", 3),
        ("collisions", 0),
        ("detail", None),
    ]
    return trial_rows(columns, [_row(trial) for trial in arranged])


def _row(trial: Trial) -> tuple[Any, ...]:
    error = trial.number("formation_error_m.mean")
    third = None if error is None else 100.0 * error
    if trial.planned:
        third = trial.number("planning_time_s")
    return (
        trial.name,
        "yes" if trial.feasible else "no",
        "yes" if trial.success else "no",
        trial.outcome,
        trial.level,
        _round(trial.number("makespan_s" if trial.planned else "sim_time_s"), 2),
        _round(trial.time_ratio, 3),
        _round(third, 4 if trial.planned else 2),
        _round(trial.gap, 4),
        trial.contacts,
        trial.said,
    )


def _level_digits(trials: Sequence[Trial]) -> int:
    levels = [trial.level for trial in trials if trial.level is not None]
    return 0 if all(level.is_integer() for level in levels) else 2


def _round(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)
