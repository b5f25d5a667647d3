"""One trial of a finished campaign again, bit for bit, with everything to look at."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from cavalcade.campaign.definition import read_definition
from cavalcade.campaign.table import LINES
from cavalcade.campaign.trial import Line, without_times
from cavalcade.campaign.trial_runner import run_trial_into
from cavalcade.errors import InputError, OutputError


@dataclass(frozen=True)
class Repeated:
    """A trial that was run again.

    Attributes:
        line: Its line, as the campaign would have kept it.
        before: The campaign's line of it, None if it has none yet.
        same: Whether the lines are the same but for times; None without one to compare with.
        version: Of the package that the campaign was run with.
    """

    line: Line
    before: Line | None
    same: bool | None
    version: str


def repeat_trial(
    folder: str | Path,
    trial_id: str,
    out: str | Path,
    *,
    data: str | Path | None = None,
    force: bool = False,
    quiet: bool = True,
) -> Repeated:
    """Run one trial of the campaign in `folder`, with recording, figures and replay in `out`.

    Args:
        trial_id: As it stands in `trials.jsonl`.
        out: Missing or empty, unless what it holds is to be replaced by `force`.
        data: The folder with the data of other projects, if not where the campaign had it.
        quiet: Print nothing.

    Raises:
        InputError: There is no such campaign or trial, or its data are not there.
        OutputError: `out` cannot be written, or is the campaign's own folder.
    """
    definition = read_definition(Path(folder), data)
    missing = definition.suite.missing(definition.data)
    if missing is not None:
        raise InputError(missing)
    trial = definition.trial(trial_id)
    if Path(out).resolve() == Path(folder).resolve():
        raise OutputError(f"{out}: holds the campaign itself; name another folder")
    before = _line_of(Path(folder) / LINES, trial_id)
    line, _ = run_trial_into(trial, Path(out), force=force, quiet=quiet)
    # Through JSON, as the campaign's went.
    line = json.loads(json.dumps(line, allow_nan=False))
    same = None if before is None else without_times(before) == without_times(line)
    return Repeated(line, before, same, definition.version)


def _line_of(file: Path, trial_id: str) -> Line | None:
    """The campaign's line of a trial; None where there is none that can be read."""
    with suppress(OSError), file.open(encoding="utf-8", errors="replace") as stream:
        for text in stream:
            with suppress(ValueError):
                line = json.loads(text) if trial_id in text else None
                if (
                    isinstance(line, dict)
                    and line.get("trial") == trial_id
                    and isinstance(line.get("summary"), dict)
                ):
                    return line
    return None
