"""What commands share: their options, and how results are printed."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cavalcade.errors import InputError, OutputError

if TYPE_CHECKING:
    from cavalcade.scenario import Scenario

PICTURES = (".png", ".pdf", ".svg")

ScenarioArgument = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="A shipped scenario's name, or a file.")
]
Out = Annotated[
    Path,
    typer.Option("--out", metavar="DIR", help="Where the results go: a missing or empty folder."),
]
Seed = Annotated[int | None, typer.Option("--seed", metavar="N", help="Over the seed of the file.")]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Over the file: a dotted path and a YAML value, such as planner.variant=published; "
        "a list's elements are [0] and so on, or * for all: robots.*.model=go1; repeatable.",
    ),
]
Backend = Annotated[
    str | None,
    typer.Option(
        "--backend", metavar="NAME", help="Who moves: ideal, mujoco, ros2 or unitree robots."
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace what DIR holds.")]
Realtime = Annotated[bool, typer.Option("--realtime", help="At the pace of the wall clock.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress and no table.")]
Json = Annotated[bool, typer.Option("--json", help="The result as JSON on stdout, nothing else.")]


def load(
    scenario: str, overrides: list[str] | None, seed: int | None, backend: str | None
) -> Scenario:
    """The scenario with everything the command line says over its file."""
    from cavalcade.scenario import load_scenario

    said = list(overrides or [])
    if backend is not None:
        said.append(f"execution.backend={backend}")
    return load_scenario(scenario, overrides=said, seed=seed)


def file_name(name: str) -> str:
    """A scenario's name as a file may be called."""
    return re.sub(r"[^\w.-]+", "-", name).strip(".-")[:80] or "scenario"


def check_picture(path: Path) -> None:
    """Refuse a picture that cannot be written, before any work is done."""
    if path.suffix.lower() not in PICTURES:
        raise InputError("expected the name of a picture", key="--out", choices=PICTURES)
    if path.is_dir():
        raise OutputError(f"{path}: is a folder; expected the name of a picture")
    if not path.parent.is_dir():
        raise OutputError(f"{path.parent}: no such folder")


def not_achieved(
    name: str, reason: str, detail: str | None, what: str = "not achieved"
) -> typer.Exit:
    """Say on stderr why something did not succeed; to be raised, it ends the command with 1."""
    why = f"{reason} ({detail})" if detail else reason
    print(f"cavalcade: {name}: {what}: {why}", file=sys.stderr)
    return typer.Exit(1)


def print_json(value: Any) -> None:
    """One value as JSON on stdout; mappings of any kind are objects."""
    print(json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False, default=dict))
