"""The folder of a live session: begun before robots move, filled while they do, finished after.

What a session leaves if it dies has the scenario and the recording; `finish_recording` makes the
rest of it at any time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import OutputError, RecordingError
from cavalcade.execution.loop import Outcome
from cavalcade.files import make_folders, reason_of
from cavalcade.geometry import Array
from cavalcade.jobs.output_folder import (
    FIGURES,
    PLAN,
    RECORDING,
    REPLAY,
    SCENARIO,
    SUMMARY,
    write_summary,
)
from cavalcade.jobs.running import JobResult
from cavalcade.metrics.run_summary import summarise
from cavalcade.metrics.summary import CycleTimes
from cavalcade.recording.frames import Recording
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.mcap_reader import read_recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel
from cavalcade.scenario import (
    FormationSection,
    Scenario,
    build_world,
    dump_scenario,
    load_scenario,
    parse_scenario,
    resolve_scenario,
)
from cavalcade.scenario.settings import UnitreeSection
from cavalcade.values import path_of
from cavalcade.world import OccupancyMap, save_map

MAP = "map.yaml"
"""The map at the start, in the folder."""

_LONGEST = 86_400.0
"""Of a session, as scenarios allow it, s."""


def record_live(
    out: str | Path,
    *,
    name: str,
    models: Sequence[RobotModel],
    starts: Array,
    area: OccupancyMap,
    rate: float,
    backend: str,
    formation: FormationSection | None = None,
    names: Sequence[str] | None = None,
    unitree: UnitreeSection | None = None,
    force: bool = False,
) -> LiveRecording:
    """Begin a folder with the map and a scenario that describes the session, and its recording.

    Args:
        out: The folder, missing or empty.
        name: Of the session.
        models: One per robot.
        starts: `(N, 3)` where they stand now, map frame.
        area: The map.
        rate: Cycles per second, Hz.
        backend: `ros2`, for example.
        formation: The shape; None for goals of single robots.
        names: What the robots are called.
        unitree: Where Go2s are on the network, which backend `unitree` asks for.
        force: Write into a folder that holds something; what a session left there is replaced.

    Raises:
        InputError: A value does not fit a scenario.
        OutputError: The folder cannot be written to.
    """
    folder = path_of(out, "out")
    make_folders(folder)
    if not force and any(folder.iterdir()):
        raise OutputError(f"{folder}: the folder is not empty; name another one or use --force")
    try:
        pictures = (folder / FIGURES).glob("*.png")
        for old in (*(folder / left for left in (SUMMARY, REPLAY, PLAN)), *pictures):
            old.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {reason_of(error)}") from None
    save_map(area, folder / MAP)
    poses = np.asarray(starts, dtype=float).tolist()
    robots: list[dict[str, Any]] = [
        {"model": model.name, "start": pose} for model, pose in zip(models, poses, strict=True)
    ]
    if formation is None:
        robots = [robot | {"goal": robot["start"]} for robot in robots]
        task: dict[str, Any] = {"goals": "individual"}
    else:
        said = formation.model_dump(mode="json", exclude_none=True)
        task = {"formation": said, "goals": [np.mean(poses, axis=0).tolist()]}
    execution: dict[str, Any] = {"backend": backend, "rate": rate, "timeout": _LONGEST}
    if unitree is not None:
        execution["unitree"] = unitree.model_dump(mode="json")
    scenario = parse_scenario(
        {
            "version": 1,
            "name": name,
            "world": {"map": MAP},
            "robots": robots,
            "task": task,
            "execution": execution,
        },
        folder / SCENARIO,
    ).with_models(models)
    dump_scenario(scenario, folder / SCENARIO)
    return LiveRecording(folder / RECORDING, models, names)


def finish_recording(
    directory: str | Path,
    reason: str = "",
    detail: str = "",
    *,
    figures: bool = True,
    replay: bool = True,
) -> JobResult:
    """Make summary, figures and replay of a folder that has a scenario and a recording.

    The scenario's goals become those that the recording tells of.

    Args:
        directory: As `record_live` began it, also if the session died since.
        reason: Why it ended, as in `summary.json`. If nothing is said, it is `arrived` where the
            team stood at its last goal, else `crashed` if the recording's end is missing, else
            `stopped`.
        detail: A line about the reason.
        figures: Draw the figures.
        replay: Write the replay.

    Raises:
        RecordingError: Scenario or recording cannot be read, or nothing was recorded.
        OutputError: A file cannot be written.
    """
    folder = path_of(directory, "directory", RecordingError)
    if not (folder / SCENARIO).is_file():
        raise RecordingError("there is no such file", file=folder / SCENARIO)
    recording = read_recording(folder)
    if not len(recording.time):
        raise RecordingError("nothing was recorded", file=folder / RECORDING)
    scenario = _as_it_came(load_scenario(folder / SCENARIO), recording)
    dump_scenario(scenario, folder / SCENARIO)
    resolved = resolve_scenario(scenario)
    world = build_world(resolved)
    if not reason:
        arrived = recording.status[-1].arrived
        reason = "arrived" if arrived else "stopped" if recording.ended else "crashed"
    if not recording.ended and not detail:
        detail = f"the recording breaks off at {recording.time[-1]:.2f} s"
    span = float(recording.time[-1] - recording.time[0])
    outcome = Outcome(reason, detail, (), span, np.zeros(0))
    # Nobody recorded how long the planner took.
    summary = replace(
        summarise(resolved, world, recording, outcome),
        cycle_ms=CycleTimes(),
        planning_time_s=None,
        sim_time_s=round(span, 6),
    )
    return _with_files(JobResult(resolved, world, summary, recording), folder, figures, replay)


def _with_files(result: JobResult, folder: Path, figures: bool, replay: bool) -> JobResult:
    scenario, world, summary = result.scenario, result.world, result.summary
    files = [folder / SCENARIO, folder / RECORDING]
    if figures:
        from cavalcade.drawing.figures import make_figures

        files += make_figures(scenario, world, folder / FIGURES, recording=result.recording)
    if replay:
        from cavalcade.drawing.replay.page import write_replay

        page = folder / REPLAY
        files.append(
            write_replay(page, scenario, world, recording=result.recording, summary=summary)
        )
    write_summary(folder / SUMMARY, summary.to_dict())
    return replace(result, directory=folder, files=(folder / SUMMARY, *files))


def _as_it_came(scenario: Scenario, recording: Recording) -> Scenario:
    """The scenario with the goals, and the last shape, that the team was given."""
    status = recording.status
    if scenario.goals:  # of single robots
        targets = next((one.targets for one in reversed(status) if one.targets is not None), None)
        if targets is None:
            return scenario
        robots = tuple(
            robot.model_copy(update={"goal": tuple(goal.tolist())})
            if np.isfinite(goal).all()
            else robot
            for robot, goal in zip(scenario.robots, targets, strict=True)
        )
        return scenario.model_copy(update={"robots": robots})
    goals = [tuple(one.goal.tolist()) for one in status if one.goal is not None]
    if not scenario.task.goals or not goals:
        return scenario
    found = (goals[0], *(new for old, new in pairwise(goals) if new != old))
    task = scenario.task.model_copy(update={"goals": found} | _last_shape(status))
    return scenario.model_copy(update={"task": task})


def _last_shape(status: Sequence[PlannerStatus]) -> dict[str, FormationSection]:
    """The shape that the team had at the end, if it had more than one."""
    shapes = [one.slots for one in status if len(one.slots)]
    if not shapes or np.array_equal(shapes[0], shapes[-1]):
        return {}
    slots = tuple((float(x), float(y)) for x, y in shapes[-1])
    return {"formation": FormationSection(shape="custom", slots=slots)}
