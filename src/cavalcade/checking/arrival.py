"""Whether a team that claims to have arrived, or to be done, ends where it should, and still.

Robots in a formation stand in its slots, those with goals of their own at these, those that follow
commands where they were sent last.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.checking.report import Violation, broken
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array, transform_points, wrap_angle
from cavalcade.scenario import FormationSection, Scenario


@dataclass(frozen=True)
class Criterion:
    """When a robot has arrived: how near its slot, m and rad, how slow, m/s, and for how long, s.

    With `mean` the mean speed over that time counts, not every moment's: legged robots sway.
    """

    distance: float = 0.10
    turn: float = 0.15
    speed: float = 0.02
    still: float = 0.5
    mean: bool = False


IDEAL = Criterion()
"""The contract's."""

PHYSICS = Criterion(distance=0.15, turn=0.2, speed=0.05, mean=True)
"""The contract's for robots in physics."""

_SLACK = 1e-3
"""For each of them, m, rad or m/s: rounding."""

AWAY = 0.25
"""A robot that was sent to a point ends no farther from it than this, m; it stands as soon as it is
within 0.10 m, and its stopping distance and sway are left to it."""


def check_arrival(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    goal_moved: float,
    criterion: Criterion = IDEAL,
) -> list[Violation]:
    """What contradicts the claim that the whole team has arrived.

    The goal is said to have been moved by `goal_moved` m to fit. After the loss of a robot the
    shape is the planner's choice: then only stillness, heading and a place within the shape's
    extent are checked.
    """
    goal, formation, present = _task_at(scenario, max(float(track.time[-1]) for track in tracks))
    final = np.array([tracks[k].pose[-1] for k in present])
    slots = transform_points(goal, slots_of(formation, len(scenario.robots)))
    if len(present) == len(scenario.robots) and len(slots) == len(final):
        errors, limit = _slot_errors(final[:, :2], slots, goal_moved), criterion.distance
        words = "its slot"
    else:
        centre = np.array(goal[:2])
        errors = np.hypot(*(final[:, :2] - centre).T)
        limit = float(np.hypot(*(slots - centre).T).max()) + criterion.distance + goal_moved
        words = "the goal"
    turns = np.abs(wrap_angle(final[:, 2] - goal[2]))
    return _standing(scenario, tracks, present, errors, turns, words, criterion, limit)


def check_own_arrival(
    scenario: Scenario, tracks: tuple[Track, ...], criterion: Criterion = IDEAL
) -> list[Violation]:
    """What contradicts the claim that every robot stands at its goal."""
    final = np.array([track.pose[-1] for track in tracks])
    goals = np.array(scenario.goals)
    errors = np.hypot(*(final[:, :2] - goals[:, :2]).T)
    turns = np.abs(wrap_angle(final[:, 2] - goals[:, 2]))
    # Where a robot that goes in all directions looks is of no interest.
    turns[[model.drive.startswith("integrator") for model in scenario.models]] = 0.0
    everyone, limit = range(len(tracks)), criterion.distance
    return _standing(scenario, tracks, everyone, errors, turns, "its goal", criterion, limit)


def check_commands(scenario: Scenario, tracks: tuple[Track, ...]) -> list[Violation]:
    """What contradicts the claim that the task is done.

    It has lasted as long as it should, and every robot ends where it was sent last, if anywhere.
    """
    task = scenario.task
    end = max(float(track.time[-1]) for track in tracks)
    length = task.length - 1e-6
    result = []
    if end < length:
        text = f"the task claims to be done after {end:.2f} s of {task.length:.2f} s"
        result.append(Violation("arrival", end, tuple(range(len(tracks))), text, end, length))
    places: list[tuple[float, float] | None] = [None] * len(tracks)
    for command in task.commands or ():
        for robot in range(len(tracks)):
            if command.robot in (None, robot):
                places[robot] = command.to
    for robot, (place, track) in enumerate(zip(places, tracks, strict=True)):
        away = 0.0 if place is None else math.dist(place, track.pose[-1, :2])
        if away > AWAY:
            text = f"robot {robot} claims to have arrived but ends {away:.3f} m from its point"
            result.append(broken("arrival", end, robot, text, away, AWAY))
    return result


def _standing(
    scenario: Scenario,
    tracks: tuple[Track, ...],
    robots: Sequence[int],
    errors: Array,
    turns: Array,
    words: str,
    criterion: Criterion,
    limit: float,
) -> list[Violation]:
    """Robots that are too far off, turned or not yet still.

    `errors`, m from what `words` say, and `turns`, rad, are those of `robots`; `limit` is that of
    the errors. The scenario's cycle counts.
    """
    end = max(float(track.time[-1]) for track in tracks)
    result = []
    for robot, error, turn in zip(robots, errors, turns, strict=True):
        where = f"robot {robot} claims to have arrived"
        if error > limit + _SLACK:
            text = f"{where} but stands {error:.3f} m from {words}"
            result.append(broken("arrival", end, robot, text, error, limit))
        if turn > criterion.turn + _SLACK:
            text = f"{where} but is turned by {turn:.3f} rad from the goal's heading"
            result.append(broken("arrival", end, robot, text, turn, criterion.turn))
        speed = _late_speed(tracks[robot], 1.0 / scenario.execution.rate, criterion)
        if speed > criterion.speed + _SLACK:
            text = f"{where} but moved at {speed:.3f} m/s in the last {criterion.still:g} s"
            result.append(broken("arrival", end, robot, text, speed, criterion.speed))
    return result


def _task_at(
    scenario: Scenario, end: float
) -> tuple[tuple[float, float, float], FormationSection, tuple[int, ...]]:
    """The last goal and formation, and the robots that take part at the end."""
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
    return goals[-1], formation, tuple(k for k in range(len(scenario.robots)) if k not in lost)


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
    return np.hypot(*(rest - best).T)


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


def slots_of(formation: FormationSection, robots: int) -> Array:
    """Slots `(robots, 2)` in m: a second reading of the scenario file's shapes.

    Formation frame: x forward, y left, the origin at the formation's centre.
    """
    steps = np.arange(robots, dtype=float)
    if formation.slots is not None:
        return np.array(formation.slots, dtype=float)
    if formation.shape == "square":
        return _ring(4, _size(formation.side) / np.sqrt(2.0))
    if formation.shape == "triangle":
        return _ring(3, _size(formation.side) / np.sqrt(3.0))
    if formation.shape == "circle":
        return _ring(robots, _size(formation.radius) if robots > 1 else 0.0)
    spacing = _size(formation.spacing)
    middle = (robots - 1) / 2.0
    if formation.shape == "line":
        return np.column_stack((np.zeros(robots), (middle - steps) * spacing))
    if formation.shape == "column":
        return np.column_stack(((middle - steps) * spacing, np.zeros(robots)))
    # A wedge: two arms at right angles, the tip in front and on the axis, however long the arms.
    arm = np.ceil(steps / 2.0) * spacing / np.sqrt(2.0)
    side = np.where(steps % 2 == 1, 1.0, -1.0)
    return np.column_stack((arm.mean() - arm, side * arm))


def _ring(count: int, radius: float) -> Array:
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def _size(value: float | None) -> float:
    if value is None:
        raise ValueError("the scenario is not resolved")
    return value
