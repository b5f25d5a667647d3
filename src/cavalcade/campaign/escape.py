"""Whether a robot had somewhere to go: what it could have done instead of what it did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from cavalcade.geometry import Array, transform_points
from cavalcade.robots import RobotModel
from cavalcade.running.frames import Recording
from cavalcade.scenario import ObstacleSpan
from cavalcade.world import Box, OccupancyMap, Shape
from cavalcade.world.shapes import distance_to_shapes

REACTION = 0.25
"""A robot that evades is at its speed after this, s: half of the time it takes to reach it."""

TOUCH = 0.02
"""Footprints are judged at points `_SPACING` apart: what is closer than this counts as touched."""

_STEP = 0.1
_DIRECTIONS = 16
_SPACING = 0.05


@dataclass(frozen=True)
class Thing:
    """An obstacle over time.

    Attributes:
        name: As the checker calls it.
        span: When it is where.
        shape: At its first place, map frame, m.
    """

    name: str
    span: ObstacleSpan
    shape: Shape

    def apart(self, points: Array, times: Array) -> bool:
        """Whether footprints `(T, P, 2)` keep off it wherever it is at each time."""
        there = (times >= self.span.start) & (times < self.span.end)
        if not there.any():
            return True
        offsets = np.array([self.span.offset_at(float(time)) for time in times[there]])
        seen = (points[there] - offsets[:, None]).reshape(-1, 2)
        return bool((self.shape.distance(seen) >= TOUCH).all())


class Scene:
    """What stood and moved where in a run."""

    def __init__(
        self,
        base: OccupancyMap,
        things: Sequence[Thing],
        models: Sequence[RobotModel],
        recording: Recording,
    ) -> None:
        self._base = base
        self._things = things
        self._models = models
        self._time = recording.time
        self._poses = recording.poses

    def cycle(self, time: float) -> int:
        """The first cycle that is not before `time` s."""
        last = len(self._time) - 1
        return min(int(np.searchsorted(self._time, time - 1e-6)), last)

    def escape(self, robot: int, begin: float, end: float) -> str:
        """How the robot could have got out of the way; empty if it could not."""
        model = self._models[robot]
        pose = self._poses[self.cycle(begin), robot]
        times = np.arange(begin, end + _STEP, _STEP)
        reach = model.max_speed_x * (end - begin) + model.length
        near = [
            thing
            for thing in self._things
            if not thing.span.fixed or thing.shape.distance(pose[None, :2])[0] <= reach
        ]
        if self._free(robot, np.tile(pose, (len(times), 1)), times, near):
            return "it could have stood still"
        durations = np.arange(0.5, end - begin + 0.25, 0.5)
        directions = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        for duration, direction in product(durations, directions):
            heading = pose[2] + direction
            gone = _top_speed(model, float(direction)) * np.clip(
                times - begin - REACTION, 0.0, duration
            )
            poses = np.tile(pose, (len(times), 1))
            poses[:, :2] += gone[:, None] * (np.cos(heading), np.sin(heading))
            if self._free(robot, poses, times, near):
                degrees = np.degrees((direction + np.pi) % (2.0 * np.pi) - np.pi)
                return f"it could have gone aside ({degrees:.0f} degrees for {duration:.1f} s)"
        return ""

    def _free(self, robot: int, poses: Array, times: Array, things: Sequence[Thing]) -> bool:
        """Whether the robot would touch nothing at these poses `(T, 3)` and times `(T,)`."""
        footprint = footprint_points(self._models[robot])
        points = np.stack([transform_points(pose, footprint) for pose in poses])
        if not self._on_free_ground(points.reshape(-1, 2)):
            return False
        if not all(thing.apart(points, times) for thing in things):
            return False
        for k, moment in enumerate(times):
            now = self._poses[self.cycle(moment)]
            others = [
                body_at(now[other], model)
                for other, model in enumerate(self._models)
                if other != robot
            ]
            if (distance_to_shapes(others, points[k]) < TOUCH).any():
                return False
        return True

    def _on_free_ground(self, points: Array) -> bool:
        """Whether all points `(N, 2)` lie on cells of the map that are free."""
        if not self._base.contains(points).all():
            return False
        last = np.array(self._base.occupied.shape) - 1
        rows, cols = np.clip(self._base.cell_of(points), 0, last).T
        return not bool(self._base.occupied[rows, cols].any())


def body_at(pose: Array, model: RobotModel) -> Box:
    """A robot's footprint at a pose (x, y, yaw)."""
    return Box((float(pose[0]), float(pose[1])), (model.length, model.width), float(pose[2]))


def footprint_points(model: RobotModel) -> Array:
    """Points `(P, 2)` all over the footprint in the body frame, its outline included."""
    sides = []
    for length in (model.length, model.width):
        count = int(np.ceil(length / _SPACING)) + 1
        sides.append(np.linspace(-length / 2.0, length / 2.0, count))
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


def _top_speed(model: RobotModel, direction: float) -> float:
    """The velocity ellipse's reach in a direction of the body frame, m/s."""
    along, across = np.cos(direction) / model.max_speed_x, np.sin(direction) / model.max_speed_y
    return float(1.0 / np.hypot(along, across))
