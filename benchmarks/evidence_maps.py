"""Four robots on maps that real robots have made, over 20 m and more.

The maps are the depot and the warehouse of Nav2, which are not part of this project: `DATA` says
where they are looked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evidence_bars import Bar, none_of, reasons
from evidence_clutter import SIDE, slots
from evidence_trials import Finished, Outcome, Trial

from cavalcade.scenario import parse_scenario

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "ros_maps" / "nav2"
LEAST_WAY = 20.0
"""Shortest way of any robot alone, m."""

Pose = tuple[float, float, float]
NORTH, WEST = math.pi / 2.0, math.pi


@dataclass(frozen=True)
class Crossing:
    """A way over a map.

    Attributes:
        name: What it leads through.
        map: File below `DATA`.
        start: Pose of the square's centre.
        goals: The poses to go to.
    """

    name: str
    map: str
    start: Pose
    goals: tuple[Pose, ...]


CROSSINGS = (
    # Along the wall behind the pallets, then between two of them (1.4 m) and posts 1.2 m apart.
    Crossing("depot, behind the pallets", "depot.yaml", (2.5, 11.0, 0.0),
             ((24.5, 1.35, 0.0), (24.9, 9.2, NORTH))),
    # Past the posts, down the aisle between the pallets (1.7 m) and west.
    Crossing("depot, between the pallets", "depot.yaml", (19.2, 12.0, -NORTH),
             ((17.2, 1.35, WEST), (3.0, 3.0, WEST))),
    # Out of the western bay, in slalom around the ends of three racks.
    Crossing("warehouse, around the racks", "warehouse.yaml", (-13.0, 10.0, NORTH),
             ((1.0, 22.0, 0.0),)),
    # Out of an aisle between two shelves, past a rack and around a third shelf.
    Crossing("warehouse, out of an aisle", "warehouse.yaml", (2.0, -20.0, NORTH),
             ((1.0, 13.5, 0.0),)),
)  # fmt: skip


def available() -> bool:
    """Whether the maps are there."""
    return all((DATA / crossing.map).is_file() for crossing in CROSSINGS)


def trial(seed: int, variant: str) -> Trial:
    """Number `seed` of the crossings."""
    crossing = CROSSINGS[seed]
    starts = [[x, y, crossing.start[2]] for x, y in slots(crossing.start).tolist()]
    data = {
        "version": 1,
        "name": crossing.name,
        "world": {"map": str(DATA / crossing.map)},
        "robots": [{"model": "go1", "start": start} for start in starts],
        "task": {
            "formation": {"shape": "square", "side": SIDE},
            "goals": [list(goal) for goal in crossing.goals],
        },
        "planner": {"method": "formation", "variant": variant},
        "execution": {"timeout": 600.0},
    }
    return Trial("maps", variant, crossing.name, seed, True, lambda: parse_scenario(data))


def measure(trial: Trial, done: Finished) -> dict[str, Any]:
    """The shortest way that any of the robots could have taken."""
    bounds = [bound for bound in done.summary["lower_bound_m"] if bound is not None]
    return {"way_m": min(bounds, default=None), "cycle_ms": done.summary["cycle_ms"]["p99"]}


def bars(outcomes: Sequence[Outcome]) -> list[Bar]:
    """No collision, everybody there, and the ways long enough."""
    hit = [outcome.trial.name for outcome in outcomes if outcome.contacts]
    failed = [outcome.trial.name for outcome in outcomes if not outcome.success]
    ways = [outcome.figures.get("way_m") for outcome in outcomes]
    far = all(way is not None and way >= LEAST_WAY for way in ways)
    said = ", ".join("?" if way is None else f"{way:.1f} m" for way in ways)
    return [
        none_of("crossings with a collision: none", hit, len(outcomes)),
        none_of("crossings that fail: none", failed, len(outcomes)),
        Bar(f"shortest way of each crossing >= {LEAST_WAY:g} m", said, far),
    ]


def describe(outcomes: Sequence[Outcome]) -> list[str]:
    """How they ended."""
    return [reasons(outcomes)]
