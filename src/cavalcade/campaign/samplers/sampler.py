"""What every sampler takes and gives, and what a campaign asks of it."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, Strict

from cavalcade.errors import InputError
from cavalcade.scenario.fields import Length, Section, expected
from cavalcade.world import GeneratedWorld, Shape, shape_to_mapping

SOLVED, INFEASIBLE, UNSOLVED, REFUSED = "solved", "infeasible", "unsolved", "refused"

EXPECTED: Mapping[str, tuple[str, ...]] = {
    INFEASIBLE: ("infeasible",),
    UNSOLVED: ("infeasible", "budget"),
    REFUSED: ("refused",),
}
"""With which outcomes a trial succeeds in worlds that are infeasible by construction: where that
can be proven at once, where it cannot, and where the scenario is bad input."""

Area = tuple[float, float, float, float]
"""x_min, y_min, x_max, y_max in m."""

Pose = tuple[float, float, float]
"""x, y, yaw in m and rad, map frame."""


VARIABLE = "CAVALCADE_DATA"
"""The environment variable that names the folder."""

PLACES = (Path("data"), Path("../shared/data"))
"""Where it is looked for otherwise, from the working directory."""


@dataclass(frozen=True)
class DataFolder:
    """The folder of the data, if there is one.

    Attributes:
        path: Absolute; None where there is no such folder.
    """

    path: Path | None

    @classmethod
    def find(cls, named: str | Path | None = None) -> DataFolder:
        """The folder named, else that of `CAVALCADE_DATA`, else the first of `PLACES` there is.

        Raises:
            InputError: A folder is named that does not exist.
        """
        for key, given in (("data", named), (VARIABLE, os.environ.get(VARIABLE) or None)):
            if given is not None:
                if not Path(given).is_dir():
                    raise InputError(f"no such folder: {given}", key=key)
                return cls(Path(given).resolve())
        return cls(next((place.resolve() for place in PLACES if place.is_dir()), None))

    def file(self, name: str | Path) -> Path:
        """The absolute name of a file of the data; InputError if it is not there."""
        found = None if self.path is None else self.path / name
        if found is None or not found.is_file():
            raise InputError(self.lack(name))
        return found

    def lack(self, what: str | Path) -> str:
        """One line that says that something is not there, and how to name a folder that has it."""
        where = "there is no folder of data" if self.path is None else f"not in {self.path}"
        return f"{what}: {where}; name one that has it with --data or {VARIABLE}"


@dataclass(frozen=True)
class Instance:
    """A world with a team and its task.

    Attributes:
        scenario: As a scenario file says it; file names are absolute. A planner section is that
            of the file it came from; its variant gives way to the trial's.
        feasible: A disc of 0.30 m radius gets from every start to every slot at the goal, see
            `feasibility`; with individual goals a disc of half the body's width gets from each
            start to its goal. The planner has no part in it.
        level: Where it lies on the suite's curve, such as how many obstacles there are; None if
            there is no curve.
        expected: `SOLVED`, or a key of `EXPECTED` where the world is infeasible by construction.
    """

    scenario: dict[str, Any]
    feasible: bool
    level: float | None = None
    expected: str = SOLVED


class Sampler(Section, ABC):
    """Samples instances by seed. Samplers are sections of a suite file."""

    LEVEL_NAME: ClassVar[str | None] = None
    """`level_name` where it is the same for all sections of a kind."""

    @property
    def individual_goals(self) -> bool:
        """Whether each robot has a goal of its own, instead of a formation's."""
        return False

    @property
    def level_name(self) -> str | None:
        """Name of the curve's axis, with its unit; None if there is no curve."""
        return self.LEVEL_NAME

    def limit(self, data: DataFolder) -> int | None:
        """How many different worlds there are; None if there is no end of them."""
        return None

    def missing(self, data: DataFolder) -> str | None:
        """What data are absent, in one line; None if all are there."""
        return None

    @abstractmethod
    def sample(self, seed: int, data: DataFolder) -> Instance:
        """Instance number `seed`, always the same."""


def _pair(value: Any) -> Any:
    """A single number as the range that holds nothing else."""
    if isinstance(value, list | tuple):
        if len(value) != 2:
            raise expected("expected a number or [least, most]")
        return value
    return (value, value)


def _rising(value: tuple[Any, Any]) -> tuple[Any, Any]:
    if value[0] > value[1]:
        raise expected("expected [least, most]")
    return value


Count = Annotated[int, Strict(), Field(ge=0, le=10_000)]
Counts = Annotated[tuple[Count, Count], BeforeValidator(_pair), AfterValidator(_rising)]
Lengths = Annotated[tuple[Length, Length], BeforeValidator(_pair), AfterValidator(_rising)]
"""`Counts` and `Lengths` may be given as one number or as a range to sample from."""


def sample_count(rng: np.random.Generator, bounds: tuple[int, int]) -> int:
    """A whole number, both bounds included."""
    return int(rng.integers(bounds[0], bounds[1] + 1))


def rounded(pose: Sequence[float]) -> Pose:
    """The pose in tenths of a millimetre and of a milliradian."""
    x, y, yaw = (round(float(value), 4) for value in pose)
    return x, y, yaw


def open_world(size: Sequence[float], solids: Sequence[Shape] = ()) -> dict[str, Any]:
    """Ground of that size with what stands on it, as the `world` of a scenario file."""
    world: dict[str, Any] = {"empty": {"size": list(size)}}
    if solids:
        world["obstacles"] = [shape_to_mapping(shape) for shape in solids]
    return world


def generated_world(world: GeneratedWorld, options: Mapping[str, Any]) -> dict[str, Any]:
    """A sample of a generator as the `world` of a scenario file."""
    source = {"kind": world.kind, "size": list(world.size), "seed": world.seed}
    return {"generate": {**source, "require_feasible": False, **options}}


def sample_length(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    """A length in whole millimetres, m."""
    return round(float(rng.uniform(*bounds)), 3)
