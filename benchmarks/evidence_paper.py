"""The paper's four scenarios, and what its figures show happening in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
from evidence_bars import Bar, reasons
from evidence_trials import Finished, Outcome, Trial

from cavalcade.geometry import Array
from cavalcade.running.frames import Recording
from cavalcade.scenario import World, load_scenario
from cavalcade.world.shapes import Circle, distance_to_shapes

NAMES = ("square-clutter", "cone", "triangle-lab", "triangle-corridor")
LEAST_OBSTACLE, LEAST_PAIR = 0.30, 0.60
"""The paper's limits for the distances of robots' centres to obstacles and to each other, m."""

# The middle section of the corridor, between its two bends: where its centre line begins and ends.
_SECTION = np.array([[4.1, 4.6], [5.4, 2.0]])
_HALF_WIDTH = 0.5
_AROUND_MIDDLE = 0.5
"""How far along the corridor from its middle robots are looked at, m."""

EXPLAINED: Mapping[tuple[str, str], str] = MappingProxyType(
    {
        ("published", "square-clutter"): "the published rule keeps centres 0.60 m apart, as the "
        "other bars show, but bodies of 0.65 m touch nose to tail at that distance"
    }
)
"""(variant, scenario) to the reason why the published rule fails there by oriented footprints."""

_BY_FOOTPRINT = ("success", "footprint gap")
"""Bars that such a reason covers; all others hold whatever the reason."""

SIDE = 1.15
"""Of the triangle, m."""


def trial(seed: int, variant: str) -> Trial:
    """Number `seed` of the scenarios."""
    name = NAMES[seed]
    overrides = {"planner.variant": variant}
    return Trial("scenarios", variant, name, seed, True, lambda: load_scenario(name, overrides))


def measure(trial: Trial, done: Finished) -> dict[str, Any]:
    """What is shown of the scenario, by name."""
    recording = done.recording
    found: dict[str, Any] = {"checked_gap": _checked_gap(done)}
    if trial.name == "square-clutter":
        found["leader_changes"] = done.summary["leader_changes"]
        found["exchanges"] = exchanges(recording)
    elif trial.name == "cone":
        found["other_side"] = other_side(recording, done.world)
    elif trial.name == "triangle-corridor":
        found["spread"] = corridor_spread(recording, done.world)
        found["sides"] = side_error(recording)
    return found


def exchanges(recording: Recording) -> int:
    """Pairs of robots that at some time have each the slot that the other had before."""
    roles = recording.roles
    seen = roles[np.r_[True, (np.diff(roles, axis=0) != 0).any(axis=1)]]
    count = 0
    for a, b in combinations(range(roles.shape[1]), 2):
        held = [(int(now[a]), int(now[b])) for now in seen if now[a] >= 0 and now[b] >= 0]
        count += any((y, x) in held[:k] for k, (x, y) in enumerate(held))
    return count


def other_side(recording: Recording, world: World) -> int:
    """How many robots pass the cone on the other side than the one that leads them past it."""
    cone = next(shape for shape in world.shapes if isinstance(shape, Circle))
    x, y = recording.poses[..., 0] - cone.center[0], recording.poses[..., 1] - cone.center[1]
    passed = x >= 0.0
    if not passed[-1].all():
        return 0
    cycles = passed.argmax(axis=0)
    sides = np.sign(y[cycles, np.arange(len(cycles))])
    leaders = [status.leader for status in recording.status[: int(cycles.min()) + 1]]
    leader = next((robot for robot in reversed(leaders) if robot >= 0), int(cycles.argmin()))
    return int(np.count_nonzero(sides != sides[leader]))


def corridor_spread(recording: Recording, world: World) -> float | None:
    """Width across the corridor of all the robots' ways near its middle, m.

    None if not all robots have been there.
    """
    begin, end = _SECTION
    length = float(np.hypot(*(end - begin)))
    along = (end - begin) / length
    across = np.array([-along[1], along[0]])
    middle = (begin + end) / 2.0
    width = distance_to_shapes(world.shapes, [middle])[0]
    if abs(width - _HALF_WIDTH) > 0.01:
        raise ValueError("the corridor is not where it is looked for")
    offset = recording.poses[..., :2] - middle
    near = np.abs(offset @ along) <= _AROUND_MIDDLE
    # The rest of the arena lies beside the section's own line, outside its walls.
    near &= np.abs(offset @ across) <= _HALF_WIDTH
    if not near.any(axis=0).all():
        return None
    return float(np.ptp((offset @ across)[near]))


def side_error(recording: Recording) -> float:
    """Largest deviation of the triangle's sides at the end from their length, as a share."""
    return float(np.abs(_sides(recording.poses[-1]) / SIDE - 1.0).max())


def bars(outcomes: Sequence[Outcome]) -> list[Bar]:
    """The verdict, scenario by scenario; what is explained counts as met."""
    found: list[Bar] = []
    for outcome in outcomes:
        why = EXPLAINED.get((outcome.trial.variant, outcome.trial.name))
        for bar in _bars(outcome):
            covered = any(f": {text}" in bar.text for text in _BY_FOOTPRINT)
            waived = why is not None and not bar.met and covered
            found.append(Bar(bar.text, f"{bar.found} ({why})", True) if waived else bar)
    return found


def _bars(outcome: Outcome) -> list[Bar]:
    found: list[Bar] = []
    name, summary, figures = outcome.trial.name, outcome.summary, outcome.figures
    found.append(Bar(f"{name}: success, clean by the checker", _ended(outcome), outcome.success))
    if not summary:
        return found
    found.append(_above(f"{name}: footprint gap", figures["checked_gap"], 0.0))
    obstacle, pair = summary["min_obstacle_distance_m"], summary["min_robot_distance_m"]
    found.append(_above(f"{name}: obstacle distance", obstacle, LEAST_OBSTACLE))
    found.append(_above(f"{name}: pair distance", pair, LEAST_PAIR))
    if name == "square-clutter":
        for key, text in (("leader_changes", "leader changes"), ("exchanges", "exchanges")):
            value = figures[key]
            found.append(Bar(f"{name}: {text} >= 1", str(value), value >= 1))
    elif name == "cone":
        value = figures["other_side"]
        found.append(Bar(f"{name}: robots on the other side >= 1", str(value), value >= 1))
    elif name == "triangle-corridor":
        found.append(_below(f"{name}: lateral spread at the middle", figures["spread"], 0.25))
        value = figures["sides"]
        text = f"{name}: sides at the end within 5 % of {SIDE} m"
        found.append(Bar(text, f"{value:.1%} off", value <= 0.05))
    return found


def describe(outcomes: Sequence[Outcome]) -> list[str]:
    """How they ended."""
    return [reasons(outcomes)]


def _checked_gap(done: Finished) -> float | None:
    figures = done.report.figures
    return None if figures is None else figures.min_footprint_gap_m


def _sides(poses: Array) -> Array:
    return np.array([np.hypot(*(a - b)) for a, b in combinations(poses[:, :2], 2)])


def _ended(outcome: Outcome) -> str:
    words = [outcome.reason, outcome.detail, *outcome.violations[:1]]
    return "; ".join(word for word in words if word)


def _above(text: str, value: float | None, limit: float) -> Bar:
    said = "not measured" if value is None else f"{value:.3f} m"
    return Bar(f"{text} > {limit:.2f} m", said, value is not None and value > limit)


def _below(text: str, value: float | None, limit: float) -> Bar:
    said = "not measured" if value is None else f"{value:.3f} m"
    return Bar(f"{text} < {limit:.2f} m", said, value is not None and value < limit)
