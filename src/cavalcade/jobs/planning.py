"""A whole planning job: from a scenario to a folder with a plan."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cavalcade.coordination.result import TeamPlan
from cavalcade.jobs.footholds import plan_feet
from cavalcade.jobs.output_folder import FIGURES, PLAN, REPLAY, OutputFolder
from cavalcade.jobs.plan_reporter import PlanReporter
from cavalcade.jobs.plan_settings import require_own_goals, settings_of, with_method
from cavalcade.jobs.running import load_for_running
from cavalcade.metrics.plan_result import PlanResult
from cavalcade.metrics.plan_summary import summarise_plan
from cavalcade.recording.plan_file import write_plan
from cavalcade.scenario import Scenario, World, build_world, resolve_scenario

Coordinator = Callable[[Scenario, World], TeamPlan]
"""What makes a team plan; tests and users may bring their own."""


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
) -> PlanResult:
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
    loaded = with_method(loaded, method)
    require_own_goals(loaded)
    with ExitStack() as stack:
        folder = stack.enter_context(OutputFolder(out, force)) if out is not None else None
        reporter = stack.enter_context(PlanReporter(loaded, quiet))
        resolved = resolve_scenario(loaded)
        world = build_world(resolved)
        made = make_plan(resolved, world, coordinator, reporter)
        files: tuple[Path, ...] = ()
        if folder is not None:
            write_plan(folder.stage / PLAN, made.plan.trajectories, made.footholds)
            if figures:
                from cavalcade.drawing.plans import make_plan_figures

                reporter.say("drawing the figures")
                make_plan_figures(resolved, world, made, folder.stage / FIGURES)
            if replay:
                from cavalcade.drawing.replay.plan import write_plan_replay

                write_plan_replay(resolved, world, made, folder.stage / REPLAY)
            files = folder.commit(resolved, made.summary)
        reporter.finish(made.summary, files)
    return PlanResult(
        made.plan, made.footholds, made.summary, None if folder is None else folder.path, files
    )


def make_plan(
    scenario: Scenario,
    world: World,
    coordinator: Coordinator | None = None,
    reporter: PlanReporter | None = None,
) -> PlanResult:
    """Plan and judge, without files.

    Args:
        scenario: Resolved, with goals of single robots.
        world: Its ground.
        coordinator: Instead of the scenario's method.
        reporter: Told what goes on.
    """
    started = clock.perf_counter()
    with reporter or PlanReporter(scenario, quiet=True) as telling:
        with telling.planning():
            team = (coordinator or coordinate)(scenario, world)
        footholds, stretches = plan_feet(scenario, world, team.trajectories)
        summary = summarise_plan(scenario, world, team, stretches, clock.perf_counter() - started)
    return PlanResult(team, footholds, summary, None, ())


def coordinate(scenario: Scenario, world: World) -> TeamPlan:
    """The plan of the scenario's own method."""
    from cavalcade.coordination import plan_team, problem_of

    return plan_team(
        problem_of(scenario, world),
        scenario.planner.method,
        settings_of(scenario),
        scenario.seed,
    )
