"""Whether a collision could have been avoided by standing still or by stepping aside in time.

Contact with what stands, with the border and with another robot always could. Otherwise:

* A robot that is lost cannot get out of the way of what has moved or appeared since its loss.
* An obstacle that appears in a robot, or where the robot brakes to a stop straight ahead, could
  not be avoided if the robot touches it while it would brake, or `GRACE` seconds later.
* An obstacle that moves could be avoided if, from its pose `WARNING` seconds before the contact
  (or when the obstacle appeared, if that is later), the robot could have stood still, or gone
  straight in one of 16 directions at its top speed (0.5 m/s forward, 0.2 m/s sideways, the
  ellipse between) for some time and then stood, without touching anything until the obstacle is
  where it stops, or for `AFTERWARDS` seconds. The others are taken to move as they did.
* A contact that goes on after one that could not be avoided is the same: the robot was not away
  from that obstacle for `APART` seconds in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.campaign.escape import Scene, Thing
from cavalcade.checking.report import Report, Violation
from cavalcade.recording.frames import Recording
from cavalcade.scenario import Event, Scenario, World

CONTACT = ("robot-robot", "robot-obstacle", "robot-map", "flight-over-robot")
"""The checker's kinds of violation that are collisions."""

WARNING = 3.0
"""So long before a contact with what moves a robot has to give way, s."""

AFTERWARDS = 8.0
"""How long after the contact the obstacle is followed at most, s."""

LATENCY = 0.10
"""Until a robot begins to brake for what appears, s: two cycles."""

GRACE = 0.25
"""How long after a robot would have stopped it may touch what appeared in its way, s."""

APART = 1.0
"""So long without touch, and a contact is a new one, s."""

TOGETHER = 0.002
"""A robot is in touch up to this gap, m."""

_STEP = 0.02


@dataclass(frozen=True)
class Collision:
    """A contact that the checker found, whether it could have been avoided, and why."""

    violation: Violation
    avoidable: bool
    why: str


def contacts_of(report: Report) -> list[Violation]:
    """Those of the checker's violations that are collisions."""
    return [violation for violation in report.violations if violation.kind in CONTACT]


def audit(
    scenario: Scenario, world: World, recording: Recording, report: Report
) -> list[Collision]:
    """The verdict on every contact that the checker found, in order of time."""
    contacts = contacts_of(report)
    if not contacts:
        return []
    scene, events = Scene(scenario, world, recording), scenario.execution.events
    found: list[Collision] = []
    excused: dict[tuple[int, str], Collision] = {}
    for contact in contacts:
        key = contact.robots[0], contact.obstacle
        before = excused.get(key)
        if before is not None and _goes_on(scene, before.violation, contact):
            collision = Collision(contact, False, before.why)
        else:
            collision = Collision(contact, *_verdict(scene, events, contact))
        if contact.kind == "robot-obstacle" and not collision.avoidable:
            excused[key] = collision
        else:
            excused.pop(key, None)
        found.append(collision)
    return found


def _verdict(scene: Scene, events: Sequence[Event], contact: Violation) -> tuple[bool, str]:
    """Whether it could have been avoided, and why."""
    if contact.kind != "robot-obstacle":
        return True, contact.kind
    robot = contact.robots[0]
    thing = _thing(scene, contact)
    if thing is None:
        return True, contact.obstacle
    lost = lost_since(events, robot, contact.time)
    if lost is not None:
        # What stands may not be rolled into, by a robot that has lost its orders either.
        if _changed(thing, lost, contact.time):
            return False, "a lost robot was hit"
        return True, "a lost robot ran into what stood"
    start = thing.span.start
    if start > 0.0 and _sudden(scene, robot, thing, contact.time):
        return False, "it appeared within the braking distance"
    if not any(thing.span.velocity_at(contact.time - 1e-6)):
        return True, "it stood"
    begin = max(contact.time - WARNING, start, 0.0)
    end = min(max(thing.span.time[-1], contact.time), contact.time + AFTERWARDS)
    way = scene.escape(robot, begin, end)
    return (True, way) if way else (False, "no way out of the path of a moving obstacle")


def _goes_on(scene: Scene, before: Violation, now: Violation) -> bool:
    """Whether two contacts of a robot with the same obstacle are one, but for short gaps."""
    thing = _thing(scene, now)
    if thing is None:
        return False
    inside = (scene.time > before.time) & (scene.time < now.time)
    times = np.concatenate(([before.time], scene.time[inside], [now.time]))
    touching = [True, *scene.touching(now.robots[0], thing, inside, TOGETHER), True]
    return bool(np.diff(times[touching]).max() < APART)


def _thing(scene: Scene, contact: Violation) -> Thing | None:
    return next((thing for thing in scene.things if thing.name == contact.obstacle), None)


def lost_since(events: Sequence[Event], robot: int, time: float) -> float | None:
    """When it was lost, if it still is."""
    lost = None
    for event in events:
        if event.at <= time and robot in (event.lose, event.rejoin):
            lost = event.at if event.lose == robot else None
    return lost


def _sudden(scene: Scene, robot: int, thing: Thing, contact: float) -> bool:
    """Whether the obstacle appeared too near on its way for the robot to stop, and was hit."""
    k = scene.cycle(thing.span.start)
    before = max(k - 1, 0)
    moved = scene.poses[k, robot, :2] - scene.poses[before, robot, :2]
    velocity = moved / max(scene.time[k] - scene.time[before], 1e-9)
    braking = float(np.hypot(*velocity)) / scene.models[robot].max_acceleration
    stop = LATENCY + braking
    if contact > scene.time[k] + stop + GRACE:
        return False
    passed = np.arange(0.0, stop + _STEP, _STEP).clip(max=stop)
    slowing = (passed - LATENCY).clip(min=0.0)
    share = passed - slowing**2 / (2.0 * max(braking, 1e-9))
    poses = np.tile(scene.poses[k, robot], (len(passed), 1))
    poses[:, :2] += share[:, None] * velocity
    return not scene.apart(robot, poses, scene.time[k] + passed, thing)


def _changed(thing: Thing, since: float, until: float) -> bool:
    """Whether it appeared or was moved in that time."""
    span = thing.span
    return span.start > since or span.offset_at(since) != span.offset_at(until)
