"""The suites of the evidence by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import evidence_clutter as clutter
import evidence_events as events
import evidence_maps as maps
import evidence_paper as paper
from evidence_bars import Bar
from evidence_trials import Finished, Outcome, Trial


@dataclass(frozen=True)
class Suite:
    """A family of trials with one verdict.

    Attributes:
        about: One line.
        worlds: How many trials there are by default.
        variants: The variants that it is run with by default.
        trial: Makes number `seed` of the suite for a variant; called in the workers.
        measure: What to measure of a finished run, beside its summary.
        bars: The verdict on all trials of one variant.
        describe: Further lines on them.
        fixed: There are no more than `worlds`.
        available: Whether what it needs is there.
    """

    about: str
    worlds: int
    variants: tuple[str, ...]
    trial: Callable[[int, str], Trial]
    measure: Callable[[Trial, Finished], dict[str, Any]]
    bars: Callable[[Sequence[Outcome]], list[Bar]]
    describe: Callable[[Sequence[Outcome]], list[str]]
    fixed: bool = False
    available: Callable[[], bool] = lambda: True


def _clutter(suite: str, obstacles: int, bars: Callable[[Sequence[Outcome]], list[Bar]]) -> Suite:
    return Suite(
        about=f"14 x 10 m with {obstacles} obstacles, four robots in a square",
        worlds=100,
        variants=("cavalcade",),
        trial=lambda seed, variant: clutter.clutter_trial(suite, obstacles, seed, variant),
        measure=clutter.measure,
        bars=bars,
        describe=clutter.describe,
    )


def _sparse_bars(outcomes: Sequence[Outcome]) -> list[Bar]:
    return clutter.safe_and_successful(outcomes) + clutter.efficient(outcomes)


SUITES: Mapping[str, Suite] = MappingProxyType(
    {
        "scenarios": Suite(
            about="the paper's arena, cone, laboratory and corridor",
            worlds=len(paper.NAMES),
            variants=("cavalcade", "published"),
            trial=paper.trial,
            measure=paper.measure,
            bars=paper.bars,
            describe=paper.describe,
            fixed=True,
        ),
        "sparse": _clutter("sparse", 25, _sparse_bars),
        "dense": _clutter("dense", 45, clutter.safe_and_successful),
        "events": Suite(
            about="obstacles appear and move, goal and shape change, a robot is lost",
            worlds=50,
            variants=("cavalcade",),
            trial=events.trial,
            measure=events.measure,
            bars=events.bars,
            describe=events.describe,
        ),
        "maps": Suite(
            about="four robots on the maps depot and warehouse",
            worlds=len(maps.CROSSINGS),
            variants=("cavalcade",),
            trial=maps.trial,
            measure=maps.measure,
            bars=maps.bars,
            describe=maps.describe,
            fixed=True,
            available=maps.available,
        ),
    }
)
