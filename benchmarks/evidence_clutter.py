"""The clutter suites: 100 seeded worlds each of 14 x 10 m with 25 or with 45 obstacles.

Every world is the generator's first draw. It counts as feasible if the robots can stand at their
starts and a disc of 0.30 m radius gets from every start to every slot at the goal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from evidence_bars import Bar, at_most, distribution, median, none_of, proportion, reasons
from evidence_trials import REFUSED, Finished, Outcome, Trial

from cavalcade.formation import Formation
from cavalcade.geometry import Array
from cavalcade.running.formation_error import formation_errors
from cavalcade.scenario import parse_scenario
from cavalcade.world import Shape, generate, is_connected
from cavalcade.world.shapes import distance_to_shapes

SIZE = (14.0, 10.0)
START, GOAL = (1.4, 5.0, 0.0), (12.6, 5.0, 0.0)
SIDE = 1.0
RADIUS = 0.30
"""Of the disc that decides whether a world is feasible, m."""

STEP = 0.0125
"""Distance of the nodes of that decision, m."""

TOP_SPEED = 0.5
"""m/s"""

OPEN = 1.5
"""Clearance of every robot's centre to the nearest obstacle on open stretches, m."""

SHORTEST_OPEN = 1.0
"""Runs with less time on open stretches than this, s, say nothing about them."""


def slots(pose: Sequence[float], formation: Formation | None = None) -> Array:
    """Places `(N, 2)` of the square, or another formation, at a pose."""
    return (formation or Formation.square(SIDE)).placed(pose)


def passable(shapes: Sequence[Shape], starts: Array, goals: Array, radius: float = RADIUS) -> bool:
    """Whether the disc gets from every start `(N, 2)` to every goal `(M, 2)`."""
    pairs = [(start, goals[0]) for start in starts] + [(starts[0], goal) for goal in goals[1:]]
    return all(is_connected(shapes, SIZE, a, b, radius, STEP) for a, b in pairs)


def clutter_data(seed: int, obstacles: int, variant: str) -> dict[str, Any]:
    """The scenario of one world, as a file would say it."""
    starts = [[round(x, 6), round(y, 6), START[2]] for x, y in slots(START).tolist()]
    return {
        "version": 1,
        "name": f"clutter-{obstacles}-{seed}",
        "world": {
            "generate": {
                "kind": "clutter",
                "size": list(SIZE),
                "obstacles": obstacles,
                "seed": seed,
                "require_feasible": False,
            }
        },
        "robots": [{"model": "go1", "start": start} for start in starts],
        "task": {"formation": {"shape": "square", "side": SIDE}, "goals": [list(GOAL)]},
        "planner": {"method": "formation", "variant": variant},
        "execution": {"timeout": 180.0, "seed": seed},
    }


def clutter_trial(suite: str, obstacles: int, seed: int, variant: str) -> Trial:
    """One world with its verdict on feasibility."""
    drawn = generate("clutter", SIZE, seed, obstacles=obstacles, require_feasible=False)
    feasible = passable(drawn.shapes, slots(START), slots(GOAL))
    data = clutter_data(seed, obstacles, variant)
    return Trial(suite, variant, f"seed {seed}", seed, feasible, lambda: parse_scenario(data))


def measure(trial: Trial, done: Finished) -> dict[str, Any]:
    """Time against the lower bound, and the formation error on open stretches."""
    bounds = [bound for bound in done.summary["lower_bound_m"] if bound is not None]
    time = float(done.summary["sim_time_s"])
    errors, taking_part = formation_errors(done.recording)
    poses = done.recording.poses
    clearance = distance_to_shapes(done.world.shapes, poses[..., :2].reshape(-1, 2))
    is_open = (clearance.reshape(poses.shape[:2]) >= OPEN).all(axis=1) & taking_part.all(axis=1)
    open_time = float(np.count_nonzero(is_open) / done.scenario.execution.rate)
    return {
        "ratio": time * TOP_SPEED / max(bounds) if bounds else None,
        "open_s": open_time,
        "open_error": float(errors[is_open].mean()) if open_time >= SHORTEST_OPEN else None,
    }


def safe_and_successful(outcomes: Sequence[Outcome]) -> list[Bar]:
    """The bars of both suites."""
    run = [outcome for outcome in outcomes if outcome.reason != REFUSED]
    feasible = [outcome for outcome in outcomes if outcome.trial.feasible]
    met = [outcome for outcome in feasible if outcome.success]
    hit = [outcome.trial.name for outcome in run if outcome.contacts]
    broken = [o.trial.name for o in run if len(o.violations) > o.contacts]
    crashed = [outcome.trial.name for outcome in outcomes if outcome.reason == "crashed"]
    refused = [outcome.trial.name for outcome in feasible if outcome.reason == REFUSED]
    return [
        none_of("worlds with a collision: none", hit, len(run)),
        none_of("worlds with any other violation: none", broken, len(run)),
        proportion("feasible worlds succeed", len(met), len(feasible), 0.99),
        none_of("failures without a type: none", crashed + refused, len(outcomes)),
    ]


def efficient(outcomes: Sequence[Outcome]) -> list[Bar]:
    """The further bars of the sparse suite, over the worlds that succeeded."""
    done = [outcome for outcome in outcomes if outcome.success]
    ratios = [o.figures["ratio"] for o in done if o.figures["ratio"] is not None]
    errors = [float(o.summary["formation_error_m"]["mean"]) for o in done]
    in_open = [o.figures["open_error"] for o in done if o.figures["open_error"] is not None]
    return [
        at_most("median of time / (longest lower bound / 0.5 m/s)", median(ratios), 1.5),
        at_most("median mean formation error", median(errors), 0.20, " m"),
        at_most(f"the same where all have {OPEN:g} m clearance", median(in_open), 0.10, " m"),
    ]


def describe(outcomes: Sequence[Outcome]) -> list[str]:
    """Distributions over the worlds that succeeded."""
    done = [outcome for outcome in outcomes if outcome.success]
    infeasible = [o.trial.name for o in outcomes if not o.trial.feasible]
    rescued = sum(outcome.success for outcome in outcomes if not outcome.trial.feasible)
    lines = [reasons(outcomes)]
    lines.append(f"  infeasible: {len(infeasible)}, of which {rescued} succeeded all the same")
    keys = ("sim_time_s", "min_obstacle_distance_m", "min_robot_distance_m", "min_footprint_gap_m")
    lines += [distribution(key, [o.summary[key] for o in done]) for key in keys]
    lines.append(distribution("time / bound", [o.figures["ratio"] for o in done]))
    for key in ("mean", "p95", "max"):
        values = [outcome.summary["formation_error_m"][key] for outcome in done]
        lines.append(distribution(f"formation error ({key}), m", values))
    lines.append(distribution("error in the open, m", [o.figures["open_error"] for o in done]))
    seconds = math.fsum(outcome.figures["open_s"] for outcome in done)
    lines.append(f"  time in the open: {seconds:.0f} s over {len(done)} runs")
    return lines
