"""The verdict on robots in physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.checking.ground import Floor
from cavalcade.checking.physics.contacts import (
    check_upright,
    hidden_contacts,
    recorded_contacts,
    touched,
)
from cavalcade.checking.physics.feet import FRICTION, check_feet
from cavalcade.checking.physics.joints import check_joints
from cavalcade.checking.physics.kinematics import Posture, posture
from cavalcade.checking.physics.momentum import carried_part, check_momentum
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.touching import (
    ground_overlaps,
    obstacle_overlaps,
    robot_overlaps,
)
from cavalcade.checking.report import Violation
from cavalcade.checking.solids import Scene
from cavalcade.geometry import Array
from cavalcade.robots.description import QuadrupedDescription


@dataclass(frozen=True)
class Push:
    """A force from outside that is part of the experiment.

    Attributes:
        robot: Which.
        begin, end: s.
        force: On the trunk's centre, map frame, N.
    """

    robot: int
    begin: float
    end: float
    force: tuple[float, float, float]


@dataclass(frozen=True)
class Conditions:
    """What an experiment says of its robots.

    Attributes:
        friction: Largest coefficient between a foot and what it stands on.
        variation: Masses may be other ones by this part.
        pushes: Forces from outside.
    """

    friction: float = FRICTION
    variation: float = 0.0
    pushes: tuple[Push, ...] = ()


def judge_robots(
    records: Sequence[RobotRecord],
    descriptions: Sequence[QuadrupedDescription],
    floor: Floor,
    scene: Scene | None = None,
    conditions: Conditions | None = None,
) -> list[Violation]:
    """What is wrong with the recorded motion of robots: see `docs/explanation/checker.md`.

    Args:
        records: One per robot, on the same clock.
        descriptions: Of each of them.
        floor: What they walk on.
        scene: What they may run into.
        conditions: Of the experiment.

    Returns:
        In order of time.
    """
    conditions = conditions or Conditions()
    told = {one.robot: said for one, said in zip(records, descriptions, strict=True)}
    links = {one.robot: _links(one, told[one.robot], floor, conditions) for one in records}
    result: list[Violation] = []
    for record in records:
        robot, own, description = record.robot, links[record.robot], told[record.robot]
        overlaps = [*ground_overlaps(own, description, floor), *robot_overlaps(robot, links, told)]
        if scene is not None:
            overlaps += obstacle_overlaps(own, description, scene)
        result += hidden_contacts(record, overlaps)
        unknown, forces = touched(record), _pushed(record, conditions.pushes)
        result += check_upright(record, description, floor)
        result += recorded_contacts(record)
        result += check_joints(record, own, description, unknown)
        result += check_feet(record, own, floor, conditions.friction)
        result += check_momentum(record, own, forces, unknown)
    return sorted(result, key=lambda violation: violation.time)


def _links(
    record: RobotRecord,
    description: QuadrupedDescription,
    floor: Floor,
    conditions: Conditions,
) -> Posture:
    """The robot's links; if its mass may vary, with that which its feet carry, within reason."""
    links = posture(record, description, floor=floor)
    if conditions.variation <= 0.0:
        return links
    part = carried_part(record, links, _pushed(record, conditions.pushes), touched(record))
    least, most = 1.0 - conditions.variation, 1.0 + conditions.variation
    scale = np.clip(1.0 if part is None else part, least, most)
    return posture(record, description, float(scale), floor)


def _pushed(record: RobotRecord, pushes: Sequence[Push]) -> Array:
    """Mean forces `(T - 1, 3)` in N of the pushes on a robot in each interval."""
    result = np.zeros((len(record.time) - 1, 3))
    for push in pushes:
        if push.robot != record.robot:
            continue
        begin = np.maximum(record.time[:-1], push.begin)
        part = np.maximum(np.minimum(record.time[1:], push.end) - begin, 0.0) / record.steps
        result += part[:, None] * np.array(push.force)
    return result
