"""What the page of a plan's replay needs to know, small: whole numbers, grids as base 64."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.plans.keyframes import keyframes
from cavalcade.drawing.plans.scene import PlanScene, activities, runs
from cavalcade.drawing.replay.page3d.ground import ground_data
from cavalcade.drawing.replay.page3d.packing import packed, steps
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.robots import RobotModel
from cavalcade.scenario import World

_MOST_FOOTHOLDS = 12_000


def replay_data(scene: PlanScene, world: World, summary: Mapping[str, Any]) -> dict[str, Any]:
    """All of it, as plain lists, numbers and text.

    Args:
        scene: The plan.
        world: Its ground.
        summary: The content of `summary.json`.
    """
    stepping = sum(len(feet) for feet in scene.footholds) <= _MOST_FOOTHOLDS
    unit = max(0.002, scene.makespan / 60_000)
    return {
        "name": scene.name,
        "outcome": {"text": _outcome(scene), "good": scene.solved},
        "facts": _facts(summary),
        "end": round(scene.makespan, 4),
        **ground_data(scene.arena, world.base, world.shapes, scene.terrain),
        "tick": unit,
        "robots": [
            _robot(scene, robot, unit, scene.footholds[robot] if stepping else None)
            for robot in range(scene.size)
        ],
    }


def _robot(scene: PlanScene, robot: int, unit: float, feet: Array | None) -> dict[str, Any]:
    model, path = scene.models[robot], scene.paths[robot]
    return {
        "colour": style.robot_color(robot),
        "size": [model.length, model.width, model.height],
        "round": model.round,
        "legs": _legs(model),
        "start": [round(float(part), 4) for part in scene.starts[robot]],
        "goal": [round(float(part), 4) for part in scene.goals[robot]],
        "path": None if path is None else _path(path),
        "feet": None if feet is None or not len(feet) else _feet(feet, unit),
    }


def _legs(model: RobotModel) -> dict[str, float] | None:
    legs = model.legs
    if legs is None:
        return None
    return {
        "x": legs.hip_x,
        "y": legs.hip_y,
        "h": legs.h_nom,
        "link": 0.6 * legs.h_max,
        "swing": legs.swing_height,
    }


def _path(path: Trajectory) -> dict[str, Any]:
    """Key frames, each as the difference from the one before; ms, mm, mrad."""
    kept = keyframes(path)
    doing = activities(path)
    spans = [
        [kind, round(float(path.time[first]), 3), round(float(path.time[last]), 3)]
        for kind, first, last in runs(doing)
    ]
    return {
        "t": steps(path.time[kept], 1000),
        "x": steps(path.position[kept, 0], 1000),
        "y": steps(path.position[kept, 1], 1000),
        "z": steps(path.position[kept, 2], 1000),
        "a": steps(path.yaw[kept], 1000),
        "p": [int(phase) for phase in path.phase[kept]],
        "spans": spans,
        "end": round(path.duration, 4),
    }


def _feet(feet: Array, unit: float) -> dict[str, Any]:
    """Leg after leg: times in ticks, places in cm halves from the first one."""
    order = np.lexsort((feet[:, 0], feet[:, 2]))
    rows = feet[order]
    base = rows[0, 3:6]
    places = np.clip(np.rint((rows[:, 3:6] - base) * 200), -32_000, 32_000)
    return {
        "count": [int(np.count_nonzero(rows[:, 2] == leg)) for leg in range(4)],
        "down": packed(np.rint(rows[:, 0] / unit).astype("<u2")),
        "up": packed(np.rint(rows[:, 1] / unit).astype("<u2")),
        "base": [round(float(part), 4) for part in base],
        "place": packed(places.astype("<i2")),
    }


def _outcome(scene: PlanScene) -> str:
    return f"solved, {scene.makespan:.1f} s" if scene.solved else scene.result


def _facts(summary: Mapping[str, Any]) -> list[list[str]]:
    """(name, value) rows of the summary for people."""
    method = str(summary.get("method"))
    if summary.get("found_by") not in (None, method):
        method += f" → {summary['found_by']}"
    lengths = [v for v in summary.get("path_length_m") or () if v is not None]
    bounds = [v for v in summary.get("lower_bound_m") or () if v is not None]
    found: list[tuple[str, Any, str]] = [
        ("method", method, "{}"),
        ("planning time", summary.get("planning_time_s"), "{:.3f} s"),
        ("all parked after", summary.get("makespan_s"), "{:.1f} s"),
        ("summed length", sum(lengths) if lengths else None, "{:.2f} m"),
        ("shortest, alone", sum(bounds) if bounds else None, "{:.2f} m"),
        ("smallest gap of bodies", summary.get("min_footprint_gap_m"), "{:.2f} m"),
        ("seed", summary.get("seed"), "{}"),
    ]
    return [[name, shape.format(value)] for name, value, shape in found if value is not None]
