"""A whole run: from a scenario to a folder of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cavalcade.drawing.physics.drawing import add_figures, replay_in_physics
from cavalcade.errors import InputError
from cavalcade.execution.control import Planner
from cavalcade.execution.progress import Progress, ProgressSink
from cavalcade.execution.simulation import simulate
from cavalcade.fleet import Fleet
from cavalcade.jobs.output_folder import FIGURES, RECORDING, REPLAY, OutputFolder
from cavalcade.jobs.reporter import Reporter
from cavalcade.metrics.summary import summarise
from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario, World, build_world, load_scenario, resolve_scenario
from cavalcade.scenario.backends import with_backend


@dataclass(frozen=True)
class RunResult:
    """What a run came to.

    Attributes:
        summary: The content of `summary.json`.
        recording: Every cycle.
        directory: The folder of the results, None if none was asked for.
        files: What was written there.
    """

    summary: dict[str, Any]
    recording: Recording
    directory: Path | None
    files: tuple[Path, ...]

    @property
    def success(self) -> bool:
        """The team arrived without a collision."""
        return bool(self.summary["success"])

    @property
    def reason(self) -> str:
        """Why it ended, as in `summary.json`."""
        return str(self.summary["reason"])


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
    progress: ProgressSink | None = None,
    planner: Callable[[Scenario, World], Planner] | None = None,
    fleet: Callable[[Scenario], Fleet] | None = None,
) -> RunResult:
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
        progress: Called with a `Progress` once per cycle.
        planner: Makes another planner than the scenario's.
        fleet: Makes another fleet than the scenario's.

    Raises:
        InputError: The scenario, its map or an argument cannot be used.
        OutputError: The results cannot be written; nothing is left behind then.
        KeyboardInterrupt: As it came; the team was commanded to stop and nothing is left behind.
    """
    loaded = load_for_running(scenario, seed, overrides, backend)
    in_physics = loaded.execution.backend == "mujoco" and fleet is None
    if in_physics:
        from cavalcade.execution.physics_fleet import with_own_robots
        from cavalcade.fleet.physics.engine import load_mujoco

        load_mujoco()
        loaded = with_own_robots(loaded)
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(Reporter(loaded.name, quiet))
        loaded = resolve_scenario(loaded)
        world = build_world(loaded)
        reporter.say(_preparing(loaded))

        def tell(now: Progress) -> None:
            reporter(now)
            if progress is not None:
                progress(now)

        sink = tell if progress is not None or not quiet else None
        make_robots = fleet
        if in_physics:
            from cavalcade.execution.physics_fleet import physics_fleet

            def make_robots(scenario: Scenario) -> Fleet:
                return physics_fleet(scenario, world)

        if loaded.task.individual and planner is None:
            from cavalcade.jobs.plan_and_run import carry_out

            return carry_out(
                loaded,
                world,
                folder,
                reporter,
                sink,
                realtime=realtime,
                figures=figures,
                replay=replay,
                quiet=quiet,
                fleet=make_robots,
            )
        made_planner = (planner or _default_planner)(loaded, world)
        made_fleet = (make_robots or _default_fleet)(loaded)
        done = simulate(loaded, world, made_planner, made_fleet, realtime=realtime, progress=sink)
        summary = summarise(loaded, world, done.recording, done.outcome)
        files: tuple[Path, ...] = ()
        if folder is not None:
            _write(folder.stage, loaded, world, done.recording, done.maps, summary)
            if figures:
                from cavalcade.drawing.formation import make_figures

                reporter.say("Drawing the figures ...")
                make_figures(loaded, world, done.recording, summary, folder.stage / FIGURES)
                add_figures(loaded, done.recording, folder.stage / FIGURES)
            if replay:
                _write_replay(loaded, world, done.recording, summary, folder.stage / REPLAY)
            files = folder.commit(loaded, summary)
        reporter.finish(summary, files)
    return RunResult(summary, done.recording, None if folder is None else folder.path, files)


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
        scenario = with_backend(scenario, backend)
    if seed is None or seed == scenario.execution.seed:
        return scenario
    if not isinstance(seed, int) or seed < 0:
        raise InputError(f"expected a whole number from 0 on, got {seed!r}", key="seed")
    execution = scenario.execution.model_copy(update={"seed": seed})
    return scenario.model_copy(update={"execution": execution})


def _preparing(scenario: Scenario) -> str:
    from cavalcade.jobs.warm import kernels_are_cached

    what = f"{scenario.name}: {len(scenario.robots)} robots"
    duration = "" if kernels_are_cached() else "about 20 s"
    if scenario.execution.backend == "mujoco" and not kernels_are_cached("locomotion", "_team.*"):
        duration = "about a minute"
    if not duration:
        return what
    return f"{what}; compiling the numerical kernels, once after installation ({duration}) ..."


def _default_planner(scenario: Scenario, world: World) -> Planner:
    from cavalcade.execution.team import make_planner

    return make_planner(scenario, world)


def _default_fleet(scenario: Scenario) -> Fleet:
    from cavalcade.execution.team import make_fleet

    return make_fleet(scenario)


def _write_replay(
    scenario: Scenario, world: World, recording: Recording, summary: dict[str, Any], path: Path
) -> None:
    if not replay_in_physics(scenario, world, recording, summary, path):
        from cavalcade.drawing.replay.formation import write_replay

        write_replay(scenario, world, recording, summary, path)


def _write(
    stage: Path,
    scenario: Scenario,
    world: World,
    recording: Recording,
    maps: Any,
    summary: dict[str, Any],
) -> None:
    from cavalcade.recording.mcap_writer import write_recording

    write_recording(stage / RECORDING, recording, scenario.models, maps)
