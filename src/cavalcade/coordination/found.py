"""What a method found, solved or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cavalcade.coordination.course import Course


@dataclass(frozen=True)
class Found:
    """Courses of all robots.

    Attributes:
        courses: A course for each robot; free of conflicts if `solved`.
        solved: Whether they are a plan.
        method: Which method it was; empty where no two robots were in conflict.
        counts: Figures of the method.
        history: Iterations and summed cost as the plan got better.
    """

    courses: tuple[Course, ...]
    solved: bool
    method: str
    counts: Mapping[str, int] = field(default_factory=dict)
    history: tuple[tuple[int, float], ...] = ()
