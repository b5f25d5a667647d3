"""The team and its task: how many robots of which model, in which shape, with which goals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import numpy as np

from cavalcade.geometry import transform_points
from cavalcade.robots import MODELS
from cavalcade.scenario import FormationSection
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.draft import Pose
from cavalcade.studio.build.edits import (
    SIZES,
    is_individual,
    usual_shape,
    with_formation,
    with_individual_goals,
    with_team,
)
from cavalcade.studio.fields import WAIT
from cavalcade.yaml_text import parse_yaml

TOGETHER, EACH = "in formation", "each its own"

ANY_NUMBER = ("line", "column", "wedge", "circle")
"""Shapes that any number of robots can take up."""


class TeamPart:
    """The folder Team and task."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui, fields = bench.gui, bench.fields
        self._model = gui.add_dropdown(
            "Model", tuple(MODELS), initial_value="go1", hint="Of robots that are added."
        )
        fields.bind(self._model, lambda: bench.model, self._use_model)
        self._count = gui.add_number("Robots", 4, min=1, max=64, step=1)
        place = gui.add_button(
            "Place team",
            icon="users-group",
            color="gray",
            hint="Places this many robots on free ground, in the place of those there are.",
        )
        fields.button(place, lambda _: self._place())
        self._kind = gui.add_dropdown(
            "Goals",
            (TOGETHER, EACH),
            hint="One goal for the whole formation, or a goal for each robot.",
        )
        fields.bind(self._kind, self._shown_kind, self._use_kind)
        self._shape = gui.add_dropdown(
            "Shape", _shapes(), hint="How the robots stand to each other on their way."
        )
        fields.bind(self._shape, self._shown_shape, self._use_shape)
        self._size = gui.add_number(
            "Size (m)", 1.0, step=0.05, hint="Side, spacing or radius of the shape."
        )
        self._size.precision = 3
        fields.bind(self._size, self._shown_size, self._resize, WAIT)
        self._slots = gui.add_text(
            "Slots (m)", "", hint="Points [x, y] of a custom shape, x forward, the leader's first."
        )
        fields.bind(self._slots, self._shown_slots, self._use_slots, WAIT)
        bench.updated.append(self.show)
        self.show()

    def show(self) -> None:
        """Show what applies to the task."""
        formation = self._formation() is not None
        self._shape.visible = self._kind.visible = bool(self._bench.draft.state.robots)
        self._shape.visible &= formation
        self._size.visible = formation and self._shown_shape() != "custom"
        self._slots.visible = formation and self._shown_shape() == "custom"

    def _formation(self) -> dict[str, Any] | None:
        found: dict[str, Any] | None = self._bench.get("task.formation")
        return found

    def _use_model(self, model: str) -> None:
        self._bench.model = model

    def _place(self) -> None:
        count, shape = int(self._count.value), self._shown_shape()
        if shape not in ANY_NUMBER or self._formation() is None:
            shape = usual_shape(count)
        draft = self._bench.draft
        draft.replace(with_team(draft.state, self._bench.model, count, shape))
        self._bench.session.stage.frame_team()

    def _shown_kind(self) -> str:
        return EACH if is_individual(self._bench.draft.data) else TOGETHER

    def _use_kind(self, kind: str) -> None:
        draft = self._bench.draft
        if kind == self._shown_kind():
            return
        change = with_individual_goals if kind == EACH else with_formation
        draft.replace(change(draft.state))

    def _shown_shape(self) -> str:
        return str((self._formation() or {}).get("shape", "square"))

    def _use_shape(self, shape: str) -> None:
        formation: dict[str, Any] = {"shape": shape}
        if shape == "custom":
            formation["slots"] = _relative([pose for _, pose in self._bench.draft.state.robots])
        self._bench.draft.set("task.formation", formation)

    def _shown_size(self) -> float:
        section = self._bench.draft.state.shown.task.formation
        sizes = () if section is None else (section.side, section.spacing, section.radius)
        return float(next((size for size in sizes if size is not None), 1.0))

    def _resize(self, size: float) -> None:
        formation = {"shape": self._shown_shape()}
        given = self._formation() or {}
        if "connections" in given:
            formation["connections"] = given["connections"]
        key = SIZES.get(formation["shape"], "spacing")
        self._bench.draft.set("task.formation", {**formation, key: float(size)})

    def _shown_slots(self) -> str:
        slots = (self._formation() or {}).get("slots") or ()
        return str([list(slot) for slot in slots])

    def _use_slots(self, text: str) -> None:
        self._bench.draft.set("task.formation.slots", parse_yaml(text, key="task.formation.slots"))


def _shapes() -> tuple[str, ...]:
    return tuple(map(str, get_args(FormationSection.model_fields["shape"].annotation)))


def _relative(poses: Sequence[Pose]) -> list[list[float]]:
    """The shape in which a team stands now, as slots: seen from its middle, as the first faces."""
    points = np.array([pose[:2] for pose in poses]).reshape(-1, 2)
    yaw = poses[0][2] if poses else 0.0
    turned = transform_points((0.0, 0.0, -yaw), points - points.mean(axis=0))
    return [[float(x), float(y)] for x, y in turned.round(3)]
