"""Hands trials to an engine and their lines back; knows what becomes of lost ones."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from cavalcade.campaign.engines.protocol import Ended, Engine, Work
from cavalcade.campaign.trial import CRASHED, OVERTIME, Line, Trial, failure_line
from cavalcade.campaign.trial_runner import lost_line, run_trial

RETRIES = 1
"""A trial whose process died is tried again this often."""

DRAWING = 60.0
"""Time to sample the world of a trial that was lost, s."""

COMPILING = 600.0
"""The time limit of what compiles the numerical kernels for all trials, s."""

_WAIT = 0.5
_PREPARING = "."
"""The key of what is no trial: their IDs begin with a letter or a digit."""


@dataclass(frozen=True)
class _Job:
    """A trial on its way, with what is known of its failure once it has failed for good."""

    trial: Trial
    lost: int = 0
    outcome: str | None = None
    detail: str = ""


def in_turns(trials: Sequence[Trial]) -> list[Trial]:
    """The first of every cell, then the second ones, and so on.

    Some cells take longer than others: so the pace of the first trials tells that of the rest.
    """
    counts: Counter[tuple[str, str, str]] = Counter()
    ranks = {}
    for trial in trials:
        cell = (trial.group, trial.variant, trial.disturbance)
        ranks[trial.id] = counts[cell]
        counts[cell] += 1
    return sorted(trials, key=lambda trial: ranks[trial.id])


def dispatch(
    engine: Engine,
    trials: Iterable[Trial],
    limit: float,
    *,
    work: Work = run_trial,
    prepare: tuple[Work, tuple[Any, ...]] | None = None,
    tick: Callable[[], None] = lambda: None,
) -> Iterator[Line]:
    """The lines of the trials as they are finished, in any order.

    A trial whose process dies is tried once more, then its outcome is `crashed`; one that takes
    too long is `overtime`. For the line of either the world is sampled, but not run.

    Args:
        engine: Started.
        limit: Of wall clock per trial, s.
        prepare: A function and its arguments: a job that has to end, however it does, before the
            first trial begins; it may take `COMPILING` s.
    """
    coming = map(_Job, trials)
    again: deque[_Job] = deque()
    under_way: dict[str, _Job] = {}
    if prepare is not None:
        while not engine.room:
            engine.collect(_WAIT)
            tick()
        engine.submit(_PREPARING, *prepare, COMPILING)
        while not engine.collect(_WAIT):
            tick()
    exhausted = False
    while True:
        while engine.room > 0:
            job = again.popleft() if again else next(coming, None)
            if job is None:
                exhausted = True
                break
            under_way[job.trial.id] = job
            if job.outcome is None:
                engine.submit(job.trial.id, work, (job.trial,), limit)
            else:
                arguments = (job.trial, job.outcome, job.detail)
                engine.submit(job.trial.id, lost_line, arguments, DRAWING)
        if not under_way and not again and exhausted:
            return
        for ended in engine.collect(_WAIT):
            job = under_way.pop(ended.key)
            if ended.fate == "done":
                yield ended.value
            elif job.outcome is not None:  # not even its world can be sampled
                yield failure_line(job.trial, job.outcome, job.detail)
            else:
                again.append(_after(job, ended, limit))
        tick()


def _after(job: _Job, ended: Ended, limit: float) -> _Job:
    """What to do with a trial that did not come back."""
    if ended.fate == "overtime":
        return replace(job, outcome=OVERTIME, detail=f"not done within {limit:g} s")
    if job.lost < RETRIES:
        return replace(job, lost=job.lost + 1)
    detail = f"{ended.detail}, as at the first try" if ended.detail else "lost twice"
    return replace(job, outcome=CRASHED, detail=detail)
