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

import numpy as np

from cavalcade.campaign.escape import TOUCH, Scene, Thing, body_at, footprint_points
from cavalcade.campaign.judging import CONTACT
from cavalcade.checking.report import Report, Violation
from cavalcade.geometry import transform_points
from cavalcade.running.frames import Recording
from cavalcade.scenario import Scenario, World
from cavalcade.world import shape_from_mapping

WARNING = 3.0
"""s"""

AFTERWARDS = 8.0
"""How long after the contact the obstacle is followed at most, s."""

LATENCY = 0.10
"""Until a robot begins to brake for what appears, s: two cycles."""

SQUEEZE = 0.25
"""Radius of the disc that tells whether a team that did not arrive had a way left, m."""


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


def audit(
    scenario: Scenario, world: World, recording: Recording, report: Report
) -> list[Collision]:
    """The verdict on every contact that the checker found, in order of time.

    Args:
        scenario: The resolved one that was run.
        world: Its world.
        recording: What happened.
        report: The checker's.
    """
    contacts = [violation for violation in report.violations if violation.kind in CONTACT]
    court = _Court(scenario, world, recording) if contacts else None
    return [Collision(found, *court.verdict(found)) for found in contacts if court is not None]


def way_open(scenario: Scenario, world: World, recording: Recording) -> bool:
    """Whether, at the end, every robot could have gone to every place of the shape.

    For a disc of `SQUEEZE`. The other robots that drive are left out; those that are lost stand
    where they are. Without a goal there is no way.
    """
    from cavalcade.campaign.draws.feasibility import DiscRegions

    status, poses = recording.status[-1], recording.poses[-1]
    if status.goal is None:
        return False
    there = (span.obstacle_at(float(recording.time[-1])) for span in world.spans)
    shapes = [shape_from_mapping(obstacle.words) for obstacle in there if obstacle is not None]
    roles = np.asarray(status.roles)
    shapes += [body_at(poses[k], model) for k, model in enumerate(scenario.models) if roles[k] < 0]
    ground = DiscRegions(world.base, shapes, SQUEEZE)
    return ground.connect(poses[roles >= 0, :2], transform_points(status.goal, status.slots))


class _Court:
    """All that a verdict needs to know of a run."""

    def __init__(self, scenario: Scenario, world: World, recording: Recording) -> None:
        self._time = recording.time
        self._poses = recording.poses
        self._models = scenario.models
        fixed = len(world.shapes)
        self._things = [
            Thing(
                f"world.obstacles[{k}]" if k < fixed else f"event at {span.start:g} s",
                span,
                shape_from_mapping(span.obstacle.words),
            )
            for k, span in enumerate(world.spans)
        ]
        self._events = scenario.execution.events
        self._scene = Scene(world.base, self._things, scenario.models, recording)

    def verdict(self, contact: Violation) -> tuple[bool, str]:
        """Whether it could have been avoided, and why."""
        if contact.kind != "robot-obstacle":
            return True, contact.kind
        robot = contact.robots[0]
        if self._lost(robot, contact.time):
            return False, "a lost robot was hit"
        thing = next((thing for thing in self._things if thing.name == contact.obstacle), None)
        if thing is None:
            return True, contact.obstacle
        start = thing.span.start
        if start > 0.0 and contact.time <= start + WARNING and self._sudden(robot, thing):
            return False, "it appeared within the braking distance"
        if not any(thing.span.velocity_at(contact.time - 1e-6)):
            return True, "it stood"
        begin = max(contact.time - WARNING, start, 0.0)
        end = min(max(thing.span.time[-1], contact.time), contact.time + AFTERWARDS)
        way = self._scene.escape(robot, begin, end)
        return (True, way) if way else (False, "no way out of the path of a moving obstacle")

    def _lost(self, robot: int, time: float) -> bool:
        lost = False
        for event in self._events:
            if event.at <= time and robot in (event.lose, event.rejoin):
                lost = event.lose == robot
        return lost

    def _sudden(self, robot: int, thing: Thing) -> bool:
        """Whether the obstacle appeared too near for the robot to stop."""
        model = self._models[robot]
        k = self._scene.cycle(thing.span.start)
        before = max(k - 1, 0)
        step = self._poses[k, robot, :2] - self._poses[before, robot, :2]
        speed = float(np.hypot(*step)) / max(self._time[k] - self._time[before], 1e-9)
        braking = speed * LATENCY + speed**2 / (2.0 * model.max_acceleration)
        body = transform_points(self._poses[k, robot], footprint_points(model))
        return float(thing.shape.distance(body).min()) <= braking + TOUCH
