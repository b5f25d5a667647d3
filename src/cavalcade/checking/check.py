"""The verdict on a result folder."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cavalcade.checking.arrival import (
    IDEAL,
    PHYSICS,
    Criterion,
    check_arrival,
    check_commands,
    check_own_arrival,
)
from cavalcade.checking.breaks import between, find_breaks
from cavalcade.checking.contact import bodies, common_clock, find_contacts
from cavalcade.checking.heights import read_heights
from cavalcade.checking.limits import TOLERANCE, Effort, exceeded, measure, with_own_limits
from cavalcade.checking.physics.leaps import check_leaps
from cavalcade.checking.physics.record import RobotRecord, read_records
from cavalcade.checking.physics.run import judge_motion
from cavalcade.checking.places import check_places
from cavalcade.checking.plans import judge_plan, read_plan
from cavalcade.checking.report import Figures, Report, Violation, make_report
from cavalcade.checking.scatter import Measured, measured, widened, within
from cavalcade.checking.solids import Scene, build_scene
from cavalcade.checking.tracks import (
    Track,
    broken_off,
    disordered,
    has_end,
    incomplete,
    joined,
    misplaced,
    read_tracks,
)
from cavalcade.errors import InputError, RecordingError
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario, load_scenario, resolve_scenario
from cavalcade.values import path_of

OWN_SPEEDING = 0.05
"""Robots on the way to goals of their own may exceed speed and yaw rate by this fraction."""

RECORDING, PLAN = "recording.mcap", "plan.npz"

SIMULATED = ("ideal", "mujoco")
"""Backends whose true poses are known; of robots of the real world there are measured ones."""


def check(directory: str | Path) -> Report:
    """Judge what `run` or `plan` left behind: recorded true poses or planned motion.

    Checked are contact of the swept, oriented footprints with obstacles, the map's occupied
    cells, its border and each other; the limits of speed and acceleration; completeness of the
    recording; the starts; and, where the summary claims success, arrival. Of plans also dynamics,
    forces, the ground and the footholds, see `judge_plan`.

    Of live robots poses are measured: what their scatter may explain is no violation (see
    `scatter`), what differences of noisy poses would say of speed and acceleration is not judged,
    and cycles may be late by half a second. Longer gaps and leaps that no robot can make are told,
    and nothing is swept across them (see `breaks`). A recording whose end is
    missing, because its writer was stopped, is judged as far as it goes, which is a violation.

    Args:
        directory: With `scenario.yaml`, `summary.json` and `recording.mcap` or `plan.npz`; where
            both are there, both are judged. Without a summary nothing is claimed: that is so
            where a recording has no end, and where a live session was not finished.

    Raises:
        RecordingError: One of them, or the map file that the scenario names, cannot be read.
    """
    folder = path_of(directory, "directory", RecordingError)
    if not folder.is_dir():
        raise RecordingError("there is no such folder", file=folder)
    scenario = _read_scenario(folder / "scenario.yaml")
    recording, plan = folder / RECORDING, folder / PLAN
    broken = recording.is_file() and not has_end(recording)
    live = recording.is_file() and scenario.execution.backend not in SIMULATED
    said = folder / "summary.json"
    summary = {} if (broken or live) and not said.exists() else _read_summary(said)
    individual = scenario.task.kind == "individual"
    if not plan.is_file() and (recording.is_file() or not individual):
        return _judge_recording(scenario, recording, summary)
    if not individual:
        raise RecordingError("there is a plan, but the scenario has a formation", file=plan)
    if not recording.is_file():
        return judge_plan(scenario, read_plan(plan), summary)
    run = _judge_recording(scenario, recording, summary)
    # The summary is that of the run: it says nothing of the plan's figures.
    planned = judge_plan(scenario, read_plan(plan), summary, figures=False)
    return make_report([*run.violations, *planned.violations], run.figures)


def judge(scenario: Scenario, tracks: tuple[Track, ...], summary: dict[str, Any]) -> Report:
    """The verdict on recorded motion of a resolved scenario's robots.

    Of the summary `success`, `goal_moved_m` and `sim_time_s` are looked at.

    Raises:
        RecordingError: The map file cannot be read.
    """
    scene = build_scene(scenario, read_heights(scenario))
    models, speeding = scenario.models, TOLERANCE
    if scenario.task.kind == "individual":
        leaps = scenario.world.has_heights
        models = tuple(with_own_limits(model, leaps) for model in models)
        speeding = OWN_SPEEDING
    if scenario.execution.backend not in SIMULATED:
        return _judge_live(scenario, scene, tracks, models, summary)
    violations, figures = judge_planar(scene, tracks, models, speeding)
    if figures is not None:
        violations += _claimed(scenario, tracks, summary, IDEAL)
        violations += check_places(scenario, scene, bool(summary.get("success")), violations)
    return make_report(violations, figures)


def _judge_live(
    scenario: Scenario,
    scene: Scene,
    tracks: tuple[Track, ...],
    models: tuple[RobotModel, ...],
    summary: dict[str, Any],
) -> Report:
    """As `judge`, of measured poses: as far as they are sure, and not across breaks."""
    if violations := disordered(tracks):
        return make_report(violations)
    breaks = find_breaks(tracks, models, scenario.execution.rate)
    violations = [one.told(len(tracks)) for one in breaks]
    seen: list[list[Measured]] = [[] for _ in tracks]
    figures: list[Figures] = []
    for stretch in between(tracks, breaks):
        team = [measured(part, whole) for part, whole in zip(stretch, tracks, strict=True)]
        for robot, one in enumerate(team):
            seen[robot] += [one] if len(one.track.time) else []
        motion = tuple(one.track for one in team)
        if not all(len(track.time) for track in motion):
            continue
        contacts, found = judge_planar(scene, motion, models, None)
        if any(one.sure for one in team):
            # The gap is that of whole footprints; what counts as contact is what surely is one.
            contacts, _ = judge_planar(scene, motion, within(models, team), None)
        violations += contacts
        figures += [] if found is None else [found]
    tracks = tuple(joined([one.track for one in parts]) for parts in seen)
    criterion = widened(PHYSICS, [parts[-1] for parts in seen])
    starts = [parts[0].start_error for parts in seen]
    violations += _claimed(scenario, tracks, summary, criterion, starts)
    violations += check_places(scenario, scene, bool(summary.get("success")), violations)
    return make_report(violations, _of_all(figures, tracks))


def judge_physics(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    records: tuple[RobotRecord, ...],
    summary: dict[str, Any],
) -> Report:
    """As `judge`, in physics: bodies, joints and contacts instead of footprints and limits.

    Raises:
        RecordingError: The map file cannot be read, or a robot has no description.
    """
    heights = read_heights(scenario)
    scene = build_scene(scenario, heights)
    violations = disordered(tracks)
    if violations:
        return make_report(violations)
    violations, gap, physics = judge_motion(scenario, tracks, records, summary, scene, heights)
    violations += _claimed(scenario, tracks, summary, PHYSICS)
    violations += check_places(scenario, scene, bool(summary.get("success")), violations)
    if summary.get("success") and scenario.task.kind == "commands":
        violations += check_leaps(scenario, records, heights)
    efforts = [measure(track, model) for track, model in zip(tracks, scenario.models, strict=True)]
    duration = max(float(track.time[-1] - track.time[0]) for track in tracks)
    return make_report(violations, replace(_figures(efforts, duration, gap), physics=physics))


def judge_planar(
    scene: Scene,
    tracks: tuple[Track, ...],
    models: tuple[RobotModel, ...],
    speeding: float | None = TOLERANCE,
) -> tuple[list[Violation], Figures | None]:
    """Contact between samples and limits of planar motion; no figures if its time is in disorder.

    Speed and yaw rate may exceed their limits by the fraction `speeding`; None judges no limits.
    """
    violations = disordered(tracks)
    if violations:
        return violations, None
    efforts = [measure(track, model) for track, model in zip(tracks, models, strict=True)]
    ticks = common_clock(tracks, scene.solids)
    violations, gap = find_contacts(scene, bodies(tracks, models, ticks), ticks)
    if speeding is not None:
        for robot, (effort, model) in enumerate(zip(efforts, models, strict=True)):
            violations += exceeded(effort, model, robot, speeding)
    return violations, _figures(efforts, float(ticks[-1] - ticks[0]), gap)


def _claimed(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    summary: dict[str, Any],
    criterion: Criterion,
    unsure: Sequence[tuple[float, float]] | None = None,
) -> list[Violation]:
    """Starts, samples and, where the summary claims success, what of the task was not done.

    Starts are `unsure` by so much for each robot, m and rad; None for not at all.
    """
    violations = misplaced(tracks, scenario.starts, unsure)
    live = scenario.execution.backend not in SIMULATED
    end = _number(summary, "sim_time_s")
    violations += incomplete(tracks, scenario.execution.rate, end, live)
    if not summary.get("success"):
        return violations
    match scenario.task.kind:
        case "commands":
            return violations + check_commands(scenario, tracks)
        case "individual":
            return violations + check_own_arrival(scenario, tracks, criterion)
        case "formation":
            moved = _number(summary, "goal_moved_m") or 0.0
            return violations + check_arrival(scenario, tracks, moved, criterion)


def _judge_recording(scenario: Scenario, path: Path, summary: dict[str, Any]) -> Report:
    robots = len(scenario.robots)
    tracks = read_tracks(path, robots)
    if scenario.execution.backend == "mujoco":
        report = judge_physics(scenario, tracks, read_records(path, robots), summary)
    else:
        report = judge(scenario, tracks, summary)
    if has_end(path):
        return report
    return make_report([*report.violations, broken_off(tracks)], report.figures)


def _figures(efforts: list[Effort], duration: float, gap: float) -> Figures:
    def largest(name: str) -> float:
        return max(float(getattr(effort, name).max(initial=0.0)) for effort in efforts)

    return Figures(
        robots=len(efforts),
        duration_s=duration,
        min_footprint_gap_m=gap,
        max_speed_ratio=largest("speed_ratio"),
        max_yaw_rate=largest("yaw_rate"),
        max_acceleration=largest("acceleration"),
        max_yaw_acceleration=largest("yaw_acceleration"),
    )


def _of_all(stretches: list[Figures], tracks: tuple[Track, ...]) -> Figures | None:
    """The figures of motion that was seen in stretches; None if never all robots were."""
    if not stretches:
        return None

    def largest(name: str) -> float:
        return max(float(getattr(one, name)) for one in stretches)

    first = min(track.time[0] for track in tracks)
    last = max(track.time[-1] for track in tracks)
    return Figures(
        robots=len(tracks),
        duration_s=float(last - first),
        min_footprint_gap_m=min(one.min_footprint_gap_m for one in stretches),
        max_speed_ratio=largest("max_speed_ratio"),
        max_yaw_rate=largest("max_yaw_rate"),
        max_acceleration=largest("max_acceleration"),
        max_yaw_acceleration=largest("max_yaw_acceleration"),
    )


def _read_scenario(path: Path) -> Scenario:
    if not path.is_file():
        raise RecordingError("there is no such file", file=path)
    try:
        return resolve_scenario(load_scenario(path))
    except InputError as error:
        raise RecordingError(str(error)) from error


def _read_summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=path) from error
    except ValueError as error:
        raise RecordingError("expected JSON", file=path) from error
    if not isinstance(summary, dict):
        raise RecordingError("expected a mapping of the summary's keys", file=path)
    return summary


def _number(summary: dict[str, Any], key: str) -> float | None:
    value = summary.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
