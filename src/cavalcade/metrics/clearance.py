"""How close the team came to obstacles and to itself, from true poses and exact shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array, inverse_transform_points, rectangle_corners, wrap_angle
from cavalcade.geometry.distances import (
    Box,
    Cells,
    Polygons,
    boxes_clearance,
    cells_clearance,
    circles_clearance,
    polygons_clearance,
)
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.robots import RobotModel
from cavalcade.scenario import World
from cavalcade.world import Circle, OccupancyMap, Polygon, Shape

STEP = 0.01
"""Between two recorded poses others are interpolated so that nothing moves farther, m."""

_MOST_PARTS = 1000
_BODY_REACH = 0.5
"""How far the turning part of a motion is from the centre at most, m; of any model's size."""


@dataclass(frozen=True)
class Clearance:
    """The closest approaches of a run, m; inf where there is nothing to come close to.

    Attributes:
        obstacle_distance: A robot's centre to the nearest obstacle surface.
        robot_distance: Between the centres of two robots.
        footprint_gap: Between oriented footprints, robot to robot or robot to obstacle; 0 for a
            contact.
        robot_obstacle, robot_robot: Contacts that began.
    """

    obstacle_distance: float
    robot_distance: float
    footprint_gap: float
    robot_obstacle: int
    robot_robot: int


class _Motion:
    """One robot's poses `(M, 3)` on the way to a verdict.

    Attributes:
        best: The running minima and
        contact: `(M,)` where it touches something, as in `cavalcade.geometry.distances`.
    """

    def __init__(self, poses: Array, model: RobotModel, best: Array) -> None:
        self.poses = np.ascontiguousarray(poses)
        self.box = Box(*model.body)
        self.best = best
        self.contact = np.zeros(len(poses), dtype=bool)

    def judge_solids(self, circles: Array, polygons: Polygons) -> None:
        circles_clearance(self.poses, self.box, circles, self.best, self.contact)
        polygons_clearance(self.poses, self.box, polygons, self.best, self.contact)

    def judge_border(self, area: OccupancyMap) -> None:
        local = inverse_transform_points(area.origin, self.poses[:, :2])
        yaw = self.poses[:, 2] - area.origin[2]
        inside = np.minimum(local, np.array(area.size) - local)
        c, s = np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
        length, width, inflation = self.box
        half = 0.5 * np.column_stack([c * length + s * width, s * length + c * width]) + inflation
        self.best[0] = min(self.best[0], max(float(inside.min()), 0.0))
        gap = (inside - half).min(axis=1)
        self.best[1] = min(self.best[1], max(float(gap.min()), 0.0))
        self.contact |= gap <= 0.0

    def judge_cells(self, area: OccupancyMap, cells: Cells) -> None:
        yaw = self.poses[:, 2] - area.origin[2]
        local = np.column_stack([inverse_transform_points(area.origin, self.poses[:, :2]), yaw])
        cell = np.floor(local[:, 1::-1] / area.resolution).astype(int)
        row, col = np.clip(cell, 0, np.array(cells.occupied.shape) - 1).T
        order = np.argsort(cells.bound[row, col], kind="stable")
        cells_clearance(local, order, self.box, cells, self.best, self.contact)


def clearance(
    world: World,
    recording: Recording,
    models: Sequence[RobotModel],
    leapt: NDArray[np.bool_] | None = None,
) -> Clearance:
    """Judge a whole run.

    Obstacles are the exact shapes, the occupied cells of a map file as squares, all ground beyond
    the border, and what events add or move while it is there. Between two recorded poses a robot
    is taken to go straight, but for those `(T - 1, N)` in which somebody `leapt`: of them the ends
    alone are judged.
    """
    driven = np.ones(max(len(recording.time) - 1, 0), dtype=bool)
    if leapt is not None:
        driven &= ~leapt.any(axis=1)
    time, poses = _finer(recording, driven)
    best = np.array([np.inf, np.inf])
    events = 0
    fixed = _solids(fixed_shapes(world, recording))
    cells = _cells(world.base)
    for robot, model in enumerate(models):
        motion = _Motion(poses[:, robot], model, best)
        motion.judge_solids(*fixed)
        motion.judge_border(world.base)
        if cells is not None:
            motion.judge_cells(world.base, cells)
        events += begins(motion.contact)
        for track in recording.obstacles:
            events += begins(_judge_track(track, time, motion.poses, model, best))
    pair_best = np.array([np.inf, np.inf])
    pairs = 0
    for a in range(len(models)):
        for b in range(a):
            sizes = np.array([models[a].body, models[b].body])
            contact = np.zeros(len(poses), dtype=bool)
            one, other = (np.ascontiguousarray(poses[:, k]) for k in (a, b))
            boxes_clearance(one, other, sizes, pair_best, contact)
            pairs += begins(contact)
    return Clearance(
        obstacle_distance=float(best[0]),
        robot_distance=float(pair_best[0]),
        footprint_gap=float(min(best[1], pair_best[1])),
        robot_obstacle=events,
        robot_robot=pairs,
    )


