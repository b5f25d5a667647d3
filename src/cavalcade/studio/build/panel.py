"""The tab Build: a scenario is set up by clicks and fields, checked at every step."""

from __future__ import annotations

import html
from typing import Any

from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.draft import Draft
from cavalcade.studio.build.draft_scene import WALL, ScenePart
from cavalcade.studio.build.edits import is_individual, with_team
from cavalcade.studio.build.events import EventsPart
from cavalcade.studio.build.guide import OWN_GOALS, QUICK, TOOLS, advice, notes
from cavalcade.studio.build.save import SavePart
from cavalcade.studio.build.selection import SelectionPart
from cavalcade.studio.build.settings import SettingsPart
from cavalcade.studio.build.start import StartPart
from cavalcade.studio.build.team import TeamPart
from cavalcade.studio.build.world_size import WorldPart
from cavalcade.studio.fields import WAIT
from cavalcade.studio.session import Session

UNDO, REDO = "Undo", "Redo"

_COLORS = {"bad": "#e03131", "ready": "#2f9e44", "next": "#1c7ed6", "note": "#f08c00"}
_MOST_NOTES = 4


class BuildPanel:
    """What stands in the tab; made inside its container.

    Attributes:
        draft: The scenario that is being built.
    """

    def __init__(self, session: Session) -> None:
        self._bench = bench = Bench(session)
        self._scene = ScenePart(bench)
        gui, fields = bench.gui, bench.fields
        self._status = gui.add_html("")
        self._quick = gui.add_button(QUICK, color="blue", icon="bolt")
        fields.button(self._quick, lambda _: self._place_first_team())
        self._tools = gui.add_button_group("Click to", tuple(TOOLS))
        fields.button(self._tools, lambda _: bench.use(self._tools.value))
        self._wall = gui.add_number("Wall (m)", WALL, min=0.02, step=0.02, hint="Width of walls.")
        fields.bind(self._wall, lambda: self._scene.wall, self._set_wall, WAIT)
        self._steps = gui.add_button_group("Change", (UNDO, REDO))
        fields.button(self._steps, lambda _: self._step(self._steps.value))
        SelectionPart(bench)
        with gui.add_folder("Start"):
            self.start = StartPart(bench)
        with gui.add_folder("World", expand_by_default=False):
            WorldPart(bench)
        with gui.add_folder("Team and task", expand_by_default=False):
            TeamPart(bench)
        with gui.add_folder("Planner", expand_by_default=False):
            SettingsPart(bench, "planner")
        with gui.add_folder("Execution", expand_by_default=False):
            SettingsPart(bench, "execution")
        with gui.add_folder("Events", expand_by_default=False):
            EventsPart(bench)
        with gui.add_folder("Save"):
            SavePart(bench)
        self._commands = [
            self._command("Build: undo", UNDO, "cmd/ctrl"),
            self._command("Build: redo", REDO, "cmd/ctrl+shift"),
        ]
        bench.updated.append(self._show)
        bench.updated.append(fields.show)
        bench.update()

    @property
    def draft(self) -> Draft:
        """The scenario that is being built."""
        return self._bench.draft

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""
        with self._bench.session.lock:
            self._scene.enter()

    def leave(self) -> None:
        """Another one has been chosen; what was typed just now is taken."""
        with self._bench.session.lock:
            self._bench.fields.flush()
            self._scene.leave()

    def close(self) -> None:
        """The studio ends."""
        self._bench.fields.close()

    def _command(self, label: str, step: str, modifier: str) -> Any:
        command = self._bench.gui.add_command(label, hotkey="Z", modifier=modifier)
        self._bench.fields.button(_Trigger(command), lambda _: self._step(step))
        return command

    def _step(self, step: str) -> None:
        draft = self._bench.draft
        done = draft.undo() if step == UNDO else draft.redo()
        if not done:
            self._bench.session.say(f"There is nothing to {step.lower()}")

    def _place_first_team(self) -> None:
        draft = self._bench.draft
        draft.replace(with_team(draft.state, "go1", 4, "square"))
        self._bench.session.stage.frame_team()

    def _set_wall(self, width: float) -> None:
        self._scene.wall = float(width)

    def _show(self) -> None:
        bench = self._bench
        state = bench.draft.state
        tone, text = advice(state)
        lines: list[tuple[str, str]] = [(tone, text)]
        if bench.warned is not None:
            lines.insert(0, ("bad", f"Not here: {bench.warned}"))
        elif bench.refused is not None:
            lines.insert(0, ("bad", f"Not taken: {bench.refused}"))
        own = bench.tool == "Goal" and is_individual(state.data)
        hint = self._scene.wanted or (OWN_GOALS if own else TOOLS[bench.tool])
        lines.append(("next", f"{bench.tool}: {hint}"))
        lines += [("note", note) for note in notes(state)[:_MOST_NOTES]]
        self._status.content = _boxes(lines)
        self._quick.visible = not state.robots
        self._wall.visible = bench.tool == "Wall"


class _Trigger:
    """A command of the palette with the manners of a button."""

    def __init__(self, command: Any) -> None:
        self.on_click = command.on_trigger


def _boxes(lines: list[tuple[str, str]]) -> str:
    """Lines with a bar of their colour, readable on light and dark."""
    style = "border-left:4px solid {0};background:{0}22;padding:.35em .6em;margin:.3em .75em;"
    style += "font-size:.85em;border-radius:3px;overflow-wrap:anywhere"
    return "".join(
        f'<div class="cavalcade-{tone}" style="{style.format(_COLORS[tone])}">'
        f"{html.escape(text)}</div>"
        for tone, text in lines
    )
