"""What every draw gives, and what a campaign asks of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from cavalcade.campaign.draws.data import DataFolder


@dataclass(frozen=True)
class Drawn:
    """A world with a team and its task.

    Attributes:
        scenario: As a scenario file says it; file names are absolute. A planner section is that
            of the file it came from; its variant gives way to the trial's.
        feasible: A disc of 0.30 m radius gets from every start to every slot at the goal, see
            `feasibility`. The planner has no part in it.
        level: Where it lies on the suite's curve, such as how many obstacles there are; None if
            there is no curve.
    """

    scenario: dict[str, Any]
    feasible: bool
    level: float | None = None


class Draw(Protocol):
    """Draws worlds by seed. Implementations are sections of a suite file."""

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
