"""The replay: one HTML file that shows a run in any browser, with nothing else needed.

The page (`replay_page/`) is joined with the run's data into a file that loads nothing from
anywhere. Numbers travel as whole millimetres, milliradians and milliseconds, each as the
difference from the one before, which keeps a minute of four robots far below a megabyte.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.drawing import style
from cavalcade.drawing.distances import obstacle_distances, pair_distances
from cavalcade.drawing.outlines import simplified
from cavalcade.drawing.scene import Arena, Scene, Track, scene_of
from cavalcade.files import write_file
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

_SCRIPTS = ("data.js", "stage.js", "robots.js", "panels.js", "app.js")
_DARK = (
    "#4aa8e8",
    "#f2b632",
    "#2cc492",
    "#e79ac4",
    "#f07b3f",
    "#9ad7fa",
    "#b792d8",
    "#c9a84c",
    "#b4b8bd",
    "#4db6ac",
)
_MOST_POSES = 60_000
_MOST_PATHS = 4_000
_MOST_SERIES = 600


def write_replay(
    scenario: Scenario,
    world: World,
    recording: Recording,
    summary: Mapping[str, Any],
    path: str | Path,
) -> Path:
    """Write the replay of a run as one HTML file.

    Args:
        scenario: The scenario that was run.
        world: Its `World`: the map and the exact shapes, as they were at the start.
        recording: What happened; at least one cycle.
        summary: The content of `summary.json`; keys that are missing or null are left out.
        path: The file to write.

    Returns:
        The file written.

    Raises:
        OutputError: It cannot be written.
    """
    target = Path(path)
    scene = scene_of(scenario, world, recording)
    data = replay_data(scene, world, summary, waypoints=len(scenario.task.goals))
    page = replay_page(data)
    write_file(target, page)
    return target


def replay_page(data: Mapping[str, Any]) -> str:
    """The whole HTML text for what `replay_data` made."""
    folder = files("cavalcade.drawing.replay") / "formation_page"
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    # Inside a script element only "<" can end or change the element.
    text = text.replace("<", "\\u003c")
    parts = {
        "TITLE": html.escape(f"{data['name']} – Cavalcade replay"),
        "STYLE": (folder / "style.css").read_text(encoding="utf-8"),
        "SCRIPT": "\n".join((folder / name).read_text(encoding="utf-8") for name in _SCRIPTS),
        "RUN": text,
    }
    pieces = (folder / "page.html").read_text(encoding="utf-8").split("%")
    # The page has its places as %NAME%, and no other percent signs.
    return "".join(parts[piece] if index % 2 else piece for index, piece in enumerate(pieces))


def replay_data(
    scene: Scene, world: World, summary: Mapping[str, Any], waypoints: int = 1
) -> dict[str, Any]:
    """What the page needs to know of a run, as plain lists and numbers."""
    picked = _picked(scene)
    poses = scene.poses[picked]
    yaw = np.unwrap(poses[..., 2], axis=0)
    return {
        "name": scene.name,
        "outcome": outcome(summary),
        "numbers": numbers(summary),
        "waypoints": waypoints,
        "radius": scene.radius,
        "colors": {"light": style.ROBOTS, "dark": _DARK},
        "view": _whole(scene.view(2.0), 1000),
        "arena": _arena(scene.arena),
        "robots": [
            {"model": model.name, "length": model.length, "width": model.width}
            for model in scene.models
        ],
        "pose": [
            {
                "x": _steps(poses[:, k, 0], 1000),
                "y": _steps(poses[:, k, 1], 1000),
                "a": _steps(yaw[:, k], 1000),
            }
            for k in range(scene.size)
        ],
        "series": _series(scene, world),
        **planner_data(scene),
    }


def planner_data(scene: Scene) -> dict[str, Any]:
    """What the planner wanted and what happened: goals, slots, paths, obstacles, notes."""
    picked = _picked(scene)
    goals = np.stack([scene.status[i].goals for i in picked])
    goals = np.where(np.isfinite(goals), goals, scene.poses[picked][..., :2])
    slot_sets, phases = _phases(scene)
    return {
        "tracks": [_track(track) for track in scene.tracks],
        "time": _steps(scene.time[picked], 1000),
        "goals": [
            {"x": _steps(goals[:, k, 0], 100), "y": _steps(goals[:, k, 1], 100)}
            for k in range(scene.size)
        ],
        "slots": [_points(slots, 1000) for slots in slot_sets],
        "phases": phases,
        "paths": _paths(scene),
        "notes": [[round(float(time), 3), text] for time, text in scene.notes],
    }


def _picked(scene: Scene) -> list[int]:
    """The cycles that travel."""
    return _every(len(scene.time), -(-scene.poses.shape[0] * scene.size // _MOST_POSES))


def _every(count: int, stride: int) -> list[int]:
    """Every `stride`-th index below `count`, and the last one."""
    picked = list(range(0, count, max(1, stride)))
    return picked if picked[-1] == count - 1 else [*picked, count - 1]


def _whole(values: Array, unit: float) -> list[int]:
    return [int(value) for value in np.rint(np.asarray(values, dtype=float) * unit)]


def _steps(values: Array, unit: float) -> list[int]:
    """The first value and then the differences, in whole units."""
    whole = np.rint(np.asarray(values, dtype=float) * unit).astype(np.int64)
    return [int(value) for value in np.diff(whole, prepend=0)]


def _points(line: Array, unit: float) -> list[int]:
    """x, y, dx, dy, dx, dy, ... in whole units."""
    whole = np.rint(np.asarray(line, dtype=float).reshape(-1, 2) * unit).astype(np.int64)
    steps = np.diff(whole, axis=0, prepend=np.zeros((1, 2), dtype=np.int64))
    return [int(value) for value in steps.ravel()]


def _arena(arena: Arena) -> dict[str, Any]:
    return {
        "border": _points(arena.border, 1000),
        "walls": [_points(ring, 1000) for ring in arena.walls],
        "unknown": [_points(ring, 1000) for ring in arena.unknown],
        "shapes": [_points(ring, 1000) for ring in arena.shapes],
    }


def _track(track: Track) -> dict[str, Any]:
    return {
        "ring": _points(track.ring, 1000),
        "start": round(track.start, 3),
        "end": round(track.end, 3) if np.isfinite(track.end) else None,
        "time": [round(float(time), 3) for time in track.time],
        "x": [round(float(x), 3) for x in track.offset[:, 0]],
        "y": [round(float(y), 3) for y in track.offset[:, 1]],
    }


def _phases(scene: Scene) -> tuple[list[Array], list[dict[str, Any]]]:
    """The distinct sets of slots, and what the planner said whenever that changed."""
    sets: list[Array] = []
    number: dict[bytes, int] = {}
    phases: list[dict[str, Any]] = []
    for time, status in zip(scene.time, scene.status, strict=True):
        key = np.asarray(status.slots, dtype=float).tobytes()
        if key not in number:
            number[key] = len(sets)
            sets.append(np.asarray(status.slots, dtype=float))
        roles = [int(role) for role in status.roles]
        goal = None if status.goal is None else [round(float(v), 3) for v in status.goal]
        phase = {
            "state": status.state,
            "leader": int(status.leader),
            "roles": roles,
            # Without a task nobody has a role; with one, who has none is lost.
            "lost": [int(role < 0 and max(roles) >= 0) for role in roles],
            "slots": number[key],
            "joints": np.asarray(status.connections, dtype=int).reshape(-1, 2).tolist(),
            "goal": goal,
            "waypoint": int(status.waypoint),
            "arrived": bool(status.arrived),
            "message": status.message,
        }
        if not phases or any(phases[-1][name] != value for name, value in phase.items()):
            phases.append({"t": round(float(time), 3), **phase})
    return sets, phases


def _paths(scene: Scene) -> dict[str, Any]:
    """The paths being followed, a few times a second, with the fewest points that show them."""
    duration = max(float(scene.time[-1] - scene.time[0]), 1e-6)
    spacing = max(0.25, duration * scene.size / _MOST_PATHS)
    marks = np.arange(scene.time[0], scene.time[-1] + spacing, spacing)
    picked = np.unique(np.clip(np.searchsorted(scene.time, marks), 0, len(scene.time) - 1))
    lines, etas = [], []
    for cycle in picked:
        status = scene.status[int(cycle)]
        lines.append([_points(simplified(_finite(line), 0.015), 100) for line in status.paths])
        best = float(np.min(status.eta, initial=np.inf))
        etas.append(round(10.0 * best) if np.isfinite(best) else None)
    return {"time": _steps(scene.time[picked], 1000), "lines": lines, "eta": etas}


def _finite(line: Array) -> Array:
    """The points `(K, 2)` of a path that can be drawn."""
    points = np.asarray(line, dtype=float).reshape(-1, 2)
    return points[np.isfinite(points).all(axis=1)]


def _series(scene: Scene, world: World) -> dict[str, Any]:
    """Distances over time, thinned to what a small chart can show without losing the minima."""
    clear = np.minimum(obstacle_distances(scene, world), 99.0)
    stride = max(1, -(-len(scene.time) // _MOST_SERIES))
    starts = np.arange(0, len(scene.time), stride)
    clear = np.minimum.reduceat(clear, starts, axis=0)
    nearest: list[Array] = []
    if scene.size > 1:
        pairs, gaps = pair_distances(scene.poses)
        gaps = np.minimum.reduceat(gaps, starts, axis=0)
        nearest = [gaps[:, (pairs == k).any(axis=1)].min(axis=1) for k in range(scene.size)]
    return {
        "time": _steps(scene.time[starts], 1000),
        "obstacle": [_steps(clear[:, k], 100) for k in range(scene.size)],
        "neighbour": [_steps(np.minimum(line, 99.0), 100) for line in nearest],
    }


def outcome(summary: Mapping[str, Any]) -> dict[str, Any]:
    """How the run ended, for people, and whether that is good."""
    reason = str(summary.get("reason") or "")
    makespan = summary.get("makespan_s")
    text = reason or "run"
    if summary.get("success") and makespan is not None:
        text = f"{reason or 'done'} in {float(makespan):.1f} s"
    return {"text": text, "good": bool(summary.get("success"))}


def numbers(summary: Mapping[str, Any]) -> list[list[str]]:
    """(name, value) rows of the summary for people."""
    error = summary.get("formation_error_m") or {}
    collisions = summary.get("collisions") or {}
    found: list[tuple[str, Any, str]] = [
        ("closest to an obstacle", summary.get("min_obstacle_distance_m"), "{:.2f} m"),
        ("closest two robots", summary.get("min_robot_distance_m"), "{:.2f} m"),
        ("smallest gap of bodies", summary.get("min_footprint_gap_m"), "{:.2f} m"),
        ("collisions", sum(v or 0 for v in collisions.values()) if collisions else None, "{}"),
        ("formation error, mean", error.get("mean"), "{:.2f} m"),
        ("leader changes", summary.get("leader_changes"), "{}"),
        ("slot changes", summary.get("role_changes"), "{}"),
        ("variant", summary.get("variant"), "{}"),
        ("seed", summary.get("seed"), "{}"),
    ]
    return [[name, shape.format(value)] for name, value, shape in found if value is not None]
