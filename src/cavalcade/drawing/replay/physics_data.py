"""What the page of a physics replay needs to know, small: 16-bit columns as base 64."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.physics.skeleton import skeleton_of
from cavalcade.drawing.replay.formation import numbers, outcome, planner_data
from cavalcade.drawing.replay.page3d.ground import ground_data, prism_data, prism_of
from cavalcade.drawing.replay.page3d.packing import packed, ranged, steps
from cavalcade.drawing.scene import arena_of, scene_of
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.geometry.constants import GRAVITY
from cavalcade.recording.physics_track import ContactEvent, PhysicsTrack
from cavalcade.robots import RobotModel
from cavalcade.robots.description import BodyShape, QuadrupedDescription

if TYPE_CHECKING:
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

_MOST_SAMPLES = 60_000
"""Of all robots together; more are thinned out. They take 84 bytes each in the page."""

_MOST_NODES = 150_000
"""Of the terrain's grid: steps of the ground are drawn where feet find them."""

_SAME = 0.5
"""Contacts of the same kind that follow within this time are told once, s."""

ANGLE = 2e-4
"""Unit of joint angles in the page, rad."""

FORCE = 0.1
"""Unit of forces in the page, N."""


def physics_data(
    scenario: Scenario,
    world: World,
    recording: Recording | None,
    track: PhysicsTrack,
    summary: Mapping[str, Any],
) -> dict[str, Any]:
    """All of it, as plain lists, numbers and text.

    Args:
        scenario: The scenario that was run.
        world: Its ground, as it was at the start.
        recording: What the planner did; None where there is none.
        track: What the robots did.
        summary: The content of `summary.json`; keys that are missing or null are left out.

    Raises:
        RecordingError: The track is empty, or not that of the scenario's robots.
    """
    descriptions = descriptions_of(scenario, track)
    shown = track.thinned(-(-len(track.time) * track.size // _MOST_SAMPLES))
    fixed, planner = world.shapes, None
    if recording is not None and len(recording.time):
        scene = scene_of(scenario, world, recording)
        fixed, planner = scene.fixed, _planner(scenario, world, scene, recording)
    goals = scenario.goals
    return {
        "name": str(scenario.name),
        "outcome": outcome(summary),
        "facts": _facts(summary, track),
        "end": round(float(track.time[-1]), 4),
        **ground_data(
            arena_of(world, fixed), world.base, fixed, world.terrain, most_nodes=_MOST_NODES
        ),
        "time": steps(shown.time, 1000),
        "bodies": {one.name: _body(one) for one in descriptions},
        "robots": [
            _robot(shown, robot, model, descriptions[robot], goals[robot] if goals else None)
            for robot, model in enumerate(scenario.models)
        ],
        "contacts": [
            [round(event.time, 3), event.robot, event.part, event.other]
            for event in merged_contacts(track.contacts)
        ],
        "falls": [[round(event.time, 3), event.robot] for event in track.falls],
        "planner": planner,
    }


def descriptions_of(scenario: Scenario, track: PhysicsTrack) -> list[QuadrupedDescription]:
    """The mechanisms of the robots of a track.

    Raises:
        RecordingError: The track is empty, or not that of the scenario's robots.
    """
    if not len(track.time) or track.size != len(scenario.models):
        raise RecordingError(
            f"expected samples of {len(scenario.models)} robots, "
            f"got {len(track.time)} of {track.size}",
            key="track",
        )
    found = []
    for model in scenario.models:
        if model.description is None:
            raise RecordingError(f"{model.name} has no legs in physics", key="track")
        found.append(model.description)
    return found


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


def _planner(scenario: Scenario, world: World, scene: Any, recording: Recording) -> dict[str, Any]:
    data = planner_data(scene)
    speed = np.linalg.norm(np.asarray(recording.commands)[..., :2], axis=2)
    data["clock"] = steps(recording.time, 1000)
    data["wanted"] = [steps(speed[:, k], 100) for k in range(scene.size)]
    data["movers"] = [
        {
            **prism_data(prism_of(said.ring, world.terrain)),
            **{name: track[name] for name in ("start", "end", "time", "x", "y")},
        }
        for said, track in zip(scene.tracks, data.pop("tracks"), strict=True)
    ]
    data["individual"] = bool(scenario.goals)
    return data


def _body(description: QuadrupedDescription) -> dict[str, Any]:
    return {
        **skeleton_of(description),
        "weight": round(GRAVITY * description.mass, 2),
        "looks": [_shape(shape) for shape in description.looks],
    }


def _shape(shape: BodyShape) -> dict[str, Any]:
    return {
        "link": shape.link,
        "part": shape.part,
        "kind": shape.kind,
        "size": _rounded(shape.size),
        "at": _rounded(shape.position),
        "turn": _rounded(shape.rotation),
        "colour": _rounded(shape.color, 3),
    }


def _robot(
    track: PhysicsTrack,
    robot: int,
    model: RobotModel,
    description: QuadrupedDescription,
    goal: tuple[float, float, float] | None,
) -> dict[str, Any]:
    base = track.base[:, robot]
    share = np.abs(track.torques[:, robot]) / description.torque_limits
    return {
        "colour": style.robot_color(robot),
        "body": description.name,
        "size": [model.length, model.width, model.height],
        "round": False,
        "goal": None if goal is None else _rounded(goal, 4),
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


def _rounded(values: Any, digits: int = 5) -> list[float]:
    return [round(float(value), digits) for value in values]


def _facts(summary: Mapping[str, Any], track: PhysicsTrack) -> list[list[str]]:
    """Rows of the summary for people, with what only physics knows in front."""
    return [
        ["falls", str(len(track.falls))],
        ["unwanted contacts", str(len(merged_contacts(track.contacts)))],
        *numbers(summary),
    ]
