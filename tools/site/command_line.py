"""The command line's reference: every command with its arguments and options, from the program."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import typer

from cavalcade.cli.commands import app


def commands() -> str:
    """A section per command, in the order of `cavalcade --help`."""
    group: Any = typer.main.get_command(app)
    return "\n\n".join(_command(name, one) for name, one in _flat(group, ""))


def _flat(group: Any, before: str) -> Iterator[tuple[str, Any]]:
    """Commands with their whole names; those of a group one by one."""
    for name, one in group.commands.items():
        if hasattr(one, "commands"):
            yield from _flat(one, f"{before}{name} ")
        else:
            yield f"{before}{name}", one


def _command(name: str, command: Any) -> str:
    parts = [parameter for parameter in command.params if parameter.name != "help"]
    words = [f"cavalcade {name}", *filter(None, map(_usage, parts))]
    rows = [f"| {_names(one)} | {_meaning(one)} |" for one in parts]
    table = ["", "| option | |", "|---|---|", *rows] if rows else []
    usage = " ".join(words)
    return "\n".join(
        (
            f"## `{name}` {{ #{name.replace(' ', '-')} }}",
            "",
            command.help or "",
            "",
            f"`{usage}`",
            *table,
        )
    )


def _usage(parameter: Any) -> str:
    """Arguments, options that are needed, and a note of the others once."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar)
    return f"{parameter.opts[0]} {parameter.metavar}" if parameter.required else ""


def _names(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return f"`{parameter.metavar}`"
    value = "" if parameter.is_flag else f" {parameter.metavar}"
    return f"`{', '.join(parameter.opts)}{value}`"


def _meaning(parameter: Any) -> str:
    said = str(parameter.help or "").replace("|", "\\|").replace("*", "\\*")
    if parameter.required and parameter.param_type_name == "option":
        return f"{said} Needed."
    default = parameter.default
    return said if default in (None, False, ()) else f"{said} Default: `{default}`."
