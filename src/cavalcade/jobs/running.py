"""Whole jobs, from a scenario to a folder of results: `run` and `plan`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cavalcade.coordination.result import TeamPlan
from cavalcade.errors import InputError
from cavalcade.execution.loop import carry_out
from cavalcade.execution.policy import Policy
from cavalcade.execution.steering import Steering
from cavalcade.fleet import Fleet, LiveFleet
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.jobs.output_folder import FIGURES, PLAN, RECORDING, REPLAY, OutputFolder
from cavalcade.jobs.planning import Coordinator, make_plan
from cavalcade.jobs.reporter import JobReporter
from cavalcade.jobs.tasks import TASKS, PolicyMaker
from cavalcade.jobs.warming import Needs, needs_of, warm
from cavalcade.metrics.plan_summary import PlanResult
from cavalcade.metrics.summary import Summary
from cavalcade.recording.frames import FrameSink, Recording
from cavalcade.recording.plan_file import write_plan
from cavalcade.scenario import (
    ResolvedScenario,
    Scenario,
    World,
    build_world,
    load_scenario,
    resolve_scenario,
)
from cavalcade.scenario.settings import TEAM_METHODS
from cavalcade.values import described, instances_of, whole_number


@dataclass(frozen=True)
class JobResult:
    """What `run` or `plan` was made of and what came out.

    Attributes:
        scenario: The resolved one.
        world: Its ground at the start.
        summary: The content of `summary.json`, also as a mapping.
        recording: Every cycle; None where nothing was carried out.
        planned: The plan as it was made, with its footholds; None for tasks that need none.
        directory: The folder of the results, None if none was asked for.
        files: What was written there.
    """

    scenario: ResolvedScenario
    world: World
    summary: Summary
    recording: Recording | None = None
    planned: PlanResult | None = None
    directory: Path | None = None
    files: tuple[Path, ...] = ()

    @property
    def success(self) -> bool:
        """It was done as asked, without a collision."""
        return self.summary.success

    @property
    def solved(self) -> bool:
        """The same, as one says it of a plan."""
        return self.summary.success

    @property
    def reason(self) -> str:
        """Why it ended, as in `summary.json`."""
        return self.summary.reason

    @property
    def goals_on_map(self) -> bool:
        """Whether the centres of all goals that the formation began with lie on the map."""
        centres = [goal[:2] for goal in self.scenario.task.goals]
        return not centres or bool(self.world.map.contains(centres).all())

    @property
    def plan(self) -> TeamPlan | None:
        """The coordinator's answer."""
        return None if self.planned is None else self.planned.plan

    @property
    def trajectories(self) -> tuple[Trajectory | None, ...]:
        """One per robot, map frame; see `TeamPlan.trajectories` for unsolved problems."""
        return () if self.planned is None else self.planned.trajectories

    @property
    def footholds(self) -> tuple[Array, ...]:
        """Per robot `(M, 6)` t_down, t_up (s), leg, x, y, z (m, map frame)."""
        return () if self.planned is None else self.planned.footholds


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
    steering: Steering | None = None,
) -> JobResult:
    """Plan and carry out a scenario.

    Args:
        scenario: A loaded one, a shipped scenario's name, or a file.
        out: The folder for the results, missing or empty; None writes nothing.
        seed: Over the scenario's.
        overrides: Over the file's values, as `load_scenario` takes them; only for a name or file.
        backend: Over the scenario's; `ideal`, `mujoco` for walking robots with dynamics, `ros2`
            for robots `robot_0` and so on of a ROS 2 graph, or `unitree` for Go2s without ROS;
            these stand at their starts.
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
        steering: By which other threads pause a simulated run and change it on its way; the
            result's scenario has what happened among its events.

    Raises:
        InputError: The scenario, its map or an argument cannot be used.
        OutputError: The results cannot be written; nothing is left behind then.
        FleetError: Robots of the real world are not heard.
        KeyboardInterrupt: As it came; the team was commanded to stop and nothing is left behind.
    """
    loaded = _loaded(scenario, seed, overrides, backend)
    for sink in instances_of(sinks, object, "sinks", "a list of functions"):
        _check_callable(sink, "sinks")
    for maker, kind, key in ((planner, Policy, "planner"), (fleet, Fleet, "fleet")):
        if maker is not None and not isinstance(maker, kind):
            _check_callable(maker, key)
    if loaded.execution.backend == "mujoco" and fleet is None:
        from cavalcade.execution.fleets import with_own_robots
        from cavalcade.fleet.mujoco.engine import load_mujoco

        load_mujoco()
        loaded = with_own_robots(loaded)
    if loaded.execution.backend == "unitree" and fleet is None:
        from cavalcade.fleet.unitree import load_sdk

        load_sdk()
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(JobReporter(loaded.name, quiet))
        resolved = resolve_scenario(loaded)
        world = build_world(resolved)
        reporter.say(f"{resolved.name}: {len(resolved.robots)} robots")
        backend = resolved.execution.backend if fleet is None else "ideal"
        needs = needs_of(resolved, backend) if planner is None else Needs("commands", backend)
        warm([needs], reporter)
        reporter.expect(resolved)
        task = TASKS[resolved.task.kind](resolved, world, reporter, planner)
        robots = task.make_fleet() if fleet is None else fleet
        if isinstance(robots, type) or not isinstance(robots, Fleet):
            robots = robots(resolved)  # a class that makes fleets has all their attributes, too
        if isinstance(robots, LiveFleet) and fleet is None:
            stack.callback(robots.close)
        policy = task.make_policy(robots)
        if steering is not None:
            stack.callback(steering.end)
            steering.begin(resolved, robots)
        done = carry_out(
            resolved,
            world,
            policy,
            robots,
            budget=task.budget,
            realtime=realtime,
            sinks=sinks if quiet else (reporter, *sinks),
            steering=steering,
        )
        if steering is not None:
            task.scenario = resolved = resolve_scenario(steering.scenario)
        reporter.complete()
        summary = task.summarise(policy, done)
        result = JobResult(resolved, world, summary, done.recording, task.planned)
        if folder is not None:
            from cavalcade.recording.mcap_writer import write_recording

            write_recording(folder.stage / RECORDING, done.recording, resolved.models, done.maps)
            driven = task.driven_plan(policy, done.recording, summary)
            result = _kept(result, folder, reporter, driven, figures, replay)
        reporter.finish(summary, result.files)
    return result


