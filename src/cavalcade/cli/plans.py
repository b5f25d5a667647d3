"""The command on plans: `plan`."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from cavalcade.cli import options
from cavalcade.cli.printing import print_json

Method = Annotated[
    str | None,
    typer.Option("--method", metavar="NAME", help="Over the file: sequential, joint, cbs or auto."),
]


def plan(
    scenario: options.ScenarioArgument,
    out: options.Out,
    method: Method = None,
    seed: options.Seed = None,
    overrides: options.Set = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
    as_json: options.Json = False,
) -> None:
    """Plan a team whose robots have goals of their own; leave plan, figures and replay."""
    loaded = options.load(scenario, overrides, seed, None)
    from cavalcade.jobs.planning import plan as plan_scenario

    result = plan_scenario(loaded, out, method, force=force, quiet=quiet or as_json)
    if as_json:
        print_json(result.summary)
    if not result.solved:
        detail = result.summary["detail"]
        why = f"{result.reason} ({detail})" if detail else result.reason
        print(f"cavalcade: {loaded.name}: no plan: {why}", file=sys.stderr)
        raise typer.Exit(1)
