"""The command on files of other projects: `import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cavalcade.cli import options
from cavalcade.errors import OutputError


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
