"""What the page needs to know of a run or a plan, as plain lists, numbers and text.

Ground, robots and rows of the summary are always there. What moves the robots is, in this order,
the track of a run in physics, the trajectories of a plan, or the poses of a recording. `run` tells
what a planner wanted and what happened on the way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.replay.ground import ground_data
from cavalcade.drawing.replay.packing import rounded, whole
from cavalcade.drawing.replay.run import run_data
from cavalcade.drawing.replay.track import merged_contacts, track_data
from cavalcade.drawing.replay.trajectories import plan_data
from cavalcade.drawing.scene import PlanScene, Scene, Team
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.robots import RobotModel

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

_MARGIN = 0.8
"""Around what moves, m."""


def replay_data(
    scenario: Scenario,
    world: World,
    *,
    recording: Recording | None = None,
    plan: PlanResult | None = None,
    summary: Mapping[str, Any],
) -> dict[str, Any]:
    """All of it; the arguments are those of `write_replay`.

    Raises:
        RecordingError: The recording's track is empty, or not that of the scenario's robots.
    """
    track = None if recording is None else recording.physics
    planned = None if plan is None or track is not None else PlanScene(scenario, world, plan)
    scene = None
    if recording is not None and len(recording.time):
        scene = Scene(scenario, world, recording)
    individual = bool(scenario.goals)
    members = zip_longest(scenario.models, scenario.starts, scenario.goals)
    robots = [_robot(*member) for member in members]
    data: dict[str, Any] = {
        "name": str(scenario.name),
        "individual": individual,
        "outcome": _outcome(summary, planned),
        "facts": _facts(summary, planned, track, individual),
        "colours": {"light": style.ROBOTS, "dark": style.ROBOTS_ON_DARK},
        **ground_data(scene or Team(scenario, world), dense=track is not None),
        "robots": robots,
        "run": None,
    }
    begin, end = 0.0, 0.0
    places = [np.array([*scenario.starts, *scenario.goals])[:, :2]]
    if scene is not None:
        begin, end = float(scene.recording.time[0]), float(scene.recording.time[-1])
        places.append(scene.recording.poses[..., :2].reshape(-1, 2))
        data["run"] = run_data(scene, driven=track is None and planned is None)
    if planned is not None:
        end = max(planned.makespan, end)
        places += [path.position[:, :2] for _, path in planned.known]
        data |= plan_data(planned, robots)
    if track is not None:
        begin, end = 0.0, float(track.time[-1])
        places.append(track.base[..., :2].reshape(-1, 2))
        data |= track_data(scenario, track, recording if scene else None, robots)
    view = _around(places) if scene is None or individual else scene.view(2.0)
    return data | {"begin": round(begin, 4), "end": round(end, 4), "view": whole(view, 1000)}


def _robot(model: RobotModel, start: Sequence[float], goal: Sequence[float] | None) -> Any:
    legs = model.legs
    return {
        "model": model.name,
        "size": [model.length, model.width, model.height],
        "round": model.round,
        "legs": None
        if legs is None
        else {
            "x": legs.hip_x,
            "y": legs.hip_y,
            "h": legs.h_nom,
            "link": 0.6 * legs.h_max,
            "swing": legs.swing_height,
        },
        "start": rounded(start, 4),
        **({} if goal is None else {"goal": rounded(goal, 4)}),
    }


def _around(places: list[Array]) -> Array:
    points = np.concatenate(places)
    return np.concatenate([points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN])


def _outcome(summary: Mapping[str, Any], planned: PlanScene | None) -> dict[str, Any]:
    """How it ended, for people, and whether that is good."""
    if planned is not None and not planned.plan.solved:
        return {"text": planned.result, "good": False}
    reason, makespan = str(summary.get("reason") or ""), summary.get("makespan_s")
    text = reason or "run"
    if summary.get("success") and makespan is not None:
        text = f"{reason or 'done'} in {float(makespan):.1f} s"
    return {"text": text, "good": bool(summary.get("success"))}


def _facts(
    summary: Mapping[str, Any],
    planned: PlanScene | None,
    track: PhysicsTrack | None,
    individual: bool,
) -> list[list[str]]:
    """(name, value) rows of the summary for people."""
    error = summary.get("formation_error_m") or {}
    collisions = summary.get("collisions") or {}
    found: list[tuple[str, Any, str]] = []
    if track is not None:
        found += [
            ("falls", len(track.falls), "{}"),
            ("unwanted contacts", len(merged_contacts(track.contacts)), "{}"),
        ]
    if planned is not None:
        method = str(summary.get("method"))
        if summary.get("found_by") not in (None, method):
            method += f" → {summary['found_by']}"
        lengths = [v for v in summary.get("path_length_m") or () if v is not None]
        bounds = [v for v in summary.get("lower_bound_m") or () if v is not None]
        found += [
            ("method", method, "{}"),
            ("planning time", summary.get("planning_time_s"), "{:.3f} s"),
            ("all parked after", summary.get("makespan_s"), "{:.1f} s"),
            ("summed length", sum(lengths) if lengths else None, "{:.2f} m"),
            ("shortest, alone", sum(bounds) if bounds else None, "{:.2f} m"),
        ]
    found += [
        ("closest to an obstacle", summary.get("min_obstacle_distance_m"), "{:.2f} m"),
        ("closest two robots", summary.get("min_robot_distance_m"), "{:.2f} m"),
        ("smallest gap of bodies", summary.get("min_footprint_gap_m"), "{:.2f} m"),
        ("collisions", sum(v or 0 for v in collisions.values()) if collisions else None, "{}"),
        ("formation error, mean", error.get("mean"), "{:.2f} m"),
        ("leader changes", summary.get("leader_changes"), "{}"),
        ("slot changes", summary.get("role_changes"), "{}"),
        ("variant", None if individual else summary.get("variant"), "{}"),
        ("seed", summary.get("seed"), "{}"),
    ]
    return [[name, shape.format(value)] for name, value, shape in found if value is not None]
