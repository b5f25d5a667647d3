"""Triangles for the scene: prisms, walls of map cells, heights, bodies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.replay.ground import counter_clockwise, triangulate
from cavalcade.geometry import Array
from cavalcade.robots import BodyShape

Faces = NDArray[np.int64]


class Mesh(NamedTuple):
    """Corners `(V, 3)`, m, and triangles `(F, 3)` of their indices, outward counter-clockwise."""

    vertices: Array
    faces: Faces

    def moved(self, offset: Array) -> Mesh:
        """The same, displaced by `(3,)` m."""
        return Mesh(self.vertices + offset, self.faces)


def joined(parts: Iterable[Mesh]) -> Mesh:
    """Several as one."""
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], 0
    for part in parts:
        vertices.append(part.vertices)
        faces.append(part.faces + count)
        count += len(part.vertices)
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def quads(corners: Array) -> Mesh:
    """Rectangles given by corners `(K, 4, 3)`, counter-clockwise from outside."""
    first = 4 * np.arange(len(corners))[:, None]
    faces = (first[:, :, None] + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), faces)


def prism(outline: Array, low: float, high: float) -> Mesh:
    """The upright prism over a simple outline `(K, 2)`, without its bottom."""
    ring = counter_clockwise(np.asarray(outline, dtype=float))
    following = np.roll(ring, -1, axis=0)
    bottom, top = np.full((len(ring), 1), low), np.full((len(ring), 1), high)
    sides = np.stack(
        [
            np.hstack([ring, bottom]),
            np.hstack([following, bottom]),
            np.hstack([following, top]),
            np.hstack([ring, top]),
        ],
        axis=1,
    )
    return joined([quads(sides), Mesh(np.hstack([ring, top]), triangulate(ring))])


def flat(outline: Array, height: float = 0.0) -> Mesh:
    """A simple outline `(K, 2)` filled, seen from above."""
    ring = counter_clockwise(np.asarray(outline, dtype=float))
    return Mesh(np.hstack([ring, np.full((len(ring), 1), height)]), triangulate(ring))


def cell_rectangles(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rectangles `(K, 4)` first row, first column, last row + 1, last column + 1 of true cells.

    They cover them exactly and do not overlap.
    """
    edges = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    rows, starts = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    order = np.lexsort((rows, ends, starts))
    rows, starts, ends = rows[order], starts[order], ends[order]
    if not len(rows):
        return np.zeros((0, 4), dtype=np.int64)
    # Equal runs in rows that follow each other are one rectangle.
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (np.diff(rows) != 1) | (np.diff(starts) != 0) | (np.diff(ends) != 0)
    first = np.flatnonzero(new)
    last = np.append(first[1:], len(rows)) - 1
    return np.column_stack([rows[first], starts[first], rows[last] + 1, ends[first]])


def cell_tops(mask: NDArray[np.bool_], cell: float, height: float) -> Mesh:
    """The true cells of a grid from above, in the grid's own frame."""
    r0, c0, r1, c1 = (cell * part for part in cell_rectangles(mask).T)
    z = np.full(len(r0), height)
    corners = [(c0, r0, z), (c1, r0, z), (c1, r1, z), (c0, r1, z)]
    return quads(np.array(corners, dtype=float).transpose(2, 0, 1))


def cell_sides(mask: NDArray[np.bool_], cell: float, low: float, high: float) -> Mesh:
    """The upright faces between true and false cells of a grid, in the grid's own frame."""
    parts = []
    for turned in (False, True):
        grid = mask.T if turned else mask
        steps = np.diff(np.pad(grid.astype(np.int8), ((1, 1), (0, 0))), axis=0)
        for sign in (1, -1):
            along = cell_runs(steps == sign)
            line, first, last = (cell * part for part in along.T)
            # Towards lower rows for the first kind of step, towards higher for the second.
            start, end = (first, last) if (sign == 1) != turned else (last, first)
            bottom, top = np.full(len(line), low), np.full(len(line), high)
            places = [(start, bottom), (end, bottom), (end, top), (start, top)]
            corners = [(line, p, z) if turned else (p, line, z) for p, z in places]
            parts.append(quads(np.array(corners, dtype=float).transpose(2, 0, 1)))
    return joined(parts)


