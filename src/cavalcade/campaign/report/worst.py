"""The trials that deserve a look first."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from cavalcade.campaign.report.trials import Order, Trial

MOST = 8
"""So many are shown."""

_SEVERITY = (
    "collision",
    "fallen",
    "invalid",
    "crashed",
    "stuck",
    "stopped",
    "timeout",
    "budget",
    "infeasible",
    "overtime",
    "refused",
)


@dataclass(frozen=True)
class Worst:
    """A trial and why it is among the worst."""

    trial: Trial
    why: str


def worst_trials(trials: Sequence[Trial], order: Order, most: int = MOST) -> list[Worst]:
    """Failures, then the smallest gap, then the longest time ratio.

    Of the failures one of each outcome comes first, collisions before all, and within an outcome
    those of the first variant. Failures in worlds that cannot be crossed count only where
    something was touched. Two places are kept for trials that succeeded.
    """
    arranged = order.sorted(trials)
    failures = _failures(arranged, order)
    done = [trial for trial in arranged if trial.success]
    by_gap = sorted(
        (t for t in done if t.gap is not None), key=lambda t: t.gap if t.gap is not None else 0.0
    )
    by_time = sorted(
        (t for t in done if t.time_ratio is not None), key=lambda t: -(t.time_ratio or 0.0)
    )
    places = most - min(len(failures), max(most - 2, 1))
    chosen = [Worst(trial, _why(trial)) for trial in failures[: most - places]]
    closest = by_gap[: (places + 1) // 2]
    chosen += [Worst(t, f"smallest gap of those that succeeded: {t.gap:.3f} m") for t in closest]
    taken = {worst.trial.name for worst in chosen}
    slow = [trial for trial in by_time if trial.name not in taken][: most - len(chosen)]
    chosen += [
        Worst(t, f"longest time of those that succeeded: {t.time_ratio:.2f} times {bound_of(t)}")
        for t in slow
    ]
    return chosen


def bound_of(trial: Trial) -> str:
    """What its time is compared with."""
    return "the slowest robot alone" if trial.planned else "the lower bound"


def is_failure(trial: Trial) -> bool:
    """Whether the trial failed where it need not have, or touched what it need not have."""
    return not trial.success and (trial.feasible or trial.hopeless or trial.avoidable > 0)


def _failures(trials: Sequence[Trial], order: Order) -> list[Trial]:
    """In turns from each outcome, the gravest outcome first."""
    queues: dict[str, deque[Trial]] = {}
    ranked = sorted(
        (trial for trial in trials if is_failure(trial)),
        key=lambda trial: (
            _severity(trial),
            order.variants.index(trial.variant),
            trial.gap if trial.gap is not None else 0.0,
        ),
    )
    for trial in ranked:
        queues.setdefault(trial.outcome, deque()).append(trial)
    found = []
    while any(queues.values()):
        for queue in queues.values():
            if queue:
                found.append(queue.popleft())
    return found


def _severity(trial: Trial) -> int:
    if trial.avoidable:
        return -1
    known = trial.outcome in _SEVERITY
    return _SEVERITY.index(trial.outcome) if known else len(_SEVERITY)


def _why(trial: Trial) -> str:
    return f"{trial.outcome}: {trial.said}" if trial.said else trial.outcome
