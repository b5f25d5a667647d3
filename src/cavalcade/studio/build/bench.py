"""What the parts of the tab Build share: the draft, what is selected and what clicks do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cavalcade.studio.build.draft import Draft
from cavalcade.studio.build.edits import is_individual
from cavalcade.studio.build.obstacles import obstacle_at
from cavalcade.studio.build.uploads import Uploads
from cavalcade.studio.fields import Fields
from cavalcade.studio.session import Session

Selection = tuple[str, int]
"""`robot`, `obstacle` or `goal`, and its index."""


class Bench:
    """The draft under work.

    Attributes:
        session, draft, fields, uploads: What the parts work with.
        selected: What can be seen and changed one by one; None for nothing.
        tool: What clicks on the ground do.
        model: Of robots that are added.
        refused: What was refused last, in words; None once something was taken.
        warned: What would be refused of what is going on, in words.
        updated: Called when any of these or the draft has changed.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.gui: Any = session.server.gui
        self.draft = Draft()
        self.uploads = Uploads(session.folder / "uploads")
        self.fields = Fields(session, self._told)
        self.selected: Selection | None = None
        self.tool = "Select"
        self.model = "go1"
        self.refused: str | None = None
        self.warned: str | None = None
        self.updated: list[Callable[[], None]] = []
        self.draft.changed.append(self.update)

    def update(self) -> None:
        """Something has changed: everybody shows what is the case."""
        if self.selected is not None:
            kind, index = self.selected
            if index >= self.selectable()[kind]:
                self.selected = None
        for act in tuple(self.updated):
            act()

    def select(self, selected: Selection | None) -> None:
        """Select something."""
        self.selected = selected
        self.update()

    def use(self, tool: str) -> None:
        """Let clicks on the ground do something else."""
        self.tool = tool
        self.update()

    def selectable(self) -> dict[str, int]:
        """How many of each kind can be selected."""
        state = self.draft.state
        robots = len(state.robots)
        goals = robots if is_individual(state.data) else len(state.goals)
        return {"robot": robots, "goal": goals, "obstacle": len(state.shown.world.obstacles)}

    def obstacle(self, index: int) -> dict[str, Any]:
        """An obstacle that stands there."""
        return obstacle_at(self.draft.state, index)

    def get(self, path: str) -> Any:
        """What the file says at a dotted path of mappings; None for nothing."""
        here: Any = self.draft.data
        for key in path.split("."):
            here = here.get(key) if isinstance(here, dict) else None
        return here

    def warn(self, words: str | None) -> None:
        """Say what would be refused of what is going on, or None: nothing."""
        if words != self.warned:
            self.warned = words
            self.update()

    def _told(self, words: str | None) -> None:
        self.refused, self.warned = words, None
        self.update()