def cell_runs(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Runs `(K, 3)` row, first column, last column + 1 of true cells."""
    edges = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    rows, starts = np.nonzero(edges == 1)
    return np.column_stack([rows, starts, np.nonzero(edges == -1)[1]])


def height_grid(heights: Array, x: Array, y: Array) -> Mesh:
    """A surface over places x `(C,)` and y `(R,)` of heights `(R, C)`."""
    rows, cols = heights.shape
    east, north = np.meshgrid(x, y)
    vertices = np.stack([east, north, heights], axis=-1).reshape(-1, 3)
    index = np.arange(rows * cols).reshape(rows, cols)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:],
                                            index[1:, 1:], index[1:, :-1]))  # fmt: skip
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def box(half: Array | tuple[float, float, float]) -> Mesh:
    """A box around the origin with these half lengths."""
    x, y, z = half
    ring = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    bottom = np.array([[(-x, y, -z), (x, y, -z), (x, -y, -z), (-x, -y, -z)]])
    return joined([prism(ring, -z, z), quads(bottom)])


def turned_profile(profile: Array, corners: int) -> Mesh:
    """What arises when a line `(K, 2)` of radii and heights, upwards, turns about z.

    Edges of the line between equal points stay sharp. Few corners will do: without a graphics
    card each of them counts.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    radius, height = profile.T
    x = radius[:, None] * np.cos(angles)
    y = radius[:, None] * np.sin(angles)
    z = np.broadcast_to(height[:, None], x.shape)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    index = np.arange(len(vertices)).reshape(x.shape)
    index[radius == 0.0] = index[radius == 0.0, :1]  # a pole is one corner
    a, b = index[:-1], np.roll(index[:-1], -1, axis=1)
    d, c = index[1:], np.roll(index[1:], -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    faces = faces[faces[:, 0] != faces[:, 2]]
    # Neither corners nor triangles without use: between equal points, and at poles.
    flat = np.ptp(vertices[faces], axis=1).max(axis=1) < 1e-12
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    flat |= np.linalg.norm(np.cross(b - a, c - a), axis=1) < 1e-15
    used, renumbered = np.unique(faces[~flat], return_inverse=True)
    return Mesh(vertices[used], renumbered.reshape(-1, 3))


def cylinder(radius: float, half: float, corners: int = 8) -> Mesh:
    """A cylinder around the origin along z."""
    line = [(0, -half), (radius, -half), (radius, -half), (radius, half), (radius, half), (0, half)]
    return turned_profile(np.array(line, dtype=float), corners)


def capsule(radius: float, half: float, corners: int = 6, rings: int = 2) -> Mesh:
    """A capsule around the origin along z; `half` is its length without the caps, a sphere's 0."""
    rise = np.linspace(-np.pi / 2.0, 0.0, rings)
    low = np.column_stack([np.cos(rise), np.sin(rise)]) * radius
    low[0, 0] = 0.0
    low[:, 1] -= half
    line = np.concatenate([low, (low * (1.0, -1.0))[::-1]])
    return turned_profile(line if half > 0.0 else np.delete(line, rings, axis=0), corners)


def frame(outer: Array, inner: Array, height: float = 0.0) -> Mesh:
    """The ground between two outlines `(K, 2)` of as many points, seen from above."""
    around, within = np.roll(outer, -1, axis=0), np.roll(inner, -1, axis=0)
    corners = np.stack([outer, around, within, inner], axis=1)
    return quads(np.concatenate([corners, np.full((len(outer), 4, 1), height)], axis=-1))


def ring(radius: float, width: float, corners: int = 40) -> Mesh:
    """A circle of that outer radius, drawn so wide."""
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return frame(radius * circle, (radius - width) * circle)


def star(radius: float, height: float, points: int = 5) -> Mesh:
    """A flat star with its points around z, on the ground."""
    angles = np.pi * np.arange(2 * points) / points
    reach = np.where(np.arange(2 * points) % 2, 0.42 * radius, radius)
    return prism(np.column_stack([reach * np.cos(angles), reach * np.sin(angles)]), 0.0, height)


def body_shape(shape: BodyShape) -> Mesh:
    """A primitive of a robot, in its link's frame."""
    first, second, _ = shape.size
    match shape.kind:
        case "box":
            mesh = box(shape.size)
        case "sphere":
            mesh = capsule(first, 0.0)
        case "capsule":
            mesh = capsule(first, second)
        case "cylinder":
            mesh = cylinder(first, second)
    return Mesh(mesh.vertices @ shape.turn.T + shape.position, mesh.faces)
