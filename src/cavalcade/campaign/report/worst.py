"""The trials that deserve a look first, repeated for their pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report.canvas import OUTCOME_COLORS, Artist, Figure
from cavalcade.campaign.report.trials import Trial, TrialTable
from cavalcade.campaign.report.wording import code, number, plain
from cavalcade.campaign.trial import TIMES
from cavalcade.errors import OutputError

if TYPE_CHECKING:
    from cavalcade.jobs import JobResult

Replay = Callable[[Mapping[str, Any]], "JobResult | None"]
"""Repeats the trial of a line in memory; None where it cannot be repeated. It is called for the few
worst trials only."""

MOST, SHARE = 8, 0.25
"""So many are shown, at most, and of all trials no more than this share: each is run once more."""

_SEVERITY = {outcome: rank for rank, outcome in enumerate(OUTCOME_COLORS)}


def worst_trials(table: TrialTable) -> list[tuple[Trial, str]]:
    """The worst, each with why: failures, then the smallest gap, then the longest time ratio.

    Of the failures one of each outcome comes first, collisions before all, and within an outcome
    those of the first variant. Failures in worlds that cannot be crossed count only where
    something was touched. Two places are kept for trials that succeeded, where there are three.
    """
    ((trials,),) = table.rows("SELECT count(*) FROM trials")
    most = min(MOST, math.ceil(SHARE * trials))
    failures = _in_turns(table)
    closest = table.trials("success AND gap IS NOT NULL", "gap, place", most)
    slowest = table.trials("success AND time_ratio IS NOT NULL", "time_ratio DESC, place", most)
    failed = min(len(failures), max(most - 2, 1))
    places = most - failed
    chosen = [(t, f"{t.outcome}: {t.reason}" if t.reason else t.outcome) for t in failures[:failed]]
    chosen += [
        (t, f"smallest gap of those that succeeded: {t.gap:.3f} m")
        for t in closest[: (places + 1) // 2]
    ]
    taken = {trial.name for trial, _ in chosen}
    chosen += [
        (t, f"longest time of those that succeeded: {t.time_ratio:.2f} times {_bound_of(t)}")
        for t in [trial for trial in slowest if trial.name not in taken][: most - len(chosen)]
    ]
    return chosen


def _in_turns(table: TrialTable) -> list[Trial]:
    """Failures in turns from each outcome, the gravest outcome first."""
    queues: dict[str, list[Trial]] = {}
    for trial in sorted(table.failures("variant_at, coalesce(gap, 0.0), place"), key=_severity):
        queues.setdefault(trial.outcome, []).append(trial)
    return [trial for turn in zip_longest(*queues.values()) for trial in turn if trial]


def _severity(trial: Trial) -> int:
    return -1 if trial.avoidable else _SEVERITY.get(trial.outcome, len(_SEVERITY))


def _bound_of(trial: Trial) -> str:
    """What its time is compared with."""
    return "the slowest robot alone" if trial.planned else "the lower bound"


def shown_worst(
    table: TrialTable,
    lines: Mapping[str, Mapping[str, Any]],
    artist: Artist,
    replay: Replay | None,
) -> list[dict[str, Any]]:
    """The worst trials, each with a picture where it can be repeated; arguments as of `document`.

    Of each it is said why it is here and what it measured, with the command that repeats it in the
    campaign's folder, and a remark on its repetition, which may be empty.
    """
    found = []
    for trial, why in worst_trials(table):
        figure, remark = None, ""
        if artist.folder is not None and replay is not None and trial.ran:
            figure, remark = _repeat(trial, lines[trial.name], artist, replay)
        shown = {
            "name": trial.name,
            "about": f"{_capital(plain(why))}. {_facts(trial)}",
            "command": f"cavalcade trial . {trial.name} --out worst/{trial.name}",
            "remark": remark,
            "figure": figure,
        }
        found.append(shown)
    return found


def _repeat(
    trial: Trial, line: Mapping[str, Any], artist: Artist, replay: Replay
) -> tuple[Figure | None, str]:
    """The picture, or None, and a remark, which may be empty."""
    caption = f"{code(trial.name)}: the plan."
    if not trial.planned:
        caption = (
            f"{code(trial.name)}: driven paths, bodies at the start (white) and at the end "
            "(coloured), goals; the ring marks the tightest place, outlines and moving "
            "obstacles are as they were then."
        )
    try:
        repeated = replay(line)
        if repeated is None:
            return None, ""
        figure = artist.raster(caption, partial(_draw, repeated), f"worst-{trial.name}")
    except OutputError:
        raise
    except Exception as error:  # one picture less is no reason to lose the report
        return None, f"It could not be drawn: {type(error).__name__}."
    same = figure is None or same_run(line["summary"], repeated.summary)
    return figure, "" if same else "The repetition ended differently."


def _draw(repeated: JobResult, path: Path) -> Path | None:
    """Draw the driven paths, or the plan; None where there is nothing to draw."""
    from cavalcade.campaign.report.pictures import draw_paths
    from cavalcade.drawing.plans.top_view import draw_top_view
    from cavalcade.drawing.scene import PlanScene

    scenario, world, recording = repeated.scenario, repeated.world, repeated.recording
    if recording is not None:
        return draw_paths(scenario, world, recording, repeated.summary, path)
    if repeated.planned is None:
        return None
    return draw_top_view(PlanScene(scenario, world, repeated.planned), path)


def same_run(first: Mapping[str, Any], second: Mapping[str, Any]) -> bool:
    """Whether two summaries agree but for times of computing and versions."""
    keys = (set(first) | set(second)) - set(TIMES)
    return all(first.get(key) == second.get(key) for key in keys)


def _facts(trial: Trial) -> str:
    """What was measured, in a sentence; empty where nothing was."""
    parts = [] if trial.feasible or trial.unsolvable else ["the world is not feasible"]
    if trial.level is not None:
        name = trial.level_name or "level"
        parts.append(f"{trial.level:g} {name}" if name.endswith("s") else f"{name} {trial.level:g}")
    measured: Sequence[tuple[float | None, str]] = (
        (trial.duration, f"{number(trial.duration, 1)} s simulated"),
        (trial.makespan if trial.planned else None, f"makespan {number(trial.makespan, 1)} s"),
        (trial.time_ratio, f"{number(trial.time_ratio)} times {_bound_of(trial)}"),
        (trial.length_ratio, f"{number(trial.length_ratio, 3)} times the shortest paths"),
        (
            trial.planning_time if trial.planned else None,
            f"planned in {number(trial.planning_time, 3)} s",
        ),
        (trial.gap, f"smallest gap {number(trial.gap, 3)} m"),
    )
    parts += [text for value, text in measured if value is not None]
    if trial.contacts:
        why = f" ({plain(trial.reason)})" if trial.success and trial.reason else ""
        parts.append(f"contacts {trial.contacts}, avoidable {trial.avoidable}{why}")
    text = ", ".join(parts)
    return f"{_capital(text)}." if text else ""


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
