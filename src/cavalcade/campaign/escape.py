"""Whether a robot had somewhere to go: what it could have done instead of what it did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array, transform_points
from cavalcade.recording.frames import Recording
from cavalcade.robots import RobotModel
from cavalcade.scenario import ObstacleSpan, Scenario, World
from cavalcade.world import Box, Shape, shape_from_mapping
from cavalcade.world.shapes import distance_to_shapes

REACTION = 0.25
"""A robot that evades is at its speed after this, s: half of the time it takes to reach it."""

TOUCH = 0.02
"""Footprints are judged at points `_SPACING` apart: what is closer than this counts as touched."""

_STEP = 0.1
_DIRECTIONS = 16
_SPACING = 0.05
_FINE = 0.002
_SMALL = 1e-6


@dataclass(frozen=True)
class Thing:
    """An obstacle over time, as the checker calls it; `shape` is in the map frame, at first."""

    name: str
    span: ObstacleSpan
    shape: Shape

    def gaps(self, points: Array, times: Array) -> Array:
        """Distance `(T,)` in m of footprints `(T, P, 2)`; inf while it is not there."""
        gaps = np.full(len(times), np.inf)
        there = (times >= self.span.start) & (times < self.span.end)
        if there.any():
            offsets = np.array([self.span.offset_at(float(time)) for time in times[there]])
            seen = points[there] - offsets[:, None]
            gaps[there] = self.shape.distance(seen.reshape(-1, 2)).reshape(seen.shape[:2]).min(1)
        return gaps


class Scene:
    """What stood and moved where in a run.

    Attributes:
        things: The obstacles.
        models: Of the robots.
        time: `(T,)` of the cycles, s.
        poses: `(T, N, 3)` true ones, m and rad.
    """

    def __init__(self, scenario: Scenario, world: World, recording: Recording) -> None:
        self._base = world.base
        self.models = scenario.models
        self.time, self.poses = recording.time, recording.poses
        fixed = len(world.shapes)
        self.things = [
            Thing(
                f"world.obstacles[{k}]" if k < fixed else f"event at {span.start:g} s",
                span,
                shape_from_mapping(span.obstacle.to_dict()),
            )
            for k, span in enumerate(world.spans)
        ]

    def cycle(self, time: float) -> int:
        """The first cycle that is not before `time` s."""
        return min(int(np.searchsorted(self.time, time - 1e-6)), len(self.time) - 1)

    def escape(self, robot: int, begin: float, end: float) -> str:
        """How the robot could have got out of the way; empty if it could not."""
        model = self.models[robot]
        pose = self.poses[self.cycle(begin), robot]
        times = np.arange(begin, end + _STEP, _STEP)
        reach = model.max_speed_x * (end - begin) + model.length
        here = self._points(robot, pose[None])
        near = [
            (thing, _room(float(thing.gaps(here, times[:1])[0])))
            for thing in self.things
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

    def apart(self, robot: int, poses: Array, times: Array, thing: Thing) -> bool:
        """Whether the robot would keep off it at these poses `(T, 3)` and times `(T,)`."""
        return bool((thing.gaps(self._points(robot, poses), times) >= TOUCH).all())

    def touching(
        self, robot: int, thing: Thing, cycles: NDArray[np.bool_], gap: float
    ) -> list[bool]:
        """Whether the robot was within `gap` m of it, for each of the cycles chosen `(F,)`."""
        footprint = _outline(self.models[robot])
        return [
            # The points miss a corner between them by half of their spacing at most.
            bool(thing.gaps(transform_points(pose, footprint)[None], time)[0] <= gap + _FINE / 2.0)
            for pose, time in zip(self.poses[cycles, robot], self.time[cycles, None], strict=True)
        ]

    def _points(self, robot: int, poses: Array) -> Array:
        footprint = _footprint(self.models[robot])
        return np.stack([transform_points(pose, footprint) for pose in poses])

    def _free(
        self, robot: int, poses: Array, times: Array, things: Sequence[tuple[Thing, float]]
    ) -> bool:
        """Whether the robot would touch nothing at these poses `(T, 3)` and times `(T,)`.

        `things` come with the room that is to be kept to each, m.
        """
        points = self._points(robot, poses)
        if not self._on_free_ground(points.reshape(-1, 2)):
            return False
        if any((thing.gaps(points, times) < room).any() for thing, room in things):
            return False
        room = TOUCH
        for k, moment in enumerate(times):
            others = [
                Box((float(x), float(y)), (model.length, model.width), float(yaw))
                for other, ((x, y, yaw), model) in enumerate(
                    zip(self.poses[self.cycle(moment)], self.models, strict=True)
                )
                if other != robot
            ]
            gap = float(distance_to_shapes(others, points[k]).min())
            if k == 0:
                room = _room(gap)
            if gap < room:
                return False
        return True

    def _on_free_ground(self, points: Array) -> bool:
        """Whether all points `(N, 2)` lie on cells of the map that are free."""
        if not self._base.contains(points).all():
            return False
        last = np.array(self._base.occupied.shape) - 1
        rows, cols = np.clip(self._base.cell_of(points), 0, last).T
        return not bool(self._base.occupied[rows, cols].any())


def _room(first: float) -> float:
    """How far to keep off a thing, m: no farther than the robot is at first, yet off it."""
    return max(min(TOUCH, first - _SMALL), _SMALL)


def _footprint(model: RobotModel) -> Array:
    """Points `(P, 2)` all over the footprint in the body frame, its outline included."""
    sides = []
    for length in (model.length, model.width):
        count = int(np.ceil(length / _SPACING)) + 1
        sides.append(np.linspace(-length / 2.0, length / 2.0, count))
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


def _outline(model: RobotModel) -> Array:
    """The same, with its outline much finer."""
    half = np.array([model.length, model.width]) / 2.0
    sides = [np.linspace(-h, h, int(np.ceil(2.0 * h / _FINE)) + 1) for h in half]
    parts = [_footprint(model)]
    for sign in (-1.0, 1.0):
        parts.append(np.column_stack((sides[0], np.full(len(sides[0]), sign * half[1]))))
        parts.append(np.column_stack((np.full(len(sides[1]), sign * half[0]), sides[1])))
    return np.concatenate(parts)


def _top_speed(model: RobotModel, direction: float) -> float:
    """The velocity ellipse's reach in a direction of the body frame, m/s."""
    along, across = np.cos(direction) / model.max_speed_x, np.sin(direction) / model.max_speed_y
    return float(1.0 / np.hypot(along, across))
