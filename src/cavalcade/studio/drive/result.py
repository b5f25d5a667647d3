"""What a drive leaves: a summary, files to take along, and the way to the tab Study."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.jobs.output_folder import REPLAY
from cavalcade.jobs.reporter import result_rows
from cavalcade.scenario import Scenario, dump_scenario
from cavalcade.studio.build.draft import text_of, with_names
from cavalcade.studio.drive.drive import Drive
from cavalcade.studio.session import Session
from cavalcade.yaml_text import parse_yaml

EXPORT, STUDY, DOWNLOAD = "Export YAML of what was played", "Study this run", "Download the replay"


class DriveResult:
    """Buttons and the table of a drive.

    Args:
        session: The page.
        drive: Gives what was driven.
        study: Called with the folder that is to be studied.
    """

    def __init__(
        self, session: Session, drive: Callable[[], Drive], study: Callable[[Path], None]
    ) -> None:
        self._session, self._drive = session, drive
        gui, handle = session.server.gui, session.handle
        self._export = gui.add_button(EXPORT, visible=False, hint="For cavalcade run, with events")
        self._export.on_click(handle(self._send_scenario))
        self._folder = gui.add_folder("Result", visible=False)
        with self._folder:
            self._table = gui.add_markdown("")
            show = gui.add_button(STUDY, color="green")
            show.on_click(handle(lambda _: study(self._of_drive())))
            load = gui.add_button(DOWNLOAD)
            load.on_click(handle(self._send_replay))

    def show(self, drive: Drive | None) -> None:
        """What there is of a drive by now."""
        self._export.visible = drive is not None and not drive.live
        folder = None if drive is None or drive.phase != "ended" else drive.folder
        summary = getattr(drive, "summary", None)
        if (folder is not None) and summary is not None and not self._folder.visible:
            rows = "\n".join(f"| {name} | {value} |" for name, value in result_rows(summary))
            self._table.content = f"| | |\n|:--|:--|\n{rows}\n\nIn `{folder}`"
        self._folder.visible = folder is not None

    def _of_drive(self) -> Path:
        folder = self._drive().folder
        if folder is None:
            raise InputError("there is no result yet")
        return folder

    def _send_replay(self, event: Any) -> None:
        file = self._of_drive() / REPLAY
        if not file.is_file():
            raise InputError("this run has no replay")
        self._session.download(event, f"{file.parent.name}.html", file.read_bytes())

    def _send_scenario(self, event: Any) -> None:
        played = getattr(self._drive(), "played", None)
        if played is None:
            raise InputError("real robots leave no scenario that gives the same again")
        self._session.download(event, f"{played.name}.yaml", scenario_bytes(played))


def scenario_bytes(scenario: Scenario) -> bytes:
    """A scenario as a file anywhere on this machine says it: names of its files are absolute."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        file = folder / "scenario.yaml"
        dump_scenario(scenario, file)
        data = parse_yaml(file.read_text(encoding="utf-8"), file=str(file))
    return text_of(with_names(data, lambda name: str((folder / name).resolve()))).encode()
