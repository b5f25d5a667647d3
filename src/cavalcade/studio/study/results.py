"""Folders that runs, plans and campaigns left: found, told apart and read."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from cavalcade.campaign.definition import FILE as CAMPAIGN
from cavalcade.campaign.table import LINES, TABLE
from cavalcade.drawing.replay.track import merged_contacts
from cavalcade.errors import InputError, RecordingError
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.jobs.output_folder import PLAN, RECORDING, SCENARIO, SUMMARY
from cavalcade.metrics.clearance import fixed_shapes
from cavalcade.recording import Recording, read_plan, read_recording
from cavalcade.scenario import (
    ResolvedScenario,
    ScenarioWarning,
    World,
    build_world,
    load_scenario,
    resolve_scenario,
)
from cavalcade.studio.study.player import PlanPlayer, Player, RecordingPlayer
from cavalcade.world import MapWarning

Planned = tuple[tuple[Trajectory | None, ...], tuple[Array, ...]]

Kind = Literal["run", "plan", "campaign"]

_DEPTH = 3
"""Folders below the places that are listed."""

_MOST = 200
"""Folders that are listed."""


@dataclass(frozen=True)
class Result:
    """A run or a plan.

    Attributes:
        folder: Where it is.
        scenario, world: What it was made of; the world without obstacles that come, move or go.
        start: The world as it was at the start.
        summary: The content of `summary.json`; empty where there is none.
        player: Its moments.
        recording: None for a plan that nobody has carried out.
        planned: Trajectories and footholds, one of each per robot; empty without a plan.
        gaps: What is missing of it, a line each.
    """

    folder: Path
    scenario: ResolvedScenario
    world: World
    start: World
    summary: Mapping[str, Any]
    player: Player
    recording: Recording | None = None
    planned: Planned = ((), ())
    gaps: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What it is called: the folder's name, and the scenario's where that says more."""
        folder, scenario = self.folder.name, str(self.scenario.name)
        if folder == "run":
            folder = f"{self.folder.parent.name}/run"
        return folder if folder == scenario else f"{folder} ({scenario})"

    @cached_property
    def events(self) -> tuple[tuple[float, str], ...]:
        """(time in s, text) of what happened, in order of time."""
        recording = self.recording
        if recording is None:
            return ()
        found = list(recording.notes)
        if recording.physics is not None:
            track = recording.physics
            found += [(fall.time, f"robot {fall.robot} fell") for fall in track.falls]
            found += [
                (one.time, f"robot {one.robot}: {one.part} touched {_article(one.other)}")
                for one in merged_contacts(track.contacts)
            ]
        return tuple(sorted(found, key=lambda event: event[0]))


def kind_of(folder: Path) -> Kind | None:
    """What a folder holds; None for anything else."""
    try:
        names = {one.name for one in folder.iterdir()}
    except OSError:
        return None
    if RECORDING in names:
        return "run"
    if PLAN in names:
        return "plan"
    return "campaign" if names & {CAMPAIGN, LINES, TABLE} else None


def results_in(places: Iterable[Path]) -> list[Path]:
    """The folders of runs, plans and campaigns in these places, the newest first."""
    found: dict[Path, float] = {}
    for place in places:
        _collect(place, _DEPTH, found)
    return sorted(found, key=lambda folder: -found[folder])[:_MOST]


def _collect(folder: Path, depth: int, found: dict[Path, float]) -> None:
    try:
        if not folder.is_dir():
            return
        kind = kind_of(folder)
        if kind is not None:
            found[folder] = folder.stat().st_mtime
        if depth and kind in (None, "campaign"):
            for below in folder.iterdir():
                if below.is_dir() and not below.is_symlink() and not below.name.startswith("."):
                    _collect(below, depth - 1, found)
    except OSError:  # gone meanwhile, or not ours to read
        return


