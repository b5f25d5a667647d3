"""A whole run: from a scenario to a folder of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.execution.loop import Execution, carry_out
from cavalcade.execution.policy import Policy
from cavalcade.fleet import Fleet
from cavalcade.jobs.output_folder import FIGURES, PLAN, RECORDING, REPLAY, OutputFolder
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.result import JobResult
from cavalcade.jobs.task import PolicyMaker, Task
from cavalcade.jobs.tasks import task_of
from cavalcade.metrics.summary import Summary
from cavalcade.recording.frames import FrameSink
from cavalcade.scenario import (
    ResolvedScenario,
    Scenario,
    build_world,
    load_scenario,
    resolve_scenario,
)


def run(
    scenario: Scenario | str | Path,
    out: str | Path | None = None,
    *,
    seed: int | None = None,
    overrides: Sequence[str] | Mapping[str, Any] = (),
    backend: str | None = None,
    realtime: bool = False,
    force: bool = False,
    figures: bool = True,
    replay: bool = True,
    quiet: bool = True,
    sinks: Sequence[FrameSink] = (),
    planner: PolicyMaker | Policy | None = None,
    fleet: Callable[[ResolvedScenario], Fleet] | Fleet | None = None,
) -> JobResult:
    """Plan and carry out a scenario.

    Args:
        scenario: A loaded one, a shipped scenario's name, or a file.
        out: The folder for the results, missing or empty; None writes nothing.
        seed: Over the scenario's.
        overrides: Over the file's values, as `load_scenario` takes them; only for a name or file.
        backend: Over the scenario's; `ideal`, or `mujoco` for walking robots with dynamics.
        realtime: At the pace of the wall clock instead of as fast as possible.
        force: Replace what an earlier run left in `out`.
        figures: Draw the figures.
        replay: Write the replay.
        quiet: Print nothing; otherwise progress, a table and the names of the files.
        sinks: Called with a `Frame` once per cycle.
        planner: Another policy than the scenario's, or a function of scenario and world that
            makes it.
        fleet: Other robots than the scenario's, at its starts, or a function of the scenario that
            makes them.

    Raises:
        InputError: The scenario, its map or an argument cannot be used.
        OutputError: The results cannot be written; nothing is left behind then.
        KeyboardInterrupt: As it came; the team was commanded to stop and nothing is left behind.
    """
    loaded = load_for_running(scenario, seed, overrides, backend)
    if loaded.execution.backend == "mujoco" and fleet is None:
        from cavalcade.execution.physics_fleet import with_own_robots
        from cavalcade.fleet.mujoco.engine import load_mujoco

        load_mujoco()
        loaded = with_own_robots(loaded)
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(Reporter(loaded.name, quiet))
        resolved = resolve_scenario(loaded)
        world = build_world(resolved)
        reporter.say(_preparing(resolved))
        reporter.timeout = resolved.execution.timeout
        task = task_of(resolved, world, reporter, planner)
        robots = _made(fleet, resolved) if fleet is not None else task.make_fleet()
        policy = task.make_policy(robots)
        done = carry_out(
            resolved,
            world,
            policy,
            robots,
            budget=task.budget,
            realtime=realtime,
            sinks=sinks if quiet else (reporter, *sinks),
        )
        summary = task.summarise(policy, done)
        files: tuple[Path, ...] = ()
        if folder is not None:
            _write(folder.stage, task, policy, done, summary, figures, replay)
            files = folder.commit(resolved, summary.to_dict())
        reporter.finish(summary, files)
    directory = None if folder is None else folder.path
    return JobResult(resolved, world, summary, done.recording, task.planned, directory, files)


def load_for_running(
    scenario: Scenario | str | Path,
    seed: int | None,
    overrides: Sequence[str] | Mapping[str, Any],
    backend: str | None,
) -> Scenario:
    """The scenario with what the caller says over it; arguments as of `run`.

    Raises:
        InputError: It or an argument cannot be used.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario, overrides=overrides, seed=seed)
    elif overrides:
        raise InputError("only for a scenario's name or file", key="overrides")
    if backend is not None:
        scenario = scenario.with_backend(backend)
    if seed is None or seed == scenario.execution.seed:
        return scenario
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"expected a whole number from 0 on, got {seed!r}", key="seed")
    execution = scenario.execution.model_copy(update={"seed": seed})
    return scenario.model_copy(update={"execution": execution})


def _made(fleet: Callable[[ResolvedScenario], Fleet] | Fleet, scenario: ResolvedScenario) -> Fleet:
    return fleet if isinstance(fleet, Fleet) else fleet(scenario)


def _preparing(scenario: Scenario) -> str:
    from cavalcade.jobs.warm import kernels_are_cached

    what = f"{scenario.name}: {len(scenario.robots)} robots"
    duration = "" if kernels_are_cached() else "about 20 s"
    if scenario.execution.backend == "mujoco" and not kernels_are_cached("locomotion", "_team.*"):
        duration = "about a minute"
    if not duration:
        return what
    return f"{what}; compiling the numerical kernels, once after installation ({duration}) ..."


def _write(
    stage: Path,
    task: Task,
    policy: Policy,
    done: Execution,
    summary: Summary,
    figures: bool,
    replay: bool,
) -> None:
    from cavalcade.recording.mcap_writer import write_recording
    from cavalcade.recording.plan_file import write_plan

    recording = done.recording
    write_recording(stage / RECORDING, recording, task.scenario.models, done.maps)
    if task.planned is not None:
        write_plan(stage / PLAN, task.planned.trajectories, task.planned.footholds)
    if figures:
        from cavalcade.drawing.physics.drawing import add_figures

        task.reporter.say("Drawing the figures ...")
        task.draw(recording, policy, summary, stage / FIGURES)
        add_figures(task.scenario, recording, stage / FIGURES)
    if replay:
        task.write_replay(recording, policy, summary, stage / REPLAY)
