"""What is selected: its figures, and taking it away."""

from __future__ import annotations

from itertools import islice
from typing import Any

from cavalcade.robots import MODELS
from cavalcade.studio.build import poses
from cavalcade.studio.build.bench import Bench, Selection
from cavalcade.studio.build.obstacles import with_obstacle
from cavalcade.studio.build.parameters import text_of_value
from cavalcade.studio.fields import WAIT
from cavalcade.yaml_text import parse_yaml

NOTHING = "nothing"
_MOST = 500
"""How many things the list offers; all others can be clicked."""


class SelectionPart:
    """The list of what can be selected, and the figures of what is."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui = bench.gui
        self._list = gui.add_dropdown(
            "Selected", (NOTHING,), hint="Or click a robot or an obstacle in the scene."
        )
        bench.fields.bind(self._list, lambda: _name(bench.selected), self._choose)
        self._place = gui.add_folder("Figures")
        self._made: list[Any] = []
        self._shown: tuple[Any, ...] = ()
        self._show()
        bench.updated.append(self._show)

    def _choose(self, name: str) -> None:
        kind, _, index = name.partition(" ")
        self._bench.select((kind, int(index)) if index else None)

    def _show(self) -> None:
        bench = self._bench
        counts = bench.selectable()
        listed = ((kind, index) for kind, count in counts.items() for index in range(count))
        options = (NOTHING, *map(_name, islice(listed, _MOST)))
        if bench.selected is not None and _name(bench.selected) not in options:
            options += (_name(bench.selected),)
        if options != self._list.options:
            self._list.options = options
        self._list.visible = any(counts.values())
        selected = bench.selected
        kind = None if selected is None else self._kind(selected)
        if (selected, kind) != self._shown:
            self._shown = (selected, kind)
            bench.fields.forget(self._made)
            self._made = []
            if selected is not None:
                with self._place:
                    self._build(selected)
        self._place.visible = selected is not None

    def _kind(self, selected: Selection) -> str:
        """What fields it has: of an obstacle, those of its shape."""
        kind, index = selected
        return next(iter(self._bench.obstacle(index))) if kind == "obstacle" else kind

    def _build(self, selected: Selection) -> None:
        bench, (kind, index) = self._bench, selected
        draft, gui, fields = bench.draft, bench.gui, bench.fields
        if kind == "robot":
            model = gui.add_dropdown("Model", tuple(MODELS))
            fields.bind(
                model,
                lambda: draft.state.robots[index][0].name,
                lambda name: draft.set(f"robots[{index}].model", name),
            )
            self._made.append(model)
        if kind == "obstacle":
            self._build_obstacle(index)
        else:
            pose = gui.add_vector3(
                "x, y (m), yaw (rad)",
                (0.0, 0.0, 0.0),
                step=0.05,
                hint="In the map; yaw is counter-clockwise from the x axis.",
            )
            pose.precision = 3
            fields.bind(
                pose,
                lambda: poses.pose_at(draft.state, kind, index),
                lambda value: draft.replace(poses.moved(draft.state, kind, index, value)),
                WAIT,
            )
            self._made.append(pose)
        delete = gui.add_button(f"Delete {_name(selected)}", icon="trash", color="red")
        fields.button(delete, lambda _: draft.replace(poses.removed(draft.state, kind, index)))
        self._made.append(delete)

    def _build_obstacle(self, index: int) -> None:
        """A field for each figure of the shape, as the file has them."""
        bench = self._bench
        shape, figures = next(iter(bench.obstacle(index).items()))
        units = {"yaw": "rad"}
        for key in figures:

            def read(key: str = key) -> str:
                return text_of_value(bench.obstacle(index)[shape][key])

            def write(text: str, key: str = key) -> None:
                value = parse_yaml(text, key=f"{shape}.{key}")
                changed = {shape: {**bench.obstacle(index)[shape], key: value}}
                bench.draft.replace(with_obstacle(bench.draft.state, changed, index))

            field = bench.gui.add_text(f"{key} ({units.get(key, 'm')})", read())
            self._made.append(bench.fields.bind(field, read, write, WAIT))


def _name(selected: Selection | None) -> str:
    return NOTHING if selected is None else f"{selected[0]} {selected[1]}"
