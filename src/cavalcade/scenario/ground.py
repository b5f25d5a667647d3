"""Where it takes place: the `world` of a scenario file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, Self

from pydantic import Field, Strict, model_validator

from cavalcade.scenario.fields import (
    File,
    Fraction,
    Length,
    NotNegative,
    Section,
    Seed,
    Size,
    expected,
)
from cavalcade.scenario.obstacles import Obstacle

KIND_OPTIONS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "clutter": ("obstacles", "zone"),
        "corridor": ("width", "bends", "angle", "zone"),
        "forest": ("trees", "spacing", "zone"),
        "maze": ("passage", "wall", "loops"),
        "rooms": ("room", "door", "wall", "extra"),
    }
)
"""What each kind of generated world may be told."""

Count = Annotated[int, Strict(), Field(ge=0, le=100_000)]

SOURCES = ("map", "generate", "empty", "movingai", "barn")


class EmptySource(Section):
    """Free ground: width (x) and height (y) in m, lower left corner at (0, 0)."""

    size: Size


class GenerateSource(Section):
    """A seeded random world; its lower left corner is at (0, 0).

    `seed: null` takes the scenario's own seed. `require_feasible` draws again until a disc of
    `radius` m gets from one end to the other. The other options are those of the kind, see
    `cavalcade.world.generators`; null is the generator's default.
    """

    kind: Literal["clutter", "forest", "rooms", "corridor", "maze"]
    size: Size
    seed: Seed | None = None
    radius: Length = 0.30
    require_feasible: Annotated[bool, Strict()] = True
    obstacles: Count | None = None
    zone: NotNegative | None = None
    trees: Count | None = None
    spacing: Length | None = None
    room: Length | None = None
    door: Length | None = None
    wall: Length | None = None
    extra: Fraction | None = None
    width: Length | None = None
    bends: Count | None = None
    angle: NotNegative | None = None
    passage: Length | None = None
    loops: Fraction | None = None

    @model_validator(mode="after")
    def _known_options(self) -> Self:
        known = KIND_OPTIONS[self.kind]
        for name in sorted(set().union(*KIND_OPTIONS.values()) - set(known)):
            if getattr(self, name) is not None:
                raise expected(f"a {self.kind} has no such option", key=name, choices=known)
        return self

    @property
    def options(self) -> dict[str, Any]:
        """The options of the kind that are given."""
        found = {name: getattr(self, name) for name in KIND_OPTIONS[self.kind]}
        return {name: value for name, value in found.items() if value is not None}


class MovingAISource(Section):
    """A grid map of the MovingAI benchmark; `resolution` is the side of one of its cells in m."""

    file: File
    resolution: Length = 0.25


class BarnSource(Section):
    """A world of the BARN data set: a list of circles, moved so that its lower left is (0, 0)."""

    file: File


class WorldSection(Section):
    """Exactly one source, then optional extra obstacles.

    `resolution` (m per cell) is for worlds that don't bring one; `unknown` says what the unknown
    cells of a map count as.
    """

    map: File | None = None
    generate: GenerateSource | None = None
    empty: EmptySource | None = None
    movingai: MovingAISource | None = None
    barn: BarnSource | None = None
    resolution: Annotated[Length, Field(ge=0.001)] = 0.05
    unknown: Literal["occupied", "free"] = "occupied"
    obstacles: Annotated[tuple[Obstacle, ...], Field(max_length=100_000)] = ()

    @model_validator(mode="before")
    @classmethod
    def _terrain(cls, data: Any) -> Any:
        if isinstance(data, dict) and "terrain" in data:
            raise expected("terrain arrives with body planning", key="terrain", choices=SOURCES)
        return data

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if sum(getattr(self, name) is not None for name in SOURCES) != 1:
            raise expected("expected exactly one source", choices=SOURCES)
        return self

    @property
    def source(self) -> str:
        """Which of the sources it is."""
        return next(name for name in SOURCES if getattr(self, name) is not None)
