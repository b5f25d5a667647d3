"""Whether starts and goals keep the clearance that planners ask of them, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from cavalcade.checking.contact import bodies, find_contacts
from cavalcade.checking.report import Violation
from cavalcade.checking.solids import Scene
from cavalcade.checking.sweep import TOUCH
from cavalcade.checking.tracks import Pose, Track
from cavalcade.geometry import CLEARANCE
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario

CONTACTS = ("robot-robot", "robot-obstacle", "robot-map", "flight-over-robot")


def check_places(
    scenario: Scenario, scene: Scene, solved: bool, found: Sequence[Violation]
) -> list[Violation]:
    """Starts, and goals that a summary claims were reached, with less than `CLEARANCE` around.

    Of who has touched what anyway, as `found` says, no more is said.
    """
    violations = _crowded("start", scenario.starts, scenario.models, scene)
    if solved and scenario.task.kind == "individual":
        violations += _crowded("arrival", scenario.goals, scenario.models, scene)
    said = {(one.robots, one.obstacle) for one in found if one.kind in CONTACTS}
    return [one for one in violations if (one.robots, one.obstacle) not in said]


def _crowded(
    kind: Literal["start", "arrival"],
    poses: tuple[Pose, ...],
    models: tuple[RobotModel, ...],
    scene: Scene,
) -> list[Violation]:
    """Robots that would stand too near to what is there at the beginning, or to each other."""
    ticks = np.zeros(2)
    tracks = tuple(Track(np.zeros(1), np.array([pose], dtype=float)) for pose in poses)
    team = bodies(tracks, models, ticks)
    _, gap = find_contacts(scene, team, ticks)
    missing = CLEARANCE - 2.0 * TOUCH
    if gap > missing + TOUCH:
        return []
    # Who and what: inflated footprints touch, robots by half the clearance each.
    alone = tuple(replace(body, skin=body.skin + missing) for body in team)
    halves = tuple(replace(body, skin=body.skin + missing / 2.0) for body in team)
    found = find_contacts(scene, alone, ticks, among=False)[0]
    found += [one for one in find_contacts(scene, halves, ticks)[0] if one.kind == "robot-robot"]
    place = "start" if kind == "start" else "goal"
    violations = []
    for contact in found:
        first, *others = contact.robots
        what = f"that of robot {others[0]}" if others else contact.obstacle
        text = f"the {place} of robot {first} is less than {1e3 * CLEARANCE:g} mm from {what}"
        violations.append(replace(contact, kind=kind, message=text, value=gap, limit=CLEARANCE))
    return violations
