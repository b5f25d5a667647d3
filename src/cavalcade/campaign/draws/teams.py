"""The team of a draw: its robots and the shape they keep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, Strict, ValidationError, model_validator

from cavalcade.geometry import Array
from cavalcade.robots import MODELS
from cavalcade.scenario.fields import Length, Point, Section, expected
from cavalcade.scenario.task import FormationSection, check_formation

Slots = Annotated[tuple[Point, ...], Field(min_length=1, max_length=64)]
"""Points of a custom shape in the formation's frame, m, the leader's first."""

BODY = 0.36
"""A go1 or a spirit may stand at any yaw where its centre keeps this distance, m; it is half the
diagonal of a go1 and a little, and of a spirit less its last 3 cm."""


class TeamSection(Section):
    """A shape with its size in m, as in a scenario file, and how many robots keep it.

    Square, triangle and custom shapes, which are lists of slots, say by themselves how many they
    are.
    """

    shape: Literal["square", "line", "column", "wedge", "triangle", "circle", "custom"]
    side: Length | None = None
    spacing: Length | None = None
    radius: Length | None = None
    slots: Slots | None = None
    robots: Annotated[int, Strict(), Field(ge=1, le=64)] = 0

    _formation: FormationSection = PrivateAttr()

    @model_validator(mode="before")
    @classmethod
    def _count(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("robots") is not None:
            return data
        own = {"square": 4, "triangle": 3}.get(str(data.get("shape")))
        if data.get("shape") == "custom" and isinstance(data.get("slots"), list | tuple):
            own = len(data["slots"])
        if own is None:
            raise expected("expected how many there are", key="robots")
        return {**data, "robots": own}

    @model_validator(mode="after")
    def _shape(self) -> Self:
        sizes = {key: getattr(self, key) for key in ("side", "spacing", "radius", "slots")}
        said = {key: value for key, value in sizes.items() if value is not None}
        try:
            self._formation = FormationSection.model_validate({"shape": self.shape, **said})
        except ValidationError as error:
            raise expected(error.errors()[0]["msg"]) from None
        check_formation(self._formation, self.robots, MODELS["go1"].width)
        return self

    @property
    def words(self) -> dict[str, Any]:
        """The formation as a scenario file says it."""
        return self._formation.model_dump(mode="json", exclude_none=True)

    def places(self) -> Array:
        """The slots `(N, 2)` in the formation's frame, m."""
        from cavalcade.execution.formation_policy import formation_of
        from cavalcade.scenario import PlannerSection

        return formation_of(self._formation, self.robots, PlannerSection()).slots

    def starts(self, pose: Sequence[float]) -> list[dict[str, Any]]:
        """The robots of a scenario file, in their slots around `pose` (x, y, yaw)."""
        places = placed(pose, self.places())
        yaw = round(float(pose[2]), 6)
        return [
            {"model": "go1", "start": [round(x, 6), round(y, 6), yaw]} for x, y in places.tolist()
        ]


def placed(pose: Sequence[float], slots: Array) -> Array:
    """Slots `(N, 2)` with the formation's centre at `pose`, m."""
    from cavalcade.geometry import transform_points

    return transform_points(pose, slots)
