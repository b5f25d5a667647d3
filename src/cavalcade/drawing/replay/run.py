"""What the planner wanted and what happened on the way: the `run` of the page's data.

Numbers travel as whole millimetres, milliradians and milliseconds, each as the difference from the
one before, which keeps a minute of four robots far below a megabyte.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cavalcade.drawing.distances import neighbour_distances, obstacle_distances
from cavalcade.drawing.outlines import shape_ring, simplified
from cavalcade.drawing.replay.ground import prism
from cavalcade.drawing.replay.packing import rounded, steps
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array

_MOST_POSES = 60_000
_MOST_PATHS = 4_000
_MOST_SERIES = 600


def run_data(scene: Scene, driven: bool) -> dict[str, Any]:
    """Goals, slots, phases, paths, obstacles that come and go, notes, distances over time.

    `driven`: whether the recorded poses move the robots of the page; then they travel too.
    """
    recording = scene.recording
    # Each robot has a goal of its own: no formation, no distances to keep.
    individual = bool(scene.scenario.goals)
    last = len(recording.time) - 1
    stride = max(1, -(-len(recording.time) * scene.size // _MOST_POSES))
    picked = [*range(0, last, stride), last]
    poses = recording.poses[picked]
    goals = np.stack([recording.status[i].goals for i in picked])
    goals = np.where(np.isfinite(goals), goals, poses[..., :2])
    slot_sets, phases = _phases(scene)
    yaw = np.unwrap(poses[..., 2], axis=0)
    columns = {"x": poses[..., 0], "y": poses[..., 1], "a": yaw}
    return {
        "waypoints": len(scene.scenario.task.goals),
        "radius": scene.radius,
        "time": steps(recording.time[picked], 1000),
        "poses": [
            {name: steps(values[:, k], 1000) for name, values in columns.items()}
            for k in range(scene.size)
        ]
        if driven
        else None,
        "goals": [] if individual else [steps(goals[:, k], 100) for k in range(scene.size)],
        "slots": [steps(slots, 1000) for slots in slot_sets],
        "phases": phases,
        "paths": _paths(scene),
        "notes": [[round(float(time), 3), text] for time, text in recording.notes],
        "series": None if individual else _series(scene),
        "movers": [
            {
                **prism(shape_ring(track.solid), scene.world.terrain),
                "start": round(track.start, 3),
                "end": round(track.end, 3) if np.isfinite(track.end) else None,
                "time": rounded(track.time, 3),
                "x": rounded(track.offset[:, 0], 3),
                "y": rounded(track.offset[:, 1], 3),
            }
            for track in recording.obstacles
        ],
    }


def _phases(scene: Scene) -> tuple[list[Array], list[dict[str, Any]]]:
    """The distinct sets of slots, and what the planner said whenever that changed."""
    sets: list[Array] = []
    number: dict[bytes, int] = {}
    phases: list[dict[str, Any]] = []
    for time, status in zip(scene.recording.time, scene.recording.status, strict=True):
        slots = np.asarray(status.slots, dtype=float)
        key = slots.tobytes()
        if key not in number:
            number[key] = len(sets)
            sets.append(slots)
        roles = [int(role) for role in status.roles]
        phase = {
            "state": status.state,
            "leader": int(status.leader),
            "roles": roles,
            # Without a task nobody has a role; with one, who has none is lost.
            "lost": [int(role < 0 and max(roles) >= 0) for role in roles],
            "slots": number[key],
            "joints": np.asarray(status.connections, dtype=int).reshape(-1, 2).tolist(),
            "goal": None if status.goal is None else rounded(status.goal, 3),
            "waypoint": int(status.waypoint),
            "arrived": bool(status.arrived),
            "message": status.message,
        }
        if not phases or any(phases[-1][name] != value for name, value in phase.items()):
            phases.append({"t": round(float(time), 3), **phase})
    return sets, phases


def _paths(scene: Scene) -> dict[str, Any]:
    """The paths being followed, a few times a second, with the fewest points that show them."""
    time = scene.recording.time
    duration = max(float(time[-1] - time[0]), 1e-6)
    spacing = max(0.25, duration * scene.size / _MOST_PATHS)
    marks = np.arange(time[0], time[-1] + spacing, spacing)
    picked = np.unique(np.clip(np.searchsorted(time, marks), 0, len(time) - 1))
    lines, etas = [], []
    for cycle in picked:
        status = scene.recording.status[int(cycle)]
        paths = (np.reshape(path, (-1, 2)) for path in status.paths)
        drawable = [path[np.isfinite(path).all(axis=1)] for path in paths]
        lines.append([steps(simplified(line, 0.015), 100) for line in drawable])
        best = float(np.min(status.eta, initial=np.inf))
        etas.append(round(10.0 * best) if np.isfinite(best) else None)
    return {"time": steps(time[picked], 1000), "lines": lines, "eta": etas}


def _series(scene: Scene) -> dict[str, Any]:
    """Distances over time, thinned to what a small chart can show without losing the minima."""
    clear, time = np.minimum(obstacle_distances(scene), 99.0), scene.recording.time
    starts = np.arange(0, len(time), max(1, -(-len(time) // _MOST_SERIES)))
    clear = np.minimum.reduceat(clear, starts, axis=0)
    nearest = np.zeros((len(starts), 0))
    if scene.size > 1:
        nearest = np.minimum.reduceat(neighbour_distances(scene.recording.poses), starts, axis=0)
    return {
        "time": steps(time[starts], 1000),
        "obstacle": [steps(clear[:, k], 100) for k in range(scene.size)],
        "neighbour": [steps(np.minimum(line, 99.0), 100) for line in nearest.T],
    }