def begins(contact: NDArray[np.bool_]) -> int:
    """How often contact `(M,)` begins; one that is there from the start counts."""
    if len(contact) == 0:
        return 0
    return int(contact[0]) + int(np.count_nonzero(contact[1:] & ~contact[:-1]))


def _finer(recording: Recording, driven: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Times `(M,)` and poses `(M, N, 3)`, with straight steps added in `driven` intervals."""
    time, poses = recording.time, recording.poses
    if len(time) < 2:
        return time, poses
    change = np.diff(poses, axis=0)
    change[..., 2] = wrap_angle(change[..., 2])
    farthest = np.hypot(change[..., 0], change[..., 1]) + _BODY_REACH * np.abs(change[..., 2])
    longest = farthest[driven].max(initial=0.0)
    for track in recording.obstacles:
        moved = np.diff(track.offset_at(time), axis=0)[driven]
        longest = max(longest, np.hypot(*moved.T).max(initial=0.0))
    parts = int(np.clip(np.ceil(longest / STEP), 1, _MOST_PARTS))
    part = np.arange(parts) / parts
    fine = poses[:-1, None] + part[None, :, None, None] * change[:, None]
    fine_time = time[:-1, None] + part[None, :] * np.diff(time)[:, None]
    kept = driven[:, None] | (part == 0.0)
    return np.concatenate([fine_time[kept], time[-1:]]), np.concatenate([fine[kept], poses[-1:]])


def fixed_shapes(world: World, recording: Recording) -> list[Shape]:
    """The shapes at the start that no track accounts for."""
    tracked = [track.solid for track in recording.obstacles if track.start <= 0.0]
    shapes = list(world.shapes)
    for shape in tracked:
        if shape in shapes:
            shapes.remove(shape)
    return shapes


def _solids(shapes: Sequence[Shape]) -> tuple[Array, Polygons]:
    """Discs `(K, 3)` x, y, radius, and all else as polygons."""
    circles = [(*shape.center, shape.radius) for shape in shapes if isinstance(shape, Circle)]
    rings, corners, starts = [], [np.zeros((0, 2))], [0]
    for shape in shapes:
        if isinstance(shape, Circle):
            continue
        if isinstance(shape, Polygon):
            vertices = np.array(shape.points)
        else:
            vertices = rectangle_corners((*shape.center, shape.yaw), *shape.size)
        centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
        radius = np.hypot(*(vertices - centre).T).max()
        rings.append((*centre, radius))
        corners.append(vertices)
        starts.append(starts[-1] + len(vertices))
    polygons = Polygons(
        np.concatenate(corners),
        np.array(starts, dtype=np.int64),
        np.array(rings, dtype=float).reshape(-1, 3),
    )
    return np.array(circles, dtype=float).reshape(-1, 3), polygons


def _judge_track(
    track: ObstacleTrack, time: Array, poses: Array, model: RobotModel, best: Array
) -> NDArray[np.bool_]:
    """Contacts `(M,)` with an obstacle that comes, goes or moves: seen from it, robots move."""
    there = (time >= track.start) & (time < track.end)
    contact = np.zeros(len(time), dtype=bool)
    if not there.any():
        return contact
    relative = poses[there].copy()
    relative[:, :2] -= track.offset_at(time[there])
    motion = _Motion(relative, model, best)
    motion.judge_solids(*_solids([track.solid]))
    contact[there] = motion.contact
    return contact


def _cells(area: OccupancyMap) -> Cells | None:
    """The map's occupied cells; None without any."""
    occupied = area.occupied
    if not occupied.any():
        return None
    from cavalcade.eikonal import surface_distance

    from_centres = surface_distance(occupied, area.resolution, border=False)
    bound = from_centres - np.sqrt(0.5) * area.resolution
    return Cells(occupied, bound, area.resolution)
