"""From the words of a command to its exit code, by one small function per command.

What a command needs is imported when it runs. Exit codes: 0 done as asked; 1 not achieved; 2 bad
input, one line on stderr; 130 interrupted.
"""

from __future__ import annotations

import math
import os
import sys
import warnings
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cavalcade.cli import campaigns, options, ros2, studio
from cavalcade.errors import CavalcadeError, InputError, OutputError

if TYPE_CHECKING:
    from cavalcade.checking import Report, Violation
    from cavalcade.jobs import JobResult

BAD_INPUT, INTERRUPTED = 2, 130

# The base of everything typer says about a wrong option; some versions bring their own click.
_UsageError: type[Exception] = typer.BadParameter.__mro__[2]

app = typer.Typer(
    name="cavalcade",
    help="Motion planning and control for teams of quadruped robots.",
    add_completion=False,
    no_args_is_help=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _start(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Say the version and end.")] = False,
) -> None:
    if version:
        from cavalcade import __version__

        print(__version__)
    elif context.invoked_subcommand is None:
        print(context.get_help())


@app.command()
def run(
    scenario: options.ScenarioArgument,
    out: options.Out,
    seed: options.Seed = None,
    overrides: options.Set = None,
    backend: options.Backend = None,
    force: options.Force = False,
    realtime: options.Realtime = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Plan and carry out a scenario; leave recording, figures and replay in a folder."""
    loaded = options.load(scenario, overrides, seed, backend)
    from cavalcade.execution.real_time import terminated_as_interrupted
    from cavalcade.jobs import run as run_scenario

    with terminated_as_interrupted():
        result = run_scenario(loaded, out, force=force, realtime=realtime, quiet=quiet or as_json)
    _finish(loaded.name, result, as_json, "not achieved")


@app.command()
def check(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run.")],
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Judge what a run left, independently of the planner: 0 clean, 1 a violation."""
    from cavalcade.checking import check as check_directory

    report = check_directory(directory)
    if as_json:
        options.print_json({"ok": report.ok, **_finite(asdict(report))})
    elif report.violations:
        first, more = report.violations[0], len(report.violations) - 1
        rest = f" (and {more} more)" if more else ""
        print(f"{directory}: {first.kind} at {first.time:.2f} s: {_told(first)}{rest}")
    elif not quiet:
        print(f"{directory}: clean{_measured(report)}")
    if not report.ok:
        raise typer.Exit(1)


@app.command()
def warm(
    everything: Annotated[
        bool, typer.Option("--all", help="Uneven ground, physics and all variants, too.")
    ] = False,
    quiet: options.Quiet = False,
) -> None:
    """Compile ahead what runs and plans need, with progress."""
    from cavalcade.jobs import warming
    from cavalcade.jobs.reporter import Reporter

    with Reporter(quiet) as reporter:
        warming.warm(warming.all_needs(everything), reporter)
        reporter.say("all kernels are ready")


@app.command()
def scenarios(as_json: options.Json = False) -> None:
    """List the shipped scenarios."""
    from cavalcade.scenario import scenario_descriptions

    found = scenario_descriptions()
    if as_json:
        options.print_json(found)
        return
    width = max(map(len, found), default=0)
    for name, description in found.items():
        print(f"{name:<{width}}  {description}".rstrip())


@app.command()
def show(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|DIR",
            help="A shipped scenario's name, a file, or the folder of a live session.",
        ),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The picture; NAME.png if not given.")
    ] = None,
    seed: options.Seed = None,
    overrides: options.Set = None,
    quiet: options.Quiet = False,
) -> None:
    """Draw a scenario without running it, or what a live session recorded before it died."""
    if Path(scenario).is_dir():
        if out is not None or seed is not None or overrides:
            raise InputError("--out, --seed and --set are for scenarios, not for folders")
        _finish_session(Path(scenario), quiet)
        return
    from cavalcade.scenario import build_world, resolve_scenario

    loaded = resolve_scenario(options.load(scenario, overrides, seed, None))
    target = out if out is not None else Path(f"{options.file_name(loaded.name)}.png")
    options.check_picture(target)
    world = build_world(loaded)
    from cavalcade.drawing.overview import draw_scenario

    draw_scenario(loaded, world, target)
    if not quiet:
        print(target)


