"""The studio as a whole: the page with its tabs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Protocol, Self

from cavalcade.errors import InputError
from cavalcade.scenario.shipped import scenario_names
from cavalcade.studio.build.panel import BuildPanel
from cavalcade.studio.drive.panel import DrivePanel
from cavalcade.studio.scene.view_panel import ViewPanel
from cavalcade.studio.session import HOST, PORT, Session
from cavalcade.studio.study.panel import StudyPanel

Tab = Literal["Build", "Drive", "Study"]


class Panel(Protocol):
    """What stands in a tab."""

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""

    def leave(self) -> None:
        """Another one has been chosen."""

    def close(self) -> None:
        """The studio ends."""


class Studio:
    """The page with its tabs, until it is closed.

    Args:
        host, port: Where it listens; port 0 takes any that is free.
        folder: For uploads and results; made where it is missing.

    Attributes:
        session: Server, scene and who drives.
        build, drive, study: The tabs.

    Raises:
        InputError: viser is not installed, or nobody may listen there.
    """

    def __init__(self, host: str = HOST, port: int = PORT, *, folder: Path) -> None:
        self.session = session = Session(host, port, folder=folder)
        gui = session.server.gui
        # The server is not told of which of viser's own tabs is looked at, and the scene is only
        # one: all see the same tab.
        self._buttons = gui.add_button_group("", ("Build", "Drive", "Study"), order=-50.0)
        self._buttons.on_click(session.handle(lambda event: self.choose(event.target.value)))
        self._title = gui.add_markdown("", order=-49.0)
        self._folders: dict[str, Any] = {}
        with self._folder("Build"):
            self.build = BuildPanel(session)
        with self._folder("Drive"):
            self.drive = DrivePanel(session, self.build, self._study)
        with self._folder("Study"):
            self.study = StudyPanel(session)
        self._panels: dict[Tab, Panel] = {
            "Build": self.build,
            "Drive": self.drive,
            "Study": self.study,
        }
        self.chosen: Tab | None = None
        self.choose("Build")
        for label, key, act in (
            ("Play or pause", "space", "play_or_pause"),
            ("One step", "arrowright", "step"),
            ("Stop", "escape", "stop"),
        ):
            command = gui.add_command(label, hotkey=key, description="Drive and Study")
            command.on_trigger(lambda event, act=act: self._press(event, act))
        dark = gui.add_checkbox("Dark", session.dark, order=1000.0)
        dark.on_update(session.handle(lambda event: self._switch(event.target.value)))
        session.themed.append(lambda: setattr(dark, "value", session.dark))
        ViewPanel(session)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def choose(self, tab: Tab) -> None:
        """Turn to a tab."""
        if tab not in self._panels:
            raise InputError(f"there is no tab {tab}", choices=tuple(self._panels))
        if tab == self.chosen:
            return
        with self.session.lock:
            if self.chosen is not None:
                self._panels[self.chosen].leave()
            self.chosen = tab
            self._title.content = f"## {tab}"
            for name, folder in self._folders.items():
                folder.visible = name == tab
            self._panels[tab].enter()

    def open(self, shown: str | Path) -> None:
        """Begin with a scenario, shipped or a file, or with the folder of a run or a campaign.

        Raises:
            InputError: It is none of these.
        """
        if str(shown) not in scenario_names() and Path(shown).is_dir():
            self._study(Path(shown))
        else:
            self.build.draft.load(shown)
            self.choose("Build")

    def close(self) -> None:
        """End what goes on and close the page."""
        for panel in self._panels.values():
            panel.close()
        self.session.close()

    def _folder(self, name: Tab) -> Any:
        self._folders[name] = self.session.server.gui.add_folder(None)
        return self._folders[name]

    def _study(self, folder: Path) -> None:
        """Look at what a run has left."""
        self.study.open(folder)
        self.choose("Study")

    def _press(self, event: Any, act: str) -> None:
        """A key: for what the tab shows; to stop real robots is everybody's and every tab's."""
        if act == "stop" and self.drive.is_live:
            self.drive.emergency_stop()
            return
        found = getattr(self._panels[self.chosen or "Build"], act, None)
        if found is not None:
            self.session.handle(lambda _: found())(event)

    def _switch(self, dark: bool) -> None:
        self.session.dark = dark
