"""The parts of a scenario file that all draws write alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cavalcade.campaign.draws.teams import TeamSection


def scenario_data(
    name: str,
    world: Mapping[str, Any],
    team: TeamSection,
    start: Sequence[float],
    goal: Sequence[float],
    timeout: float,
    seed: int,
) -> dict[str, Any]:
    """A scenario as its file says it, without a planner section.

    Args:
        name: Of the scenario.
        world: Its `world`.
        team: Who drives.
        start, goal: Poses (x, y, yaw) of the formation's centre, m and rad.
        timeout: s of simulated time.
        seed: Of all that is random in the execution.
    """
    return {
        "version": 1,
        "name": name,
        "world": dict(world),
        "robots": team.starts(start),
        "task": {"formation": team.words, "goals": [[float(value) for value in goal]]},
        "execution": {"timeout": timeout, "seed": seed},
    }
