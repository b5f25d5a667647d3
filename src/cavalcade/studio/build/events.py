"""What happens on the way: a list of the file's events, a line each."""

from __future__ import annotations

from typing import Any

from cavalcade.scenario import Event
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.obstacles import obstacles_of, pose_of
from cavalcade.studio.build.parameters import text_of_value
from cavalcade.studio.fields import WAIT
from cavalcade.yaml_text import parse_yaml

TIME = 10.0
"""When events happen that are new, s."""

_MOST = 100
"""How many events have a field; files may hold more."""


class EventsPart:
    """The folder Events."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui = bench.gui
        self._about = gui.add_markdown("")
        self._lines = gui.add_folder("Events, by time (s)")
        self._made: list[Any] = []
        self._kind = gui.add_dropdown("Kind", Event.kinds, hint=_meanings())
        add = gui.add_button(
            "Add event", icon="plus", color="gray", hint="A first version, to be edited above."
        )
        bench.fields.button(add, lambda _: self._add())
        bench.updated.append(self._show)
        self._show()

    def _events(self) -> list[Any]:
        return list(self._bench.get("execution.events") or ())

    def _show(self) -> None:
        count = len(self._events())
        self._about.content = (
            "Each line is an event as in the file; an empty one is taken away."
            if count
            else "Nothing happens on the way."
        )
        self._lines.visible = count > 0
        shown = min(count, _MOST)
        if len(self._made) != shown:
            self._bench.fields.forget(self._made)
            with self._lines:
                self._made = [self._line(index) for index in range(shown)]

    def _line(self, index: int) -> Any:
        bench = self._bench

        def read() -> str:
            return text_of_value(self._events()[index]).strip("{}") if self._has(index) else ""

        def write(text: str) -> None:
            events = self._events()
            key = f"execution.events[{index}]"
            new = [parse_yaml(f"{{{text}}}", key=key)] if text.strip() else []
            bench.draft.set("execution.events", [*events[:index], *new, *events[index + 1 :]])

        return bench.fields.bind(
            bench.gui.add_text(str(index), read(), multiline=True), read, write, 2.0 * WAIT
        )

    def _has(self, index: int) -> bool:
        return index < len(self._events())

    def _add(self) -> None:
        event = {"at": self._time(), self._kind.value: self._first(self._kind.value)}
        self._bench.draft.set("execution.events", [*self._events(), event])

    def _time(self) -> float:
        times = [event["at"] for event in self._events()]
        return max(times) + 5.0 if times else TIME

    def _first(self, kind: str) -> Any:
        """Something that makes sense here."""
        state = self._bench.draft.state
        width, height = state.world.base.size
        (x, y), *_ = state.world.base.to_map([(width / 2.0, height / 2.0)])
        middle = [round(float(x), 2), round(float(y), 2)]
        obstacles = obstacles_of(state) or [{"circle": {"center": middle, "radius": 0.3}}]
        lost = [event["lose"] for event in self._events() if "lose" in event]
        goal = list(state.goals[-1]) if state.goals else [*middle, 0.0]
        return {
            "add": {"circle": {"center": middle, "radius": 0.3}},
            "remove": obstacles[0],
            "move": {**obstacles[0], "to": _beside(obstacles[0]), "speed": 0.5},
            "goals": [goal],
            "formation": {"shape": "column"},
            "lose": len(state.robots) - 1,
            "rejoin": lost[-1] if lost else 0,
            "push": {"robot": 0, "impulse": [0.0, 10.0]},
        }[kind]


def _beside(obstacle: dict[str, Any]) -> list[float]:
    x, y, _ = pose_of(obstacle)
    return [round(x + 1.0, 2), round(y, 2)]


def _meanings() -> str:
    properties = Event.model_json_schema()["properties"]
    return " ".join(f"{kind}: {properties[kind]['description']}" for kind in Event.kinds)
