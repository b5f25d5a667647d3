"""The commands on campaigns: `campaign` and `trial`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cavalcade.cli import options

if TYPE_CHECKING:
    from cavalcade.campaign.repeat import Repeated

Data = Annotated[
    Path | None,
    typer.Option(
        "--data",
        metavar="DIR",
        help="Where the data of other projects are; else CAVALCADE_DATA, data, ../shared/data.",
    ),
]


def campaign(
    suite: Annotated[
        str, typer.Argument(metavar="SUITE", help="A shipped suite's name, or a file.")
    ],
    out: options.Out,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", help="Trials at a time; one per core if not given."),
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            "--engine", metavar="NAME", help="Where trials are carried out: local or ray."
        ),
    ] = "local",
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the campaign that DIR holds.")
    ] = False,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", help="The first seed of every group.")
    ] = None,
    seeds: Annotated[
        int | None, typer.Option("--seeds", metavar="N", help="How many worlds of every group.")
    ] = None,
    overrides: options.Set = None,
    backend: options.Backend = None,
    data: Data = None,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Run a suite's trials, each judged by the checker; leave lines, table and report."""
    from cavalcade.campaign.definition import check_definition, define_campaign
    from cavalcade.campaign.engines import make_engine
    from cavalcade.campaign.runner import CampaignInterrupted, run_campaign

    said = list(overrides or [])
    if backend is not None:
        said.append(f"execution.backend={backend}")
    definition = define_campaign(suite, overrides=said, seed=seed, seeds=seeds, data=data)
    missing = definition.suite.missing(definition.data)
    if missing is not None:
        print(f"cavalcade: {definition.suite.name}: {missing}", file=sys.stderr)
        raise typer.Exit(1)
    check_definition(definition)
    made = make_engine(engine, workers)
    command = ["cavalcade", "campaign", suite, "--out", str(out)]
    command += _said(seed=seed, seeds=seeds, data=data, backend=backend)
    for text in overrides or ():
        command += ["--set", text]
    where = _said(workers=workers, engine=None if engine == "local" else engine)
    try:
        result = run_campaign(
            definition,
            out,
            made,
            resume=resume,
            quiet=quiet or as_json,
            command=shlex.join(command),
        )
    except CampaignInterrupted as stop:
        print(
            f"cavalcade: {stop.done} of {stop.total} trials are done; go on with: "
            f"{shlex.join([*command, *where, '--resume'])}",
            file=sys.stderr,
        )
        raise
    if as_json:
        options.print_json(result.summary | {"files": [str(file) for file in result.files]})
    elif not quiet:
        _print_groups(result.summary)
        for file in result.files:
            print(file)


def trial(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a campaign.")],
    trial_id: Annotated[str, typer.Argument(metavar="ID", help="The trial, as in trials.jsonl.")],
    out: options.Out,
    data: Data = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Repeat one trial of a campaign bit for bit, with recording, figures and replay."""
    from cavalcade.campaign.repeat import repeat_trial

    done = repeat_trial(directory, trial_id, out, data=data, force=force, quiet=quiet or as_json)
    if done.same is False:
        _warn_of_difference(done)
    line = done.line
    if as_json:
        options.print_json(line)
    elif not quiet:
        again = "; the same as in the campaign" if done.same else ""
        print(f"{trial_id}: {line['outcome']}, {_judgement(line)}{again}")
    if not line["success"]:
        detail = line["detail"] or next(iter(line["violations"]), "")
        raise options.not_achieved(trial_id, line["outcome"], detail)


def _said(**options: Any) -> list[str]:
    """The options that were given, as words of the command."""
    words = []
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", str(value)]
    return words


def _judgement(line: dict[str, Any]) -> str:
    if line["success"]:
        unavoidable = line["contacts"] - line["avoidable"]
        return f"{unavoidable} unavoidable collisions" if unavoidable else "clean"
    return f"{line['contacts']} collisions, {line['avoidable']} of them avoidable"


def _warn_of_difference(done: Repeated) -> None:
    from cavalcade import __version__

    why = "another machine or other versions of its packages?"
    before = done.before or {}
    if before.get("outcome") in ("crashed", "overtime"):
        why = f"there it was {before['outcome']}: {before.get('detail')}"
    elif done.version != __version__:
        why = f"it was run with version {done.version}, this is {__version__}"
    print(f"cavalcade: warning: not as in the campaign: {why}", file=sys.stderr)


def _print_groups(summary: dict[str, Any]) -> None:
    """A row per group, disturbance and variant, as narrow as it will go."""
    groups = summary["groups"]
    names = ["scenario", "disturbance", "variant"]
    names = [name for name in names if len({group[name] for group in groups}) > 1] or names[:1]
    rows = [[*names, "trials", "feasible", "succeeded", "", "collisions", "avoidable"]]
    for group in groups:
        feasible, succeeded = group["feasible"], group["success_of_feasible"]
        if group.get("hopeless"):  # refusing is the success
            succeeded = group["refused"]
            share = f"{100.0 * succeeded / group['hopeless']:.1f} %"
        else:
            share = f"{100.0 * succeeded / feasible:.1f} %" if feasible else "-"
        counts = [group["trials"], feasible, succeeded, share]
        counts += [group["contacts"], group["avoidable"]]
        rows.append([*(group[name] for name in names), *map(str, counts)])
    forms = [
        f"{'<' if place < len(names) else '>'}{max(map(len, column))}"
        for place, column in enumerate(zip(*rows, strict=True))
    ]
    for row in rows:
        print("  ".join(map(format, row, forms)).rstrip())
    outcomes = ", ".join(f"{count} {name}" for name, count in summary["outcomes"].items())
    print(f"outcomes: {outcomes}")
