"""The ground: its size and cells, or a generated one."""

from __future__ import annotations

from typing import Any

from cavalcade.errors import InputError
from cavalcade.scenario.ground import KIND_OPTIONS, TERRAIN_OPTIONS
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.edits import with_world
from cavalcade.studio.build.guide import ground
from cavalcade.studio.build.parameters import parameters
from cavalcade.studio.fields import WAIT, parameter_field

GENERATED = (*KIND_OPTIONS, *TERRAIN_OPTIONS)


class WorldPart:
    """The folder World."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui = bench.gui
        self._about = gui.add_markdown("")
        self._size = gui.add_vector2(
            "Size (m)", (14.0, 10.0), step=0.5, hint="Width along x and height along y."
        )
        bench.fields.bind(self._size, self._shown_size, self._resize, WAIT)
        self._fields = [
            parameter_field(bench.fields, gui, one, one.label, bench.get, bench.draft.set)
            for one in parameters("world")
            if one.path in ("world.resolution", "world.unknown")
        ]
        self._kind = gui.add_dropdown(
            "Random", GENERATED, hint="A random world: obstacles, or terrain for robots with legs."
        )
        self._seed = gui.add_number("Seed", 0, min=0, step=1, hint="Of the random world.")
        generate = gui.add_button(
            "Generate", icon="dice", color="gray", hint="Takes the place of the ground."
        )
        bench.fields.button(generate, lambda _: self._generate())
        bench.updated.append(self.show)
        self.show()

    def show(self) -> None:
        """Show what the ground is."""
        draft = self._bench.draft
        source = draft.data["world"]
        self._about.content = f"Ground: {ground(draft.state)}."
        self._size.visible = "empty" in source
        resolution, unknown = self._fields
        resolution.visible = not {"map", "movingai"} & set(source)
        unknown.visible = "map" in source

    def _shown_size(self) -> tuple[float, float]:
        width, height = self._bench.draft.state.world.base.size
        return float(width), float(height)

    def _resize(self, size: Any) -> None:
        draft = self._bench.draft
        source = draft.data["world"]
        if "empty" in source:
            empty = {**source["empty"], "size": [float(side) for side in size]}
            draft.replace(with_world(draft, {**source, "empty": empty}))

    def _generate(self) -> None:
        draft = self._bench.draft
        size = [round(side, 2) for side in self._shown_size()]
        source = {"kind": self._kind.value, "size": size, "seed": int(self._seed.value)}
        kept = {"resolution": draft.data["world"].get("resolution")}
        world = {"generate": source, **{k: v for k, v in kept.items() if v is not None}}
        try:
            draft.replace(with_world(draft, world))
        except InputError as error:
            if error.key is None or not error.key.startswith("world"):
                raise
            raise error.at(key="Generate") from None
        self._bench.session.stage.frame_team()
