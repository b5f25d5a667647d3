"""What the page of a plan's replay needs to know, small: whole numbers, grids as base 64."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.body.trajectory import Trajectory
from cavalcade.geometry import Array
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.robots import RobotModel
from cavalcade.running.figures import style
from cavalcade.running.figures.outlines import shape_ring
from cavalcade.running.plans.keyframes import keyframes
from cavalcade.running.plans.meshes import Prism, counter_clockwise, rectangles, triangulate
from cavalcade.running.plans.scene import PlanScene, activities, runs
from cavalcade.scenario import World
from cavalcade.world import OccupancyMap, Terrain

_MOST_NODES = 22_000
"""Of the terrain's grid in the page."""

_MOST_FOOTHOLDS = 12_000
_WALL = 0.45
"""How high solid obstacles are drawn, m: their true height is unlimited."""


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
        "border": _whole(scene.arena.border, 1000),
        "terrain": None if scene.terrain is None else _terrain(scene.terrain),
        "solids": [_prism(prism) for prism in _prisms(scene, world)],
        "walls": _walls(world.base, scene.terrain),
        "tick": unit,
        "robots": [
            _robot(scene, robot, unit, scene.footholds[robot] if stepping else None)
            for robot in range(scene.size)
        ],
    }


def _terrain(terrain: Terrain) -> dict[str, Any]:
    """Every so many-th node of the grid, heights in 1/65000 of their range."""
    stride = max(1, int(np.ceil(np.sqrt(terrain.rows * terrain.cols / _MOST_NODES))))
    rows, cols = (np.unique(np.append(np.arange(0, n, stride), n - 1)) for n in
                  (terrain.rows, terrain.cols))  # fmt: skip
    height = terrain.height[np.ix_(rows, cols)]
    blocked = terrain.traversability[np.ix_(rows, cols)] < LEAST_TRAVERSABILITY
    low, span = float(height.min()), max(float(np.ptp(height)), 1e-6)
    whole = np.rint((height - low) / span * 65_000).astype("<u2")
    return {
        "x": _whole((cols + 0.5) * terrain.resolution, 1000),
        "y": _whole((rows + 0.5) * terrain.resolution, 1000),
        "origin": [round(part, 6) for part in terrain.origin],
        "low": low,
        "span": span,
        "heights": _packed(whole),
        "blocked": _packed(np.packbits(blocked.ravel())),
    }


def _prisms(scene: PlanScene, world: World) -> Iterable[Prism]:
    for shape in world.shapes:
        ring = counter_clockwise(shape_ring(shape, corners=28))
        low, high = _foot_and_top(ring, scene.terrain)
        yield Prism(ring, triangulate(ring), low, high)


def _foot_and_top(ring: Array, terrain: Terrain | None) -> tuple[float, float]:
    if terrain is None:
        return 0.0, _WALL
    around = terrain.heights_at(np.concatenate([ring, ring.mean(axis=0)[None, :]]))
    return float(around.min()) - 0.05, float(around.max()) + _WALL


def _prism(prism: Prism) -> dict[str, Any]:
    return {
        "ring": _whole(prism.ring, 1000),
        "fill": prism.triangles.ravel().tolist(),
        "low": round(prism.low, 3),
        "high": round(prism.high, 3),
    }


def _walls(area: OccupancyMap, terrain: Terrain | None) -> dict[str, Any] | None:
    """Occupied cells of the map as rectangles in the grid's own frame."""
    if not area.occupied.any():
        return None
    found, factor = rectangles(area.occupied)
    top = 0.0 if terrain is None else float(terrain.height.max())
    return {
        "cell": area.resolution * factor,
        "origin": [round(part, 6) for part in area.origin],
        "low": 0.0 if terrain is None else float(terrain.height.min()),
        "high": round(top + _WALL, 3),
        "boxes": found.ravel().tolist(),
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
        "t": _steps(path.time[kept], 1000),
        "x": _steps(path.position[kept, 0], 1000),
        "y": _steps(path.position[kept, 1], 1000),
        "z": _steps(path.position[kept, 2], 1000),
        "a": _steps(path.yaw[kept], 1000),
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
        "down": _packed(np.rint(rows[:, 0] / unit).astype("<u2")),
        "up": _packed(np.rint(rows[:, 1] / unit).astype("<u2")),
        "base": [round(float(part), 4) for part in base],
        "place": _packed(places.astype("<i2")),
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


def _packed(values: NDArray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _whole(values: Array, unit: float) -> list[int]:
    return [int(value) for value in np.rint(np.asarray(values, dtype=float).ravel() * unit)]


def _steps(values: Array, unit: float) -> list[int]:
    whole = np.rint(np.asarray(values, dtype=float) * unit).astype(np.int64)
    return [int(value) for value in np.diff(whole, prepend=0)]
