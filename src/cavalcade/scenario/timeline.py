"""What a scenario's events make of its obstacles: which is where, and when.

One reading of `add`, `remove` and `move` for all who need it. `remove` and `move` mean the
obstacle that now stands exactly where their shape says or, failing that, the one that was first
written so. A `move` that matches none lets the obstacle appear; a `remove` must match.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cavalcade.errors import ScenarioError
from cavalcade.scenario.ground import Obstacle
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.settings import Move

_SAME = 1e-6
"""Shapes whose figures differ by less (m, rad) are the same."""

Offset = tuple[float, float]


@dataclass(frozen=True)
class ObstacleSpan:
    """One obstacle from its appearance to its end.

    Attributes:
        obstacle: Its shape at its first place, map frame.
        start, end: Seconds between which it is there; 0.0 and inf for one that always is.
        time: `(K,)` s, not falling, and
        offset: `(K, 2)` m: its displacement from its first place at these times; linear between
            them, constant before the first and after the last.
    """

    obstacle: Obstacle
    start: float = 0.0
    end: float = math.inf
    time: tuple[float, ...] = (0.0,)
    offset: tuple[Offset, ...] = ((0.0, 0.0),)

    @property
    def fixed(self) -> bool:
        """It is there from the start to the end and never moves."""
        return self.start == 0.0 and self.end == math.inf and len(self.time) == 1

    def offset_at(self, time: float) -> Offset:
        """Displacement (x, y) in m at `time` s."""
        if time <= self.time[0]:
            return self.offset[0]
        for k in range(1, len(self.time)):
            if time < self.time[k]:
                part = (time - self.time[k - 1]) / (self.time[k] - self.time[k - 1])
                (x0, y0), (x1, y1) = self.offset[k - 1], self.offset[k]
                return x0 + part * (x1 - x0), y0 + part * (y1 - y0)
        return self.offset[-1]

    def velocity_at(self, time: float) -> Offset:
        """Velocity (x, y) in m/s at `time` s; that of the motion that begins at a knot."""
        for k in range(1, len(self.time)):
            if self.time[k - 1] <= time < self.time[k]:
                dt = self.time[k] - self.time[k - 1]
                (x0, y0), (x1, y1) = self.offset[k - 1], self.offset[k]
                return (x1 - x0) / dt, (y1 - y0) / dt
        return 0.0, 0.0

    def obstacle_at(self, time: float) -> Obstacle | None:
        """The obstacle at its place at `time` s, None while it is not there."""
        if not self.start <= time < self.end:
            return None
        return self.obstacle.moved(self.offset_at(time))


_EARLIEST = 1e-9
"""s; an obstacle that an event brings at 0 s comes after those of the world, which are fixed."""


def obstacle_spans(scenario: Scenario) -> tuple[ObstacleSpan, ...]:
    """Every obstacle of the scenario over time: first `world.obstacles`, then what events add.

    Args:
        scenario: Best a resolved one, whose world lists all its obstacles.

    Raises:
        ScenarioError: An event removes an obstacle that is not there.
    """
    spans = [ObstacleSpan(obstacle) for obstacle in scenario.world.obstacles]
    for index, event in enumerate(scenario.execution.events):
        start = max(event.at, _EARLIEST)
        if event.add is not None:
            spans.append(ObstacleSpan(event.add, start, time=(start,)))
        elif event.remove is not None:
            found = _find(spans, event.remove, event.at)
            if found is None:
                raise ScenarioError(
                    f"no such obstacle at {event.at:g} s; expected the shape as it was added",
                    file=scenario.file,
                    key=f"execution.events[{index}].remove",
                )
            spans[found] = replace(spans[found], end=event.at)
        elif event.move is not None:
            found = _find(spans, event.move.obstacle, event.at)
            if found is None:
                found = len(spans)
                spans.append(ObstacleSpan(event.move.obstacle, start, time=(event.at,)))
            spans[found] = _moving(spans[found], event.at, event.move)
    return tuple(spans)


def _moving(span: ObstacleSpan, at: float, move: Move) -> ObstacleSpan:
    """The span of an obstacle that is told at `at` s where to go; what it was told before ends."""
    here = span.offset_at(at)
    cx, cy = span.obstacle.center
    there = (move.to[0] - cx, move.to[1] - cy)
    arrival = at + math.dist(here, there) / move.speed
    before = sum(time < at for time in span.time)
    times, offsets = (*span.time[:before], at), (*span.offset[:before], here)
    if arrival > at:
        times, offsets = (*times, arrival), (*offsets, there)
    return replace(span, time=times, offset=offsets)


def _find(spans: list[ObstacleSpan], shape: Obstacle, time: float) -> int | None:
    alive = [k for k, span in enumerate(spans) if span.start <= time < span.end]
    for k in alive:
        if _same(spans[k].obstacle.moved(spans[k].offset_at(time)), shape):
            return k
    return next((k for k in alive if _same(spans[k].obstacle, shape)), None)


def _same(one: Obstacle, other: Obstacle) -> bool:
    """Whether two shapes are of one kind and have the same figures."""
    if one.kind != other.kind:
        return False
    a, b = _figures(one), _figures(other)
    return len(a) == len(b) and all(abs(x - y) <= _SAME for x, y in zip(a, b, strict=True))


def _figures(obstacle: Obstacle) -> list[float]:
    if obstacle.box is not None:
        return [*obstacle.box.center, *obstacle.box.size, obstacle.box.yaw]
    if obstacle.circle is not None:
        return [*obstacle.circle.center, obstacle.circle.radius]
    return [value for point in obstacle.value.points for value in point]