@app.command()
def schema(
    team: Annotated[bool, typer.Option("--team", help="That of team files instead.")] = False,
) -> None:
    """Print the JSON Schema of scenario files."""
    if team:
        from cavalcade.live.team_file import team_schema

        options.print_json(team_schema())
        return
    from cavalcade.scenario import scenario_schema

    options.print_json(scenario_schema())


app.command()(campaigns.campaign)
app.command()(campaigns.trial)
app.add_typer(ros2.app)
app.command()(studio.studio)


@app.command("import")
def import_file(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A problem file of db-CBS.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The scenario file to write.")],
    force: Annotated[bool, typer.Option("--force", help="Replace the file.")] = False,
    quiet: options.Quiet = False,
) -> None:
    """Write a problem file of another project as a scenario."""
    from cavalcade.scenario import build_world, dump_scenario, import_problem

    scenario = import_problem(file)
    build_world(scenario)
    if out.is_dir():
        raise OutputError(f"{out}: is a folder; expected the name of a scenario file")
    if out.exists() and not force:
        raise OutputError(f"{out}: is there already; --force replaces it")
    dump_scenario(scenario, out)
    if not quiet:
        print(out)


@app.command()
def plan(
    scenario: options.ScenarioArgument,
    out: options.Out,
    method: Annotated[
        str | None,
        typer.Option(
            "--method", metavar="NAME", help="Over the file: sequential, joint, cbs or auto."
        ),
    ] = None,
    seed: options.Seed = None,
    overrides: options.Set = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Plan a team whose robots have goals of their own; leave plan, figures and replay."""
    loaded = options.load(scenario, overrides, seed, None)
    from cavalcade.jobs import plan as plan_scenario

    result = plan_scenario(loaded, out, method, force=force, quiet=quiet or as_json)
    _finish(loaded.name, result, as_json, "no plan")


def _finish(name: str, result: JobResult, as_json: bool, otherwise: str) -> None:
    """Print the summary if it was asked for, and say why a job did not succeed."""
    if as_json:
        options.print_json(result.summary)
    if moved := result.summary.get("goal_moved_m"):
        off = "" if result.goals_on_map else "; it is off the map"
        text = f"{name}: the goal was moved by {moved:.2f} m to where the shape fits{off}"
        print(f"cavalcade: {text}", file=sys.stderr)
    if not result.success:
        raise options.not_achieved(name, result.reason, result.summary.get("detail"), otherwise)


def _told(violation: Violation) -> str:
    """The message, with what was touched unless the message says so itself."""
    said, touched = violation.message, violation.obstacle
    return said if touched in said else f"{said}; touched: {touched}"


def _measured(report: Report) -> str:
    found = report.figures
    if found is None:
        return ""
    return (
        f"; {found.robots} robots, {found.duration_s:.1f} s, "
        f"smallest gap {found.min_footprint_gap_m:.3f} m"
    )


def _finite(value: Any) -> Any:
    """The same plain data with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _finish_session(folder: Path, quiet: bool) -> None:
    """Make figures, replay and summary of a recording that has none."""
    from cavalcade.jobs import finish_recording

    if (folder / "summary.json").exists():
        raise InputError(
            "this run is finished: it has a summary, figures and a replay", file=folder
        )
    result = finish_recording(folder)
    if not quiet:
        print("\n".join(map(str, result.files)))


def run_command(arguments: Sequence[str] | None) -> int:
    """Run one command and give its exit code.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            code = app(
                args=None if arguments is None else list(arguments),
                prog_name="cavalcade",
                standalone_mode=False,
            )
            sys.stdout.flush()
        except typer.Abort:
            raise KeyboardInterrupt from None
        except CavalcadeError as error:
            return _refuse(str(error))
        except _UsageError as error:
            return _refuse(getattr(error, "format_message", error.__str__)())
        except BrokenPipeError:
            # Whoever read our output has seen enough. Nothing may be flushed into it at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except OSError as error:
            return _refuse(f"{error.filename or 'output'}: {error.strerror or error}")
    if code == INTERRUPTED:  # what typer makes of Ctrl-C
        raise KeyboardInterrupt
    return int(code or 0)


def _refuse(message: str) -> int:
    print(f"cavalcade: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print(f"cavalcade: warning: {' '.join(str(message).split())}", file=sys.stderr)
