"""What a generator gives back, and the parts they share. World frame: lower-left corner (0, 0)."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cavalcade.errors import InputError
from cavalcade.values import described
from cavalcade.world.occupancy import OccupancyMap
from cavalcade.world.shapes import Shape

Pose = tuple[float, float, float]
"""x m, y m, yaw rad."""

Size = tuple[float, float]
"""Width and height, m."""


@dataclass(frozen=True)
class Draw:
    """One draw of a generator.

    Attributes:
        shapes: The obstacles.
        start, goal: Poses on free ground for the centre of a team to start and to end at.
    """

    shapes: tuple[Shape, ...]
    start: Pose
    goal: Pose


Generator = Callable[..., Draw]
"""Takes the world's size, a source of all randomness and, by keyword, its kind's options."""


@dataclass(frozen=True, kw_only=True)
class GeneratedWorld(Draw):
    """A world drawn by a seed. Its shapes are the truth; maps are made from them.

    Attributes:
        kind, seed: What it was drawn from.
        size: Width and height, m; the lower-left corner is (0, 0).
        resolution: Side of the cells of its map, m.
        feasible: A disc of the radius asked for gets from start to goal (never claimed wrongly).
        attempts: Draws that were needed.
    """

    kind: str
    seed: int
    size: Size
    resolution: float
    feasible: bool
    attempts: int

    def to_map(self) -> OccupancyMap:
        """The world as an occupancy map."""
        return OccupancyMap.empty(self.size, self.resolution).with_shapes(self.shapes)


def options_of(generator: Callable[..., object]) -> dict[str, Any]:
    """The names of a generator's options and their defaults."""
    parameters = inspect.signature(generator).parameters.values()
    return {p.name: p.default for p in parameters if p.kind is p.KEYWORD_ONLY}


def check_options(
    kind: str, generators: Mapping[str, Callable[..., object]], options: Iterable[str]
) -> None:
    """Refuse an unknown kind and options that it does not have."""
    if not isinstance(kind, str) or kind not in generators:
        raise InputError(f"unknown kind {described(kind)}", key="kind", choices=generators)
    known = options_of(generators[kind])
    for name in options:
        if name not in known:
            raise InputError(f"{kind} has no such option", key=name, choices=known)


def number(name: str, value: float, low: float, high: float = math.inf) -> float:
    """`value` as a float in [low, high]; InputError names the option."""
    valid = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    if not valid or not math.isfinite(value) or not low <= value <= high:
        upper = "" if math.isinf(high) else f" and at most {high:g}"
        raise InputError(f"expected a number of at least {low:g}{upper}", key=name)
    return float(value)


def count(name: str, value: int, low: int, high: int) -> int:
    """`value` as an integer in [low, high]; InputError names the option."""
    valid = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not valid or not low <= value <= high:
        raise InputError(f"expected an integer from {low} to {high}", key=name)
    return int(value)


def zone_poses(size: Size, zone: float) -> tuple[Pose, Pose]:
    """Start and goal in the middle of the zones of that width on the left and the right."""
    middle = size[1] / 2.0
    return (zone / 2.0, middle, 0.0), (size[0] - zone / 2.0, middle, 0.0)


def check_band(size: Size, zone: float, least: float) -> None:
    """Refuse a world that leaves less than `least` m between its start and goal zones."""
    if size[0] - 2.0 * zone < least:
        raise InputError(
            f"{size[0]:g} m leave less than {least:g} m between two zones of {zone:g} m",
            key="size",
        )