def plan(
    scenario: Scenario | str | Path,
    out: str | Path | None = None,
    method: str | None = None,
    seed: int | None = None,
    *,
    overrides: Sequence[str] | Mapping[str, Any] = (),
    force: bool = False,
    figures: bool = True,
    replay: bool = True,
    quiet: bool = True,
    coordinator: Coordinator | None = None,
) -> JobResult:
    """Plan the motion of robots that have goals of their own.

    Args:
        scenario: A loaded one, a shipped scenario's name, or a file.
        out: The folder for the results, missing or empty; None writes nothing.
        method: `sequential`, `joint`, `cbs` or `auto`, over the scenario's.
        seed: Over the scenario's.
        overrides: Over the file's values, as `load_scenario` takes them; only for a name or file.
        force: Replace what an earlier job left in `out`.
        figures: Draw the figures.
        replay: Write the replay.
        quiet: Print nothing; otherwise progress, a table and the names of the files.
        coordinator: Makes another plan than the scenario's method would.

    Raises:
        InputError: The scenario, its world or an argument cannot be used; formation goals too.
        OutputError: The results cannot be written; nothing is left behind then.
    """
    loaded = _loaded(scenario, seed, overrides, None)
    if method is not None and method != loaded.planner.method:
        if not isinstance(method, str) or method not in TEAM_METHODS:
            raise InputError(
                f"unknown method {described(method)}", key="method", choices=TEAM_METHODS
            )
        planner = loaded.planner.model_copy(update={"method": method})
        loaded = loaded.model_copy(update={"planner": planner})
    if not loaded.goals:
        raise InputError(
            "plan is for robots with goals of their own (task.goals: individual); "
            "use `cavalcade run` for formations",
            file=loaded.file or loaded.name,
            key="task.goals",
        )
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(JobReporter(loaded.name, quiet))
        resolved = resolve_scenario(loaded)
        world = build_world(resolved)
        warm([needs_of(resolved, None)], reporter)
        made = make_plan(resolved, world, coordinator, reporter)
        result = JobResult(resolved, world, made.summary, None, made)
        if folder is not None:
            result = _kept(result, folder, reporter, made, figures, replay)
        reporter.finish(made.summary, result.files)
    return result


def _kept(
    result: JobResult,
    folder: OutputFolder,
    reporter: JobReporter,
    shown: PlanResult | None,
    figures: bool,
    replay: bool,
) -> JobResult:
    """The result with its files, which show this plan; the recording is there already."""
    scenario, world, recording = result.scenario, result.world, result.recording
    if result.planned is not None:
        write_plan(folder.stage / PLAN, result.trajectories, result.footholds)
    if figures:
        from cavalcade.drawing.figures import make_figures

        reporter.say("Drawing the figures ...")
        make_figures(scenario, world, folder.stage / FIGURES, recording=recording, plan=shown)
    if replay:
        from cavalcade.drawing.replay.page import write_replay

        page, summary = folder.stage / REPLAY, result.summary
        write_replay(page, scenario, world, recording=recording, plan=shown, summary=summary)
    files = folder.commit(scenario, result.summary.to_dict())
    return replace(result, directory=folder.path, files=files)


def _check_callable(value: object, key: str) -> None:
    """Refuse what cannot be called."""
    if not callable(value):
        raise InputError(f"expected a function, got {described(value)}", key=key)


def _loaded(
    scenario: Scenario | str | Path,
    seed: int | None,
    overrides: Sequence[str] | Mapping[str, Any],
    backend: str | None,
) -> Scenario:
    """The scenario with what the caller says over it; arguments as of `run`."""
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario, overrides=overrides, seed=seed)
    elif overrides:
        raise InputError("only for a scenario's name or file", key="overrides")
    if backend is not None:
        scenario = scenario.with_backend(backend)
    if seed is None:
        return scenario
    seed = whole_number(seed, "seed", 0)
    if seed == scenario.execution.seed:
        return scenario
    execution = scenario.execution.model_copy(update={"seed": seed})
    return scenario.model_copy(update={"execution": execution})
