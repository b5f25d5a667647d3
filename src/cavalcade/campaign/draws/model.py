"""What every draw gives, and what a campaign asks of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol

from cavalcade.campaign.draws.data import DataFolder

SOLVED, INFEASIBLE, UNSOLVED, REFUSED = "solved", "infeasible", "unsolved", "refused"

EXPECTED: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {INFEASIBLE: ("infeasible",), UNSOLVED: ("infeasible", "budget"), REFUSED: ("refused",)}
)
"""With which outcomes a trial succeeds in worlds that are infeasible by construction: where that
can be proven at once, where it cannot, and where the scenario is bad input."""


@dataclass(frozen=True)
class Drawn:
    """A world with a team and its task.

    Attributes:
        scenario: As a scenario file says it; file names are absolute. A planner section is that
            of the file it came from; its variant gives way to the trial's.
        feasible: A disc of 0.30 m radius gets from every start to every slot at the goal, see
            `feasibility`; with goals of single robots a disc of half the body's width gets from
            each start to its goal. The planner has no part in it.
        level: Where it lies on the suite's curve, such as how many obstacles there are; None if
            there is no curve.
        expected: `SOLVED`, or a key of `EXPECTED` where the world is infeasible by construction.
    """

    scenario: dict[str, Any]
    feasible: bool
    level: float | None = None
    expected: str = SOLVED


class Draw(Protocol):
    """Draws worlds by seed. Implementations are sections of a suite file."""

    @property
    def own_goals(self) -> bool:
        """Whether each robot has a goal of its own, instead of a formation's."""

    @property
    def level_name(self) -> str | None:
        """Name of the curve's axis, with its unit; None if there is no curve."""

    def limit(self, data: DataFolder) -> int | None:
        """How many different worlds there are; None if there is no end of them."""

    def missing(self, data: DataFolder) -> str | None:
        """What data are absent, in one line; None if all are there."""

    def draw_world(self, seed: int, data: DataFolder) -> Drawn:
        """World number `seed`, always the same.

        Raises:
            InputError: The section's values allow no world, or data are missing or malformed.
        """
