"""Pictures of single trials, which are repeated for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.report.artist import Artist, safe_name
from cavalcade.campaign.report.blocks import Drawn
from cavalcade.campaign.report.trials import Trial
from cavalcade.campaign.report.worst import Worst

if TYPE_CHECKING:
    from cavalcade.jobs import JobResult

Replay = Callable[[Mapping[str, Any]], "JobResult | None"]
"""Repeats the trial of a line in memory; None where it cannot be repeated. It is called for the few
worst trials only."""

_VARYING = ("wall_time_s", "planning_time_s", "cycle_ms", "real_time_factor", "versions")
"""Keys of a summary that a repetition may change."""


@dataclass(frozen=True)
class _Repeated:
    drawn: Drawn | None
    remark: str


def pictures_of(
    chosen: Sequence[Worst], artist: Artist, replay: Replay | None
) -> tuple[dict[str, Drawn], dict[str, str]]:
    """Pictures of the trials, and what there is to remark about them, by trial."""
    drawn: dict[str, Drawn] = {}
    remarks: dict[str, str] = {}
    if artist.folder is None or replay is None:
        return drawn, remarks
    for item in chosen:
        if not item.trial.summary:
            continue
        found = _repeat(item.trial, artist.folder, replay)
        if found.drawn is not None:
            drawn[item.trial.name] = found.drawn
            artist.names.append(found.drawn.name)
        if found.remark:
            remarks[item.trial.name] = found.remark
    return drawn, remarks


def _repeat(trial: Trial, folder: Path, replay: Replay) -> _Repeated:
    from cavalcade.campaign.report.pictures import draw_way
    from cavalcade.errors import OutputError

    name = f"worst-{safe_name(trial.name)}.png"
    try:
        repeated = replay(trial.line)
        if repeated is None:
            return _Repeated(None, "")
        scenario, world, recording = repeated.scenario, repeated.world, repeated.recording
        if recording is not None:
            path = draw_way(scenario, world, recording, repeated.summary, folder / name)
        else:
            path = _draw_plan(repeated, folder / name)
    except OutputError:
        raise
    except Exception as error:  # one picture less is no reason to lose the report
        return _Repeated(None, f"It could not be drawn: {type(error).__name__}.")
    if path is None:
        return _Repeated(None, "")
    remark = (
        "" if same_run(trial.summary, repeated.summary) else "The repetition ended differently."
    )
    return _Repeated(Drawn(path.name, path.read_bytes()), remark)


def _draw_plan(repeated: JobResult, path: Path) -> Path | None:
    from cavalcade.drawing.plans.scene import plan_scene
    from cavalcade.drawing.plans.top_view import draw_top_view

    if repeated.planned is None:
        return None
    return draw_top_view(plan_scene(repeated.scenario, repeated.world, repeated.planned), path)


def same_run(first: Mapping[str, Any], second: Mapping[str, Any]) -> bool:
    """Whether two summaries agree but for times of computing and versions."""
    keys = (set(first) | set(second)) - set(_VARYING)
    return all(first.get(key) == second.get(key) for key in keys)
