"""What the page needs to know of a run in physics, small: 16-bit columns as base 64."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing.physics.signals import descriptions_of
from cavalcade.drawing.replay.packing import packed, ranged, rounded, steps
from cavalcade.geometry import GRAVITY, Array
from cavalcade.recording.physics_track import ContactEvent, PhysicsTrack
from cavalcade.robots.description import QuadrupedDescription

if TYPE_CHECKING:
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario

_MOST_SAMPLES = 60_000
"""Of all robots together; more are thinned out. They take 84 bytes each in the page."""

_SAME = 0.5
"""Contacts of the same kind that follow within this time are told once, s."""

ANGLE = 2e-4
"""Unit of joint angles in the page, rad."""

FORCE = 0.1
"""Unit of forces in the page, N."""


def track_data(
    scenario: Scenario,
    track: PhysicsTrack,
    recording: Recording | None,
    robots: list[dict[str, Any]],
) -> dict[str, Any]:
    """Samples, mechanisms and events of a track; puts columns to each of the page's robots.

    The recording, if there is one, tells what they were commanded, on the track's clock.
    """
    descriptions = descriptions_of(scenario, track)
    shown = track.thinned(-(-len(track.time) * track.size // _MOST_SAMPLES))
    for k, (robot, description) in enumerate(zip(robots, descriptions, strict=True)):
        robot["body"] = description.name
        robot["track"] = _columns(shown, k, description)
    data: dict[str, Any] = {
        "time": steps(shown.time, 1000),
        "bodies": {one.name: _body(one) for one in descriptions},
        "contacts": [
            [round(event.time, 3), event.robot, event.part, event.other]
            for event in merged_contacts(track.contacts)
        ],
        "falls": [[round(event.time, 3), event.robot] for event in track.falls],
    }
    if recording is not None:
        speed = np.linalg.norm(np.asarray(recording.commands)[..., :2], axis=2)
        data["commands"] = {
            "time": steps(recording.time, 1000),
            "speed": [steps(speed[:, k], 100) for k in range(track.size)],
        }
    return data


def merged_contacts(contacts: tuple[ContactEvent, ...]) -> list[ContactEvent]:
    """The first of each series of contacts of the same robot, part and other."""
    last: dict[tuple[int, str, str], float] = {}
    found = []
    for event in sorted(contacts, key=lambda event: event.time):
        kind = (event.robot, event.part, event.other)
        if event.time - last.get(kind, -np.inf) > _SAME:
            found.append(event)
        last[kind] = event.time
    return found


def _body(description: QuadrupedDescription) -> dict[str, Any]:
    return {
        **skeleton_of(description),
        "weight": round(GRAVITY * description.mass, 2),
        "looks": [
            {
                "link": shape.link,
                "part": shape.part,
                "kind": shape.kind,
                "size": rounded(shape.size, 5),
                "at": rounded(shape.position, 5),
                "turn": rounded(shape.rotation, 5),
                "colour": rounded(shape.color, 3),
            }
            for shape in description.looks
        ],
    }


def skeleton_of(description: QuadrupedDescription) -> dict[str, Any]:
    """Links and feet as plain numbers: what a page needs to know of the mechanism.

    `links[k]` is moved by joint `k` and is link `k + 1`: its `parent` link, the joint's `offset`
    in the parent's frame (m) and its `axis`. `feet` are the balls' centres in their calves' frames.
    """
    links, feet = [], []
    for leg, said in enumerate(description.legs):
        for j, joint in enumerate(said.joints):
            parent, axis = 3 * leg + j if j else 0, [float(part) for part in joint.axis]
            links.append({"parent": parent, "offset": rounded(joint.offset, 7), "axis": axis})
        feet.append({"link": 3 * leg + 3, "offset": rounded(said.foot, 7)})
    return {"links": links, "feet": feet, "radius": description.foot_radius}


def _columns(track: PhysicsTrack, robot: int, description: QuadrupedDescription) -> dict[str, Any]:
    base = track.base[:, robot]
    share = np.abs(track.torques[:, robot]) / description.torque_limits
    return {
        "place": [ranged(base[:, axis]) for axis in range(3)],
        "turn": packed(np.rint(_continuous(base[:, 3:]) * 32_767).astype("<i2")),
        "joints": packed(_short(track.joints[:, robot] / ANGLE)),
        "forces": packed(_short(track.foot_forces[:, robot] / FORCE)),
        "load": packed(np.clip(np.rint(100.0 * share.max(axis=1)), 0, 255).astype("u1")),
    }


def _continuous(quaternions: Array) -> Array:
    """The same rotations, each with the sign that makes it the neighbour of the one before."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    sign = np.concatenate([[1.0], np.where(np.cumsum(flips) % 2, -1.0, 1.0)])
    signed: Array = quaternions * sign[:, None]
    return signed / np.linalg.norm(signed, axis=1, keepdims=True)


def _short(values: Array) -> Any:
    return np.clip(np.rint(values), -32_767, 32_767).astype("<i2")
