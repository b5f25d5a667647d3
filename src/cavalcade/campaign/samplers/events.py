"""Clutter in which things happen on the way.

In every world obstacles appear, one or two move across (some of them out of the clutter), the
goal and the shape change and a robot is lost, all at random times and places. What appears may
appear next to a robot, or in it: `cavalcade.campaign.avoidable` says what could be avoided. The
worlds are such that the last goal can be reached when all obstacles are at their last places.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import (
    Counts,
    DataFolder,
    Instance,
    Lengths,
    Sampler,
    open_world,
    rounded,
    sample_count,
)
from cavalcade.campaign.samplers.teams import TeamSection, fits
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Positive
from cavalcade.world import (
    Box,
    Circle,
    OccupancyMap,
    Polygon,
    Shape,
    generate,
    shape_to_mapping,
)

SIZE = (14.0, 10.0)
START, GOAL = (1.4, 5.0, 0.0), (12.6, 5.0, 0.0)
BAND = (2.8, 11.2)
"""Where obstacles stand, appear and move to: x, m."""

WAY = (3.0, 8.0)
"""How far what moves goes, m."""

_TAG = 2
_ATTEMPTS = 1000
_TEAM = TeamSection(shape="square", side=1.0)
_SHAPES = (
    TeamSection(shape="square", side=1.2),
    TeamSection(shape="column", spacing=0.9, robots=4),
    TeamSection(shape="line", spacing=0.9, robots=4),
    TeamSection(shape="wedge", spacing=1.0, robots=4),
    TeamSection(shape="circle", radius=0.8, robots=4),
)


class EventsSampler(Sampler):
    """Four robots in a square cross 14 x 10 m of clutter with events.

    `obstacles` stand from the start, `appearing` ones come on the way and `moving` ones go at
    `speed` m/s.
    """

    sampler: Literal["events"]
    obstacles: Counts = (15, 25)
    appearing: Counts = (1, 3)
    moving: Counts = (1, 2)
    speed: Lengths = (0.10, 0.50)
    timeout: Positive = 240.0

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        for _ in range(_ATTEMPTS):
            count = sample_count(rng, self.obstacles)
            number = int(rng.integers(2**31))
            instance = generate("clutter", SIZE, number, obstacles=count, require_feasible=False)
            ground = _ground(instance.shapes)
            if not fits(ground, START, _TEAM.places()):
                continue
            if not _TEAM.gets_across(ground, START, GOAL):
                continue
            events = self._events(rng, instance.shapes)
            if events is not None:
                world = open_world(SIZE, instance.shapes)
                scenario = _TEAM.scenario(f"events-{seed}", world, START, GOAL, self.timeout, seed)
                scenario["execution"]["events"] = events
                return Instance(scenario, True)
        raise InputError("they leave hardly ever a way", key="obstacles")

    def _events(
        self, rng: np.random.Generator, standing: Sequence[Shape]
    ) -> list[dict[str, Any]] | None:
        """Events in order of time; None if the last goal could not be reached after them."""
        events: list[dict[str, Any]] = []
        shapes = list(standing)
        for _ in range(sample_count(rng, self.appearing)):
            shapes.append(_obstacle(rng, _place(rng)))
            events.append({"at": _time(rng, 3.0, 20.0), "add": shape_to_mapping(shapes[-1])})
        for _ in range(sample_count(rng, self.moving)):
            move = self._move(rng, standing, shapes)
            if move is not None:
                events.append({"at": _time(rng, 2.0, 18.0), "move": move})
        changed = _SHAPES[int(rng.integers(len(_SHAPES)))]
        events.append({"at": _time(rng, 5.0, 25.0), "formation": changed.formation})
        events.append({"at": _time(rng, 5.0, 25.0), "lose": int(rng.integers(_TEAM.robots))})
        yaw = rng.uniform(-math.pi, math.pi)
        x, y = (rng.uniform(1.5, side - 1.5) for side in SIZE)
        goal = rounded((x, y, yaw))
        events.append({"at": _time(rng, 8.0, 25.0), "goals": [list(goal)]})
        if len({event["at"] for event in events}) < len(events):
            return None  # the checker tells obstacles that appear by their time
        if not _ground(shapes).connect(_TEAM.places(START), changed.places(goal)):
            return None
        return sorted(events, key=lambda event: float(event["at"]))

    def _move(
        self, rng: np.random.Generator, standing: Sequence[Shape], shapes: list[Shape]
    ) -> dict[str, Any] | None:
        """One that stands or one from the edge sets out; `shapes` gets it at its last place.

        None if what is drawn moves already or is no body that moves.
        """
        if standing and rng.random() < 0.5:
            index = int(rng.integers(len(standing)))
            shape = shapes[index]
            if shape is not standing[index] or isinstance(shape, Polygon):
                return None
        else:
            edge = 0.0 if rng.random() < 0.5 else SIZE[1]
            shape = _obstacle(rng, (float(rng.uniform(*BAND)), edge))
            index = len(shapes)
            shapes.append(shape)
        to = _target(rng, shape.center)
        shapes[index] = shape.moved((to[0] - shape.center[0], to[1] - shape.center[1]))
        speed = _round(rng.uniform(*self.speed))
        return {**shape_to_mapping(shape), "to": list(to), "speed": speed}


def _ground(shapes: Sequence[Shape]) -> DiscRegions:
    return DiscRegions(OccupancyMap.empty(SIZE), shapes)


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


def _time(rng: np.random.Generator, first: float, last: float) -> float:
    return round(float(rng.uniform(first, last)), 1)


def _round(value: float) -> float:
    return round(float(value), 4)
