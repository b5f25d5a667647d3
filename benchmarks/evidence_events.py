"""The events suite: seeded clutter in which things happen on the way.

In every world obstacles appear, one or two move across (some of them out of the clutter, at up to
0.5 m/s), the goal and the shape change and a robot is lost, all at random times and places. What
appears may appear next to a robot, or in it: `evidence_avoidable` says what could be avoided. The
worlds are such that the last goal can be reached when all obstacles are at their last places.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from evidence_avoidable import audit
from evidence_bars import Bar, distribution, none_of, proportion, reasons
from evidence_clutter import GOAL, SIZE, START, clutter_data, passable, slots
from evidence_trials import Finished, Outcome, Trial

from cavalcade.formation import Formation
from cavalcade.geometry import transform_points
from cavalcade.scenario import obstacle_spans, parse_scenario
from cavalcade.world import (
    Box,
    Circle,
    Polygon,
    Shape,
    generate,
    shape_from_mapping,
    shape_to_mapping,
)

OBSTACLES = (15, 25)
APPEARING, MOVING = (1, 3), (1, 2)
SPEED = (0.10, 0.50)
"""Of what moves, m/s."""

WAY = (3.0, 8.0)
"""How far it moves, m."""

BAND = (2.8, 11.2)
"""Where obstacles stand, appear and move to: x, m."""

TIMEOUT = 240.0
ROBOTS = 4
ARRIVED = 0.10
"""m, as in the contract"""

SQUEEZE = 0.25
"""Radius of the disc that tells whether a team that did not arrive had a way left, m."""

_SHAPES: tuple[tuple[dict[str, Any], Formation], ...] = (
    ({"shape": "square", "side": 1.2}, Formation.square(1.2)),
    ({"shape": "column", "spacing": 0.9}, Formation.column(ROBOTS, 0.9)),
    ({"shape": "line", "spacing": 0.9}, Formation.line(ROBOTS, 0.9)),
    ({"shape": "wedge", "spacing": 1.0}, Formation.wedge(ROBOTS, 1.0)),
    ({"shape": "circle", "radius": 0.8}, Formation.circle(ROBOTS, 0.8)),
)


def trial(seed: int, variant: str) -> Trial:
    """One world with its events."""
    rng = np.random.default_rng([seed, 2])
    while True:
        count = int(rng.integers(OBSTACLES[0], OBSTACLES[1] + 1))
        drawn = generate(
            "clutter", SIZE, int(rng.integers(2**31)), obstacles=count, require_feasible=False
        )
        if not passable(drawn.shapes, slots(START), slots(GOAL)):
            continue
        events = _events(rng, drawn.shapes)
        if events is not None:
            break
    data = clutter_data(seed, count, variant)
    data["name"] = f"events-{seed}"
    data["world"] = {
        "empty": {"size": list(SIZE)},
        "obstacles": [shape_to_mapping(shape) for shape in drawn.shapes],
    }
    data["execution"] |= {"timeout": TIMEOUT, "events": events}
    return Trial("events", variant, f"seed {seed}", seed, True, lambda: parse_scenario(data))


def _events(rng: np.random.Generator, standing: Sequence[Shape]) -> list[dict[str, Any]] | None:
    """Events in order of time; None if the last goal could not be reached after all of them."""
    events: list[dict[str, Any]] = []
    shapes = list(standing)
    for _ in range(_number(rng, APPEARING)):
        shapes.append(_obstacle(rng, _place(rng)))
        events.append({"at": _time(rng, 3.0, 20.0), "add": shape_to_mapping(shapes[-1])})
    for _ in range(_number(rng, MOVING)):
        if rng.random() < 0.5:
            index = int(rng.integers(len(standing)))
            shape = shapes[index]
            if shape is not standing[index] or isinstance(shape, Polygon):
                continue  # it moves already
        else:
            edge = 0.0 if rng.random() < 0.5 else SIZE[1]
            shape = _obstacle(rng, (float(rng.uniform(*BAND)), edge))
            index = len(shapes)
            shapes.append(shape)
        to = _target(rng, shape.center)
        shapes[index] = shape.moved((to[0] - shape.center[0], to[1] - shape.center[1]))
        move = {**shape_to_mapping(shape), "to": list(to), "speed": _round(rng.uniform(*SPEED))}
        events.append({"at": _time(rng, 2.0, 18.0), "move": move})
    said, formation = _SHAPES[int(rng.integers(len(_SHAPES)))]
    events.append({"at": _time(rng, 5.0, 25.0), "formation": said})
    events.append({"at": _time(rng, 5.0, 25.0), "lose": int(rng.integers(ROBOTS))})
    yaw = float(rng.uniform(-math.pi, math.pi))
    goal = (float(rng.uniform(1.5, SIZE[0] - 1.5)), float(rng.uniform(1.5, SIZE[1] - 1.5)), yaw)
    events.append({"at": _time(rng, 8.0, 25.0), "goals": [[_round(value) for value in goal]]})
    if len({event["at"] for event in events}) < len(events):
        return None  # the checker tells obstacles that appear by their time
    if not passable(shapes, slots(START), slots(goal, formation)):
        return None
    return sorted(events, key=lambda event: event["at"])


def _obstacle(rng: np.random.Generator, center: tuple[float, float]) -> Box | Circle:
    center = (_round(center[0]), _round(center[1]))
    if rng.random() < 0.5:
        return Circle(center, _round(rng.uniform(0.10, 0.35)))
    size = (_round(rng.uniform(0.2, 1.4)), _round(rng.uniform(0.2, 0.6)))
    return Box(center, size, _round(rng.uniform(0.0, math.pi)))


def _place(rng: np.random.Generator) -> tuple[float, float]:
    return float(rng.uniform(*BAND)), float(rng.uniform(0.0, SIZE[1]))


def _target(rng: np.random.Generator, start: tuple[float, float]) -> tuple[float, float]:
    """Where something that starts there may move to."""
    while True:
        place = _place(rng)
        if WAY[0] <= math.dist(place, start) <= WAY[1]:
            return _round(place[0]), _round(place[1])


def _number(rng: np.random.Generator, bounds: tuple[int, int]) -> int:
    return int(rng.integers(bounds[0], bounds[1] + 1))


def _time(rng: np.random.Generator, first: float, last: float) -> float:
    return round(float(rng.uniform(first, last)), 1)


def _round(value: float) -> float:
    return round(float(value), 4)


def measure(trial: Trial, done: Finished) -> dict[str, Any]:
    """Whether the team arrived, and which collisions it could have avoided."""
    collisions = audit(done)
    avoidable = [collision for collision in collisions if collision.avoidable]
    lost = {event.lose for event in done.scenario.execution.events if event.lose is not None}
    errors = [e for k, e in enumerate(done.summary["goal_error_m"]) if k not in lost]
    there = all(error is not None and error <= ARRIVED for error in errors)
    # A collision takes the place of `arrived` as the reason, but the team drives on.
    ended = done.summary["reason"] == "collision" and done.summary["sim_time_s"] < TIMEOUT
    arrived = done.summary["reason"] == "arrived" or (ended and there)
    return {
        "arrived": arrived,
        "way_open": None if arrived else _way_open(done),
        "avoidable": len(avoidable),
        "unavoidable": len(collisions) - len(avoidable),
        "why": "; ".join(collision.why for collision in collisions) or None,
        "moved_m": done.summary["goal_moved_m"],
    }


def _way_open(done: Finished) -> bool:
    """Whether, at the end, every robot could have gone to every place of the shape.

    The other robots that drive are left out; those that are lost stand where they are.
    """
    recording, scenario = done.recording, done.scenario
    status, poses = recording.status[-1], recording.poses[-1]
    if status.goal is None:
        return False
    there = (span.obstacle_at(float(recording.time[-1])) for span in obstacle_spans(scenario))
    shapes = [shape_from_mapping(obstacle.words) for obstacle in there if obstacle is not None]
    for pose, model, role in zip(poses, scenario.models, status.roles, strict=True):
        if role < 0:
            shapes.append(Box(tuple(pose[:2]), (model.length, model.width), float(pose[2])))
    goals = transform_points(status.goal, status.slots)
    return passable(shapes, poses[status.roles >= 0, :2], goals, SQUEEZE)


def bars(outcomes: Sequence[Outcome]) -> list[Bar]:
    """No collision that could have been avoided, and nearly all arrive."""
    total = len(outcomes)
    avoidable = [o.trial.name for o in outcomes if o.figures.get("avoidable")]
    other = [o.trial.name for o in outcomes if len(o.violations) > o.contacts]
    untyped = [o.trial.name for o in outcomes if o.reason in ("crashed", "refused")]
    arrived = sum(bool(outcome.figures.get("arrived")) for outcome in outcomes)
    return [
        none_of("worlds with a collision that could have been avoided: none", avoidable, total),
        none_of("worlds with any other violation: none", other, total),
        proportion("worlds where the team arrives", arrived, total, 0.95),
        none_of("failures without a type: none", untyped, total),
    ]


def describe(outcomes: Sequence[Outcome]) -> list[str]:
    """How they ended."""
    unavoidable = [o.trial.name for o in outcomes if o.figures.get("unavoidable")]
    late = [o.trial.name for o in outcomes if not o.figures.get("arrived")]
    closed = [o.trial.name for o in outcomes if o.figures.get("way_open") is False]
    done = [outcome for outcome in outcomes if outcome.summary]
    return [
        reasons(outcomes),
        f"  did not arrive: {', '.join(late) or 'none'}",
        f"  of these, no way was left at the end: {', '.join(closed) or 'none'}",
        f"  with a collision that nothing could have avoided: {', '.join(unavoidable) or 'none'}",
        distribution("sim_time_s", [outcome.time for outcome in done]),
        distribution("goal moved, m", [outcome.figures["moved_m"] for outcome in done]),
    ]
