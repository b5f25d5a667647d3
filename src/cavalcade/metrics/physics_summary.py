"""The figures of bodies and contacts in a run's summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import Any

import numpy as np

from cavalcade.geometry import GRAVITY
from cavalcade.metrics.summary import (
    BodyContacts,
    GroundContacts,
    PhysicsSummary,
    rounded,
    rounded_each,
)
from cavalcade.recording.physics_track import ContactEvent, PhysicsTrack
from cavalcade.robots import RobotModel

TOGETHER = 0.1
"""Contacts of the same two with shorter breaks are one, s."""

_BODY = ("trunk", "hip", "thigh", "calf")


def summarise_physics(track: PhysicsTrack, models: Sequence[RobotModel]) -> PhysicsSummary:
    """What `physics` holds in `summary.json`.

    - `contacts`: how many began `robot_robot`, `robot_obstacle`, and with the ground by part, but
      for feet.
    - `max_torque_share`: the largest torque of a joint in shares of its limit.
    - `max_speed_share`: the largest rate of a joint in shares of its limit.
    - `max_tilt_rad`: the largest angle between a trunk's z axis and the vertical.
    - `min_height_m`, `max_height_m`: of trunks, in the map.
    - `carried_share`: mean force of the ground on each robot's feet over its nominal weight.
    """
    robots = [_description(model) for model in models]
    torque = np.array([robot.torque_limits for robot in robots])
    speed = np.array([robot.speed_limits for robot in robots])
    weights = np.array([robot.mass * GRAVITY for robot in robots])
    w_to_z = 1.0 - 2.0 * (track.base[..., 4] ** 2 + track.base[..., 5] ** 2)
    # The first sample has nothing before it.
    carried = track.foot_forces[1:, ..., 2].sum(axis=-1)
    heights = track.base[..., 2]
    shares = carried.mean(axis=0) / weights if len(carried) else [None] * track.size
    return PhysicsSummary(
        contacts=count_contacts(track.contacts),
        max_torque_share=rounded(np.abs(track.torques / torque).max(initial=0.0)),
        max_speed_share=rounded(np.abs(track.joint_rates / speed).max(initial=0.0)),
        max_tilt_rad=rounded(np.arccos(np.clip(w_to_z, -1.0, 1.0)).max(initial=0.0)),
        min_height_m=rounded(heights.min()) if len(track.time) else None,
        max_height_m=rounded(heights.max()) if len(track.time) else None,
        carried_share=rounded_each(shares),
    )


def count_contacts(contacts: Iterable[ContactEvent]) -> BodyContacts:
    """How many contacts began, of two robots, of a robot and an obstacle, and with the ground.

    A contact of two robots is recorded by both, and one that lasts again and again.
    """
    found: list[tuple[float, tuple[str, Hashable]]] = []
    for contact in contacts:
        if contact.other.startswith("robot "):
            pair = frozenset((contact.robot, int(contact.other.removeprefix("robot "))))
            found.append((contact.time, ("robot_robot", pair)))
        elif contact.other == "obstacle":
            found.append((contact.time, ("robot_obstacle", contact.robot)))
        elif contact.part in _BODY:
            found.append((contact.time, (contact.part, contact.robot)))
    last: dict[Hashable, float] = {}
    begun: Counter[str] = Counter()
    for time, what in sorted(found, key=lambda one: one[0]):
        if time > last.get(what, -np.inf) + TOGETHER:
            begun[what[0]] += 1
        last[what] = time
    return BodyContacts(
        begun["robot_robot"],
        begun["robot_obstacle"],
        GroundContacts(**{part: begun[part] for part in _BODY}),
    )


def _description(model: RobotModel) -> Any:
    if model.description is None:
        raise ValueError(f"{model.name} has no description")
    return model.description
