"""The folder a run leaves its results in: prepared first, filled only when all is there."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from cavalcade.errors import OutputError
from cavalcade.files import make_folders, reason_of, remove_folders, write_file
from cavalcade.recording import mcap_writer, plan_file
from cavalcade.scenario import Scenario, dump_scenario
from cavalcade.values import path_of

_STAGE = ".cavalcade-"
SCENARIO, SUMMARY, REPLAY, FIGURES = "scenario.yaml", "summary.json", "replay.html", "figures"
RECORDING, PLAN = mcap_writer.FILE, plan_file.FILE
_PRODUCTS = (SUMMARY, SCENARIO, RECORDING, PLAN, FIGURES, REPLAY)
"""In a reader's order."""


class OutputFolder:
    """Collects files in a hidden stage and moves them into place at the end, or not at all.

    Use it as a context: leaving it without `commit`, for whatever reason, removes the stage and
    every folder that was made for it.

    Args:
        path: The folder; missing or empty, unless `force`.
        force: Replace what an earlier run left in it. Files of other names stay.

    Raises:
        OutputError: It holds something, is not a folder, or cannot be written to. This is found
            out here, before anything is computed.
    """

    def __init__(self, path: str | Path, force: bool = False) -> None:
        self.path = path_of(path, "out")
        self._made = make_folders(self.path)
        try:
            # What a killed run left of its stage is not a result.
            if not force and any(not one.name.startswith(_STAGE) for one in self.path.iterdir()):
                raise OutputError(
                    f"{self.path}: the folder is not empty; name another one or use --force"
                )
            self.stage = Path(tempfile.mkdtemp(dir=self.path, prefix=_STAGE))
        except OSError as error:
            remove_folders(self._made)
            raise OutputError(f"{self.path}: cannot be written: {reason_of(error)}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.stage, ignore_errors=True)
        remove_folders(self._made)

    def commit(self, scenario: Scenario, summary: Mapping[str, Any]) -> tuple[Path, ...]:
        """Put everything in place, and give the files in a reader's order.

        The scenario's file names become relative to the folder. The summary comes last, so that
        its being there says whole.

        Raises:
            OutputError: Something cannot be written.
        """
        try:
            # In the folder itself, because names of map files are relative to it.
            draft = self.path / f"{self.stage.name}.yaml"
            try:
                dump_scenario(scenario, draft)
                os.replace(draft, self.stage / SCENARIO)
            finally:
                draft.unlink(missing_ok=True)
            write_summary(self.stage / SUMMARY, summary)
            staged = sorted(
                (file.relative_to(self.stage) for file in self.stage.rglob("*") if file.is_file()),
                key=lambda name: (_PRODUCTS.index(name.parts[0]), name),
            )
            # What an earlier run left goes, the summary first, and nothing else.
            for name in _PRODUCTS:
                if name != FIGURES:
                    (self.path / name).unlink(missing_ok=True)
            for picture in (self.path / FIGURES).glob("*.png"):
                picture.unlink()
            for file in reversed(staged):
                (self.path / file).parent.mkdir(exist_ok=True)
                os.replace(self.stage / file, self.path / file)
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be written: {reason_of(error)}") from None
        self._made.clear()
        return tuple(self.path / file for file in staged)


def write_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Write the summary of a run or plan.

    Raises:
        OutputError: It cannot be written.
    """
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_file(path, text)
