"""The tab Study."""

from __future__ import annotations

from cavalcade.studio.session import Session


class StudyPanel:
    """What stands in the tab; made inside its container."""

    def __init__(self, session: Session) -> None:
        self._session = session
        session.server.gui.add_markdown("Study")

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""

    def leave(self) -> None:
        """Another one has been chosen."""

    def close(self) -> None:
        """The studio ends."""
