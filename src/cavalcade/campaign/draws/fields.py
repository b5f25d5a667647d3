"""Values that a suite file may give as one number or as a range to draw from."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, Strict

from cavalcade.scenario.fields import Length, expected


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


def draw_count(rng: np.random.Generator, bounds: tuple[int, int]) -> int:
    """A whole number, both bounds included."""
    return int(rng.integers(bounds[0], bounds[1] + 1))


def draw_length(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    """A length in whole millimetres, m."""
    return round(float(rng.uniform(*bounds)), 3)
