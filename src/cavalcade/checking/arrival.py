"""Whether a team that claims to have arrived stands in its slots, still, and facing the goal."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cavalcade.checking.report import Violation
from cavalcade.checking.slots import slots_of
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array, transform_points, wrap_angle
from cavalcade.scenario import FormationSection, Scenario


@dataclass(frozen=True)
class Criterion:
    """When a robot has arrived.

    Attributes:
        distance, turn: Of the slot, m and rad.
        speed: Slower than this, m/s.
        still: For so long, s.
        mean: Whether the mean over that time counts, not every moment: legged robots sway.
    """

    distance: float = 0.10
    turn: float = 0.15
    speed: float = 0.02
    still: float = 0.5
    mean: bool = False


IDEAL = Criterion()
"""The contract's."""

DISTANCE, TURN = IDEAL.distance, IDEAL.turn

PHYSICS = Criterion(distance=0.15, turn=0.2, speed=0.05, mean=True)
"""The contract's for robots in physics."""

_SLACK = 1e-3
"""For each of them, m, rad or m/s: rounding."""


@dataclass(frozen=True)
class _Task:
    """What holds at the end: the last goal and formation, and the robots that take part."""

    goal: tuple[float, float, float]
    formation: FormationSection
    whole: bool
    present: tuple[int, ...]


def check_arrival(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    goal_moved: float,
    criterion: Criterion = IDEAL,
) -> list[Violation]:
    """What contradicts the claim that the whole team has arrived.

    After the loss of a robot the shape is the planner's choice: then only stillness, heading and
    a place within the shape's extent are checked.

    Args:
        scenario: With the goals, the formation and the events that change them.
        tracks: With increasing time stamps.
        goal_moved: How far the goal is said to have been moved to fit, m.
        criterion: When robots have arrived.
    """
    end = max(float(track.time[-1]) for track in tracks)
    task = _task_at(scenario, end)
    final = np.array([tracks[k].pose[-1] for k in task.present])
    slots = transform_points(task.goal, slots_of(task.formation, len(scenario.robots)))
    if task.whole and len(slots) == len(final):
        errors, limit = _slot_errors(final[:, :2], slots, goal_moved), criterion.distance
        words = "its slot"
    else:
        centre = np.array(task.goal[:2])
        errors = np.hypot(*(final[:, :2] - centre).T)
        limit = float(np.hypot(*(slots - centre).T).max()) + criterion.distance + goal_moved
        words = "the goal"
    turns = np.abs(wrap_angle(final[:, 2] - task.goal[2]))
    return standing(scenario, tracks, task.present, errors, turns, end, words, criterion, limit)


def standing(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    robots: tuple[int, ...],
    errors: Array,
    turns: Array,
    end: float,
    words: str,
    criterion: Criterion = IDEAL,
    limit: float | None = None,
) -> list[Violation]:
    """Robots that are too far off, turned or not yet still.

    Args:
        scenario: Whose cycle counts.
        tracks: Of all robots.
        robots: Those that take part.
        errors, turns: Of each of them, m and rad.
        end: When that is, s.
        words: What the distance is from.
        criterion: When a robot has arrived.
        limit: Of the distance, m, if it is not the criterion's.
    """
    limit = criterion.distance if limit is None else limit
    result = []
    for robot, error, turn in zip(robots, errors, turns, strict=True):
        where = f"robot {robot} claims to have arrived"
        if error > limit + _SLACK:
            text = f"{where} but stands {error:.3f} m from {words}"
            result.append(Violation("arrival", end, (robot,), text, float(error), limit))
        if turn > criterion.turn + _SLACK:
            text = f"{where} but is turned by {turn:.3f} rad from the goal's heading"
            result.append(Violation("arrival", end, (robot,), text, float(turn), criterion.turn))
        speed = _late_speed(tracks[robot], 1.0 / scenario.execution.rate, criterion)
        if speed > criterion.speed + _SLACK:
            text = f"{where} but moved at {speed:.3f} m/s in the last {criterion.still:g} s"
            result.append(Violation("arrival", end, (robot,), text, speed, criterion.speed))
    return result


def _task_at(scenario: Scenario, end: float) -> _Task:
    goals, formation = scenario.task.goals, scenario.task.the_formation
    lost: set[int] = set()
    for event in scenario.execution.events:
        if event.at > end:
            break
        goals = event.goals or goals
        formation = event.formation or formation
        if event.lose is not None:
            lost.add(event.lose)
        if event.rejoin is not None:
            lost.discard(event.rejoin)
    present = tuple(k for k in range(len(scenario.robots)) if k not in lost)
    return _Task(goals[-1], formation, not lost, present)


def _late_speed(track: Track, cycle: float, criterion: Criterion) -> float:
    """Largest speed between samples in the last seconds, or the mean over these, m/s."""
    # The cycle in which the robot came to rest may reach into the window.
    late = track.time >= track.time[-1] - criterion.still + cycle - 1e-6
    place, time = track.pose[late, :2], track.time[late]
    if len(time) < 2:
        return math.inf
    if criterion.mean:
        return float(np.hypot(*(place[-1] - place[0])) / (time[-1] - time[0]))
    steps = np.diff(place, axis=0)
    return float((np.hypot(steps[:, 0], steps[:, 1]) / np.diff(time)).max())


def _slot_errors(places: Array, slots: Array, goal_moved: float) -> Array:
    """Distances `(N,)` of robots from the slots they took, the goal moved in their favour."""
    from scipy.optimize import linear_sum_assignment

    shift = places.mean(axis=0) - slots.mean(axis=0)
    shift *= min(1.0, goal_moved / max(float(np.hypot(*shift)), 1e-12))
    gaps = places[:, None] - (slots + shift)[None]
    _, taken = linear_sum_assignment((gaps * gaps).sum(axis=-1))
    rest = places - slots[taken]
    best = _best_shift(rest, goal_moved) if goal_moved > 0.0 else np.zeros(2)
    errors: Array = np.hypot(*(rest - best).T)
    return errors


def _best_shift(rest: Array, most: float) -> Array:
    """The shift `(2,)` no longer than `most` that makes the largest of `rest` `(N, 2)` least."""

    def worst(x: float, y: float) -> float:
        return float(np.hypot(rest[:, 0] - x, rest[:, 1] - y).max())

    def best_y(x: float) -> float:
        span = math.sqrt(max(most * most - x * x, 0.0))
        return _least(lambda y: worst(x, y), -span, span)

    x = _least(lambda x: worst(x, best_y(x)), -most, most)
    return np.array([x, best_y(x)])


def _least(value: Callable[[float], float], low: float, high: float) -> float:
    """Where a convex function of one variable is least, by ternary search."""
    for _ in range(60):
        third = (high - low) / 3.0
        if value(low + third) < value(high - third):
            high -= third
        else:
            low += third
    return (low + high) / 2.0
