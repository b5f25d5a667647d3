"""The studio as a whole: the page with its tabs."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from cavalcade.studio.build_panel import BuildPanel
from cavalcade.studio.drive_panel import DrivePanel
from cavalcade.studio.session import HOST, PORT, Session
from cavalcade.studio.study_panel import StudyPanel
from cavalcade.studio.view_panel import ViewPanel


class Studio:
    """The page with its tabs, until it is closed.

    Args:
        host, port: Where it listens; port 0 takes any that is free.
        folder: For uploads and results; made where it is missing.

    Attributes:
        session: Server, scene and who drives.
        build, drive, study: The tabs.

    Raises:
        InputError: viser is not installed.
    """

    def __init__(self, host: str = HOST, port: int = PORT, *, folder: Path) -> None:
        self.session = Session(host, port, folder=folder)
        tabs = self.session.server.gui.add_tab_group()
        with tabs.add_tab("Build"):
            self.build = BuildPanel(self.session)
        with tabs.add_tab("Drive"):
            self.drive = DrivePanel(self.session, self.build)
        with tabs.add_tab("Study"):
            self.study = StudyPanel(self.session)
        ViewPanel(self.session)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def open(self, shown: str | Path) -> None:
        """Begin with a scenario, shipped or a file, or with the folder of a run or a campaign.

        Raises:
            InputError: It is none of these.
        """

    def close(self) -> None:
        """End what goes on and close the page."""
        for panel in (self.build, self.drive, self.study):
            panel.close()
        self.session.close()
