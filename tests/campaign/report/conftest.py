"""Made-up trial lines, of the shape that campaigns leave in `trials.jsonl`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.campaign.report.trials import TrialTable
from cavalcade.campaign.table import write_table

VERSIONS = {"python": "3.12.1", "cavalcade": "0.1.0", "numpy": "2.4.6", "numba": "0.68.1"}
SKILL = {"cavalcade": 0.985, "published": 0.86, "no-springs": 0.98}
Lines = list[dict[str, Any]]


@dataclass(frozen=True)
class Group:
    name: str


@dataclass(frozen=True)
class MadeUpSuite:
    """What the report reads of a suite."""

    suite: str = "made-up"
    about: str = "Four robots in a square cross 14 x 10 m with 15 to 50 obstacles"
    variants: tuple[str, ...] = ("cavalcade", "published", "no-springs")
    disturbances: dict[str, Any] = field(default_factory=dict)
    worlds: tuple[Group, ...] = (Group("clutter"), Group("forest"))


def made_up_line(
    scenario: str, seed: int, disturbance: str, variant: str, rng: np.random.Generator
) -> dict[str, Any]:
    """One trial; the world depends on scenario and seed alone."""
    world = np.random.default_rng([seed, len(scenario)])
    obstacles = int(world.integers(15, 51))
    feasible = bool(world.random() > 0.04)
    ease = world.random()
    bar = SKILL.get(variant, 0.95) - 0.001 * (obstacles - 15)
    bar -= {"none": 0.0}.get(disturbance, 0.04)
    success = feasible and bool(0.7 * ease + 0.3 * rng.random() < bar)
    outcome, detail, contacts = "arrived", "", 0
    if not feasible:
        outcome, detail = "infeasible", "robot 2 has no way to its slot"
    elif not success:
        kinds = ["stuck", "timeout", *(["collision"] if variant == "published" else [])]
        outcome = str(rng.choice(kinds))
        detail = {
            "stuck": f"nobody moved for {rng.random() * 5 + 10:.1f} s; read from /tmp/x1/a.yaml",
            "timeout": "180 s are over",
            "collision": "",
        }[outcome]
        contacts = int(outcome == "collision")
    time = 30.0 + 0.3 * obstacles + 4.0 * ease + rng.gamma(2.0, 1.5)
    time += 3.0 if variant == "published" else 0.0
    gap = 0.0 if contacts else float(np.round(0.02 + 0.1 * rng.random(), 6))
    several = disturbance != "none"
    return {
        "trial": f"{scenario}.{seed:04d}.{variant}" + (f".{disturbance}" if several else ""),
        "suite": "made-up",
        "scenario": scenario,
        "variant": variant,
        "disturbance": disturbance,
        "seed": seed,
        "outcome": outcome,
        "detail": detail,
        "success": success,
        "feasible": feasible,
        "level": float(obstacles),
        "level_name": "obstacles",
        "contacts": contacts,
        "avoidable": contacts,
        "violations": ["12.30 s robot-obstacle: robot 1 touches circle 3"] * contacts,
        "measured": {"time_ratio": round(time / 22.4, 4) if success else None},
        "summary": {
            "name": f"{scenario}-{seed}",
            "version": 1,
            "seed": seed,
            "method": "formation",
            "variant": variant,
            "backend": "ideal",
            "robots": 4,
            "success": success,
            "reason": outcome,
            "detail": detail or None,
            "involved": [],
            "sim_time_s": round(time, 3) if success else 180.0,
            "wall_time_s": 1.5,
            "makespan_s": round(time, 3) if success else None,
            "min_obstacle_distance_m": round(0.2 + gap, 6),
            "min_robot_distance_m": round(0.5 + gap, 6),
            "min_footprint_gap_m": gap,
            "collisions": {"robot_robot": 0, "robot_obstacle": contacts},
            "falls": 0,
            "formation_error_m": {
                "mean": round(0.05 + 0.002 * obstacles + 0.02 * rng.random(), 6),
                "p95": 0.3,
                "max": 0.5,
            },
            "leader_changes": 3,
            "role_changes": 4,
            "cycle_ms": {"p50": 1.1, "p99": round(3.0 + 2.0 * rng.random(), 3), "max": 9.5},
            "planning_time_s": 1.2,
            "path_length_m": [12.0, 12.5, 12.25, None],
            "lower_bound_m": [11.2, 11.2, 11.2, 11.2],
            "duration_s": [time, time, time, time],
            "goal_error_m": [0.01, 0.01, 0.02, 0.01],
            "goal_moved_m": 0.0,
            "versions": VERSIONS,
        },
    }


def made_up_lines(
    worlds: int = 60,
    scenarios: Sequence[str] = ("clutter", "forest"),
    disturbances: Sequence[str] = ("none",),
    variants: Sequence[str] = ("cavalcade", "published", "no-springs"),
) -> Lines:
    """A whole campaign."""
    rng = np.random.default_rng(7)
    return [
        made_up_line(scenario, seed, disturbance, variant, rng)
        for scenario in scenarios
        for seed in range(worlds)
        for disturbance in disturbances
        for variant in variants
    ]


@pytest.fixture(scope="session")
def make_lines() -> Callable[..., Lines]:
    """Makes lines of a campaign of the size asked for."""
    return made_up_lines


@pytest.fixture(scope="session")
def suite() -> MadeUpSuite:
    """The suite of these lines."""
    return MadeUpSuite()


def plain_line(
    name: str | int,
    scenario: str = "a",
    variant: str = "cavalcade",
    disturbance: str = "none",
    outcome: str = "arrived",
    summary: dict[str, Any] | None = None,
    **changes: Any,
) -> dict[str, Any]:
    """A trial that succeeded unless something else is said."""
    line = {
        "trial": f"{scenario}.{name}.{variant}.{disturbance}",
        "scenario": scenario,
        "variant": variant,
        "disturbance": disturbance,
        "seed": name if isinstance(name, int) else 0,
        "outcome": outcome,
        "success": outcome == "arrived",
        "feasible": True,
        "summary": {"reason": outcome} if summary is None else summary,
    }
    return line | changes


@pytest.fixture(scope="session")
def make_line() -> Callable[..., dict[str, Any]]:
    """Makes a line of which little is known."""
    return plain_line


@pytest.fixture
def open_table(tmp_path: Path) -> Iterator[Callable[..., TrialTable]]:
    """Opens the table of some lines, of a suite."""
    with ExitStack() as stack:

        def opened(lines: Sequence[dict[str, Any]], suite: object = None) -> TrialTable:
            return stack.enter_context(TrialTable(write_table(tmp_path, lines), suite))

        yield opened


@pytest.fixture
def bare_line() -> dict[str, Any]:
    """A trial of which nothing is known but that it crashed."""
    return {
        "trial": "clutter.0000.cavalcade",
        "suite": "made-up",
        "scenario": "clutter",
        "variant": "cavalcade",
        "disturbance": "none",
        "seed": 0,
        "outcome": "crashed",
        "detail": "ValueError: pid 4321 died (/opt/x/planner.py:12)",
        "success": False,
        "feasible": True,
        "level": None,
        "level_name": None,
        "contacts": 0,
        "avoidable": 0,
        "violations": [],
        "measured": {"time_ratio": None},
        "summary": {},
    }
