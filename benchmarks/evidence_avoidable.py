"""Whether a collision could have been avoided by standing still or by stepping aside in time.

Contact with what stands, with the border and with another robot always could. Otherwise:

* A robot that is lost cannot move.
* An obstacle that appears in a robot, or nearer than the robot can brake, could not be avoided
  if the robot touches it within `WARNING` seconds.
* An obstacle that moves could be avoided if, from its pose `WARNING` seconds before the contact
  (or when the obstacle appeared, if that is later), the robot could have stood still, or gone
  straight in one of 16 directions at its top speed (0.5 m/s forward, 0.2 m/s sideways, the
  ellipse between) for some time and then stood, without touching anything until the obstacle is
  where it stops, or for `AFTERWARDS` seconds. The others are taken to move as they did.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from evidence_trials import CONTACT, Finished

from cavalcade.checking.report import Violation
from cavalcade.geometry import Array, transform_points
from cavalcade.robots import RobotModel
from cavalcade.scenario import ObstacleSpan, obstacle_spans
from cavalcade.world import Box, Shape, shape_from_mapping
from cavalcade.world.shapes import distance_to_shapes

WARNING = 3.0
"""s"""

AFTERWARDS = 8.0
"""How long after the contact the obstacle is followed at most, s."""

REACTION = 0.25
"""A robot that evades is at its speed after this, s: half of the time it takes to reach it."""

LATENCY = 0.10
"""Until a robot begins to brake for what appears, s: two cycles."""

_STEP = 0.1
_DIRECTIONS = 16
_SPACING = 0.05
_TOUCH = 0.02
"""Footprints are judged at points `_SPACING` apart: what is closer than this counts as touched."""


@dataclass(frozen=True)
class Collision:
    """A contact with its verdict.

    Attributes:
        violation: The checker's.
        avoidable: Whether it could have been avoided.
        why: In a few words.
    """

    violation: Violation
    avoidable: bool
    why: str


def audit(done: Finished) -> list[Collision]:
    """The verdict on every contact that the checker found."""
    scene = _Scene(done)
    return [
        Collision(violation, *scene.verdict(violation))
        for violation in done.report.violations
        if violation.kind in CONTACT
    ]


class _Scene:
    def __init__(self, done: Finished) -> None:
        self._time = done.recording.time
        self._poses = done.recording.poses
        self._models = done.scenario.models
        self._size = done.world.base.size
        spans = obstacle_spans(done.scenario)
        self._shapes = [shape_from_mapping(span.obstacle.words) for span in spans]
        self._spans = spans
        fixed = len(done.scenario.world.obstacles)
        self._keys = [
            f"world.obstacles[{k}]" if k < fixed else f"event at {span.start:g} s"
            for k, span in enumerate(spans)
        ]
        events = done.scenario.execution.events
        self._lost = {event.lose: event.at for event in events if event.lose is not None}

    def verdict(self, contact: Violation) -> tuple[bool, str]:
        if contact.kind != "robot-obstacle":
            return True, contact.kind
        robot = contact.robots[0]
        if self._lost.get(robot, np.inf) <= contact.time:
            return False, "a lost robot was hit"
        index = self._keys.index(contact.obstacle)
        span = self._spans[index]
        if span.start > 0.0 and contact.time <= span.start + WARNING and self._sudden(robot, index):
            return False, "it appeared within the braking distance"
        if not any(span.velocity_at(contact.time - 1e-6)):
            return True, "it stood"
        begin = max(contact.time - WARNING, span.start, 0.0)
        end = min(max(span.time[-1], contact.time), contact.time + AFTERWARDS)
        way = self._escape(robot, begin, end)
        return (True, way) if way else (False, "no way out of the path of a moving obstacle")

    def _sudden(self, robot: int, index: int) -> bool:
        """Whether the obstacle appeared too near for the robot to stop."""
        model, start = self._models[robot], self._spans[index].start
        k = self._cycle(start)
        before = max(k - 1, 0)
        step = self._poses[k, robot, :2] - self._poses[before, robot, :2]
        speed = float(np.hypot(*step)) / max(self._time[k] - self._time[before], 1e-9)
        braking = speed * LATENCY + speed**2 / (2.0 * model.max_acceleration)
        body = transform_points(self._poses[k, robot], _footprint(model))
        gap = float(self._shapes[index].distance(body).min())
        return gap <= braking + _TOUCH

    def _escape(self, robot: int, begin: float, end: float) -> str:
        """How the robot could have got out of the way; empty if it could not."""
        model = self._models[robot]
        pose = self._poses[self._cycle(begin), robot]
        times = np.arange(begin, end + _STEP, _STEP)
        if self._free(robot, np.tile(pose, (len(times), 1)), times):
            return "it could have stood still"
        durations = np.arange(0.5, end - begin + 0.25, 0.5)
        directions = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        for duration, direction in product(durations, directions):
            speed = _top_speed(model, float(direction))
            heading = pose[2] + direction
            gone = speed * np.clip(times - begin - REACTION, 0.0, duration)
            poses = np.tile(pose, (len(times), 1))
            poses[:, :2] += gone[:, None] * (np.cos(heading), np.sin(heading))
            if self._free(robot, poses, times):
                degrees = np.degrees((direction + np.pi) % (2.0 * np.pi) - np.pi)
                return f"it could have gone aside ({degrees:.0f} degrees for {duration:.1f} s)"
        return ""

    def _free(self, robot: int, poses: Array, times: Array) -> bool:
        """Whether the robot would touch nothing at these poses `(T, 3)` and times `(T,)`."""
        points = np.stack([transform_points(p, _footprint(self._models[robot])) for p in poses])
        if points.min() < 0.0 or (points > self._size).any():
            return False
        for span, shape in zip(self._spans, self._shapes, strict=True):
            if not _apart(span, shape, points, times):
                return False
        for k, moment in enumerate(times):
            others = [
                Box(tuple(pose[:2]), (model.length, model.width), float(pose[2]))
                for other, (pose, model) in enumerate(
                    zip(self._poses[self._cycle(moment)], self._models, strict=True)
                )
                if other != robot
            ]
            if (distance_to_shapes(others, points[k]) < _TOUCH).any():
                return False
        return True

    def _cycle(self, time: float) -> int:
        last = len(self._time) - 1
        return min(int(np.searchsorted(self._time, time - 1e-6)), last)


def _apart(span: ObstacleSpan, shape: Shape, points: Array, times: Array) -> bool:
    """Whether footprints `(T, P, 2)` keep off an obstacle wherever it is at each time."""
    there = (times >= span.start) & (times < span.end)
    if not there.any():
        return True
    offsets = np.array([span.offset_at(float(time)) for time in times[there]])
    seen = (points[there] - offsets[:, None]).reshape(-1, 2)
    return bool((shape.distance(seen) >= _TOUCH).all())


def _footprint(model: RobotModel) -> Array:
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
