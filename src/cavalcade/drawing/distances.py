"""Distances over a whole run, measured to surfaces, for the figures and the replay."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.scene import Scene, runs
from cavalcade.geometry import Array
from cavalcade.world import OccupancyMap, distance_to_shapes


def obstacle_distances(scene: Scene) -> Array:
    """`(T, N)` distance in m of each robot's centre to the nearest obstacle's surface.

    Obstacles are the exact shapes, the map's occupied cells as squares, everything beyond the
    map's border, and what events put in the way while it was there. 0.0 inside an obstacle.
    """
    time, poses, grid = scene.recording.time, scene.recording.poses, scene.world.base
    cycles, robots = poses.shape[:2]
    points = poses[..., :2].reshape(-1, 2)
    local = grid.to_local(points)
    nearest = np.minimum(local, grid.size - local).min(axis=1)  # to the border
    nearest = np.minimum(nearest, distance_to_shapes(scene.fixed, points))
    nearest = np.minimum(nearest, _cell_distance(grid, points))
    result = np.maximum(nearest, 0.0).reshape(cycles, robots)
    for track in scene.recording.obstacles:
        there = (time >= track.start) & (time < track.end)
        if there.any():
            offset = track.offset_at(time[there])[:, None, :]
            moved = (poses[there][..., :2] - offset).reshape(-1, 2)
            away = np.asarray(track.solid.distance(moved)).reshape(-1, robots)
            result[there] = np.minimum(result[there], away)
    return result


def pair_distances(poses: Array) -> tuple[NDArray[np.int64], Array]:
    """All pairs `(P, 2)` of robots and the distances `(T, P)` in m between their centres."""
    first, second = np.triu_indices(poses.shape[1], k=1)
    gaps = poses[:, first, :2] - poses[:, second, :2]
    return np.column_stack([first, second]), np.hypot(gaps[..., 0], gaps[..., 1])


def neighbour_distances(poses: Array) -> Array:
    """`(T, N)` distance in m from each robot's centre to that of its nearest neighbour."""
    pairs, gaps = pair_distances(poses)
    nearest = [gaps[:, (pairs == k).any(axis=1)].min(axis=1) for k in range(poses.shape[1])]
    return np.column_stack(nearest)


def rest_lengths(scene: Scene) -> list[tuple[float, float, float]]:
    """(start, end, length): the distinct lengths of the shape's connections, as they held.

    A connection belongs to slots, so its length at rest is the distance of its slots.
    """
    time, statuses = scene.recording.time, scene.recording.status
    spans: list[tuple[float, float, float]] = []
    for _, first, last in runs(status.slots.tobytes() for status in statuses):
        lengths: set[float] = set()
        # Connections may be empty while the planner idles: look through the whole span.
        for status in statuses[first : last : max(1, (last - first) // 20)]:
            for a, b in np.asarray(status.connections, dtype=int).reshape(-1, 2):
                slot_a, slot_b = int(status.roles[a]), int(status.roles[b])
                if min(slot_a, slot_b) >= 0 and max(slot_a, slot_b) < len(status.slots):
                    gap = status.slots[slot_a] - status.slots[slot_b]
                    lengths.add(round(float(np.hypot(*gap)), 2))
        start, end = float(time[first]), float(time[min(last, len(time) - 1)])
        spans += [(start, end, length) for length in sorted(lengths)]
    return spans


def _cell_distance(grid: OccupancyMap, points: Array) -> Array:
    """Distance `(K,)` in m to the nearest occupied cell as a square; 0.0 inside."""
    from scipy.ndimage import binary_erosion
    from scipy.spatial import cKDTree

    cells = grid.occupied
    if not cells.any():
        return np.full(len(points), np.inf)
    # Only cells with a free neighbour can be the nearest one, unless the point is inside.
    rim = cells & ~binary_erosion(cells, border_value=1)
    local = grid.to_local(points)
    centres = (np.argwhere(rim if rim.any() else cells)[:, ::-1] + 0.5) * grid.resolution
    count = min(16, len(centres))
    _, index = cKDTree(centres).query(local, k=count)
    gap = np.abs(centres[np.asarray(index).reshape(len(points), count)] - local[:, None, :])
    gap = np.maximum(gap - grid.resolution / 2.0, 0.0)
    away = np.asarray(np.hypot(gap[..., 0], gap[..., 1]).min(axis=1))
    at = grid.cell_of(points)
    within = ((at >= 0) & (at < cells.shape)).all(axis=1)
    away[within] *= ~cells[tuple(at[within].T)]
    return away
