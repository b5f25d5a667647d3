"""The tab Drive."""

from __future__ import annotations

from cavalcade.studio.build_panel import BuildPanel
from cavalcade.studio.session import Session


class DrivePanel:
    """What stands in the tab; made inside its container."""

    def __init__(self, session: Session, build: BuildPanel) -> None:
        self._session = session
        self._build = build
        session.server.gui.add_markdown("Drive")

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""

    def leave(self) -> None:
        """Another one has been chosen."""

    def close(self) -> None:
        """The studio ends."""
