"""A whole planning job: from a scenario to a folder with a plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.jobs.individual_task import Coordinator, make_plan
from cavalcade.jobs.output_folder import FIGURES, PLAN, REPLAY, OutputFolder
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.result import JobResult
from cavalcade.jobs.running import load_for_running
from cavalcade.recording.plan_file import write_plan
from cavalcade.scenario import Scenario, build_world, resolve_scenario
from cavalcade.scenario.settings import TEAM_METHODS


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
    loaded = load_for_running(scenario, seed, overrides, None)
    loaded = _with_method(loaded, method)
    _require_own_goals(loaded)
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(Reporter(loaded.name, quiet))
        resolved = resolve_scenario(loaded)
        world = build_world(resolved)
        made = make_plan(resolved, world, coordinator, reporter)
        files: tuple[Path, ...] = ()
        if folder is not None:
            write_plan(folder.stage / PLAN, made.trajectories, made.footholds)
            if figures:
                from cavalcade.drawing.plans import make_plan_figures

                reporter.say("Drawing the figures ...")
                make_plan_figures(resolved, world, made, folder.stage / FIGURES)
            if replay:
                from cavalcade.drawing.replay.page import write_replay

                path = folder.stage / REPLAY
                write_replay(path, resolved, world, plan=made, summary=made.summary)
            files = folder.commit(resolved, made.summary.to_dict())
        reporter.finish(made.summary, files)
    directory = None if folder is None else folder.path
    return JobResult(resolved, world, made.summary, None, made, directory, files)


def _require_own_goals(scenario: Scenario) -> None:
    """Refuse a scenario whose goals are those of a formation.

    Raises:
        InputError: It is one.
    """
    if not scenario.goals:
        raise InputError(
            "plan is for robots with goals of their own (task.goals: individual); "
            "use `cavalcade run` for formations",
            file=scenario.file or scenario.name,
            key="task.goals",
        )


def _with_method(scenario: Scenario, method: str | None) -> Scenario:
    """The scenario with another method; itself if that is None.

    Raises:
        InputError: There is no such method.
    """
    if method is None or method == scenario.planner.method:
        return scenario
    if method not in TEAM_METHODS:
        raise InputError(f"unknown method {method!r}", key="method", choices=TEAM_METHODS)
    planner = scenario.planner.model_copy(update={"method": method})
    return scenario.model_copy(update={"planner": planner})