def folder_of(text: str) -> Path:
    """The folder that somebody typed; of a file in a result's folder, that folder.

    Raises:
        InputError: There is none.
    """
    said = text.strip().strip("'\"")
    if not said or not said.isprintable():
        raise InputError("expected the path of a folder", key="folder")
    path = Path(said).expanduser()
    try:
        path = path.resolve()
        if path.is_file():
            path = path.parent
        there = path.is_dir()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=said[:200]) from None
    if not there:
        raise InputError("there is no such folder", file=said[:200])
    return path


def read_result(folder: Path) -> Result:
    """What a run or a plan left.

    Raises:
        InputError: It is missing or damaged, or its parts do not belong together.
    """
    try:
        return _result(folder)
    except OSError as error:  # it vanishes while it is read
        reason = error.strerror or type(error).__name__
        raise InputError(f"cannot be read: {reason}", file=folder) from None


def _result(folder: Path) -> Result:
    kind = kind_of(folder)
    if kind not in ("run", "plan"):
        wanted = f"expected the folder of a run, a plan or a campaign: {RECORDING}, {PLAN}"
        raise InputError(f"{wanted} or {CAMPAIGN}", file=folder)
    if not (folder / SCENARIO).is_file():
        raise InputError(f"has no {SCENARIO}, so that nobody knows its robots", file=folder)
    gaps = []
    with warnings.catch_warnings():
        for told_before in (MapWarning, ScenarioWarning):
            warnings.simplefilter("ignore", told_before)
        scenario = resolve_scenario(load_scenario(folder / SCENARIO))
        world = start = build_world(scenario)
        recording: Recording | None = None
        player: Player | None = None
        if kind == "run":
            warnings.simplefilter("ignore", UserWarning)  # said below
            recording = read_recording(folder, forces=False)
            if not len(recording.time):
                raise RecordingError("nothing was recorded", file=folder / RECORDING)
            _check_robots(recording.poses.shape[1], scenario, folder / RECORDING)
            if not recording.ended:
                last = float(recording.time[-1])
                gaps.append(f"The recording breaks off at {last:.2f} s; its end is missing.")
            player = RecordingPlayer(recording)
            world = _lasting(world, recording)
    planned: Planned = ((), ())
    if player is None:
        trajectories, footholds = read_plan(folder)
        _check_robots(max(trajectories, default=-1) + 1, scenario, folder / PLAN, fewer=True)
        player = PlanPlayer(trajectories, scenario.models, scenario.starts)
        robots = range(len(scenario.models))
        planned = (
            tuple(trajectories.get(k) for k in robots),
            tuple(footholds.get(k, np.zeros((0, 6))) for k in robots),
        )
        missing = [str(k) for k in range(len(scenario.models)) if k not in trajectories]
        if missing:
            gaps.append(f"There is no trajectory of robot {', '.join(missing)}.")
    summary, gap = _summary(folder / SUMMARY)
    if gap:
        gaps.append(gap)
    parts = (summary, player, recording, planned, tuple(gaps))
    return Result(folder, scenario, world, start, *parts)


def _lasting(world: World, recording: Recording) -> World:
    """The world without the obstacles that the recording tells of."""
    fixed = fixed_shapes(world, recording)
    spans = [span for shape, span in zip(world.shapes, world.spans, strict=False) if shape in fixed]
    return replace(world, shapes=tuple(fixed), spans=tuple(spans))


def _check_robots(found: int, scenario: ResolvedScenario, file: Path, fewer: bool = False) -> None:
    wanted = len(scenario.models)
    if found > wanted or (found < wanted and not fewer):
        text = f"has {found} robots, but {SCENARIO} beside it has {wanted}"
        raise RecordingError(text, file=file)


def _summary(file: Path) -> tuple[Mapping[str, Any], str]:
    """The summary, and what is wrong with it."""
    if not file.is_file():
        return {}, f"There is no {SUMMARY}: the run was not finished."
    try:
        said = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        return {}, f"{SUMMARY} cannot be read."
    return said, ""


def _article(other: str) -> str:
    return (
        other
        if other.startswith("robot")
        else f"the {other}"
        if other == "ground"
        else f"an {other}"
    )
