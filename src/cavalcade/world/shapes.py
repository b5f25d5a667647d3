"""Obstacles as exact planar shapes, also in the words of a scenario file. Metres, radians.

Box, circle and polygon are the truth about an obstacle, all in one common frame; grids are made
from them (`raster.py`). Distances are measured to the surface and are 0 inside.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.geometry import Array, inverse_transform_points, polygons, rectangle_corners
from cavalcade.values import number_array, plain_number, points_of

MAX_COORDINATE = 1e6
"""Largest coordinate or length of a shape, m; beyond it arithmetic loses the millimetres."""

MIN_LENGTH = 1e-6
"""Smallest side or radius of a shape, m: well above the tolerance of the raster."""

MAX_VERTICES = 10_000

Bounds = tuple[float, float, float, float]
"""x_min, y_min, x_max, y_max in m."""


@dataclass(frozen=True)
class Box:
    """A rectangle at any angle.

    Args:
        center: x, y of its centre, m.
        size: Lengths along its own x and y axis, m, both positive.
        yaw: Angle of its x axis, rad, counter-clockwise.

    Raises:
        InputError: A value is not finite, too large, or a side is not positive.
    """

    center: tuple[float, float]
    size: tuple[float, float]
    yaw: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", _pair(self.center, "box.center"))
        object.__setattr__(self, "size", _pair(self.size, "box.size"))
        object.__setattr__(self, "yaw", _number(self.yaw, "box.yaw"))
        if min(self.size) < MIN_LENGTH:
            raise InputError(f"both sides must be at least {MIN_LENGTH:g} m", key="box.size")

    @property
    def corners(self) -> Array:
        """Corners `(4, 2)`, m, counter-clockwise."""
        return rectangle_corners((*self.center, self.yaw), *self.size)

    @property
    def bounds(self) -> Bounds:
        """The smallest axis-parallel rectangle around it."""
        return _bounds_of(self.corners)

    def moved(self, offset: ArrayLike) -> Box:
        """The same box, displaced by `offset` `(2,)` m."""
        return replace(self, center=_displaced(self.center, offset))

    def distance(self, points: ArrayLike) -> Array:
        """Distance in m of points `(N, 2)` to the box, `(N,)`, 0 inside."""
        local = inverse_transform_points((*self.center, self.yaw), _points(points))
        beyond = np.maximum(np.abs(local) - np.array(self.size) / 2.0, 0.0)
        return np.hypot(beyond[:, 0], beyond[:, 1])


@dataclass(frozen=True)
class Circle:
    """A disc.

    Args:
        center: x, y of its centre, m.
        radius: m, positive.

    Raises:
        InputError: A value is not finite, too large, or the radius is not positive.
    """

    center: tuple[float, float]
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", _pair(self.center, "circle.center"))
        object.__setattr__(self, "radius", _number(self.radius, "circle.radius"))
        if self.radius < MIN_LENGTH:
            raise InputError(f"must be at least {MIN_LENGTH:g} m", key="circle.radius")

    @property
    def bounds(self) -> Bounds:
        """The smallest axis-parallel rectangle around it."""
        (x, y), r = self.center, self.radius
        return (x - r, y - r, x + r, y + r)

    def moved(self, offset: ArrayLike) -> Circle:
        """The same disc, displaced by `offset` `(2,)` m."""
        return replace(self, center=_displaced(self.center, offset))

    def distance(self, points: ArrayLike) -> Array:
        """Distance in m of points `(N, 2)` to the disc, `(N,)`, 0 inside."""
        away = _points(points) - self.center
        return np.maximum(np.hypot(away[:, 0], away[:, 1]) - self.radius, 0.0)


@dataclass(frozen=True)
class Polygon:
    """A simple polygon, convex or not; its inside belongs to it.

    Args:
        points: Vertices x, y in m, in order, either way round; a last vertex equal to the first
            is dropped.

    Raises:
        InputError: Fewer than three vertices, a value that is not finite, edges that touch or
            cross each other, or no area.
    """

    points: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        key = "polygon.points"
        try:
            count = len(self.points)
        except TypeError:
            raise InputError("expected a list of [x, y]", key=key) from None
        if count > MAX_VERTICES:
            raise InputError(f"has {count} vertices, at most {MAX_VERTICES} are allowed", key=key)
        points = [_pair(point, f"{key}[{i}]") for i, point in enumerate(self.points)]
        if len(points) > 1 and points[0] == points[-1]:
            points.pop()
        object.__setattr__(self, "points", tuple(points))
        if len(points) < 3:
            raise InputError("at least three different vertices are needed", key=key)
        crossing = polygons.first_crossing(self.vertices)
        if crossing is not None:
            raise InputError(
                f"edges {crossing[0]} and {crossing[1]} touch or cross each other", key=key
            )
        if abs(polygons.signed_area(self.vertices)) < MIN_LENGTH**2:
            raise InputError("the polygon has no area", key=key)

    @property
    def vertices(self) -> Array:
        """Vertices `(V, 2)`, m, as given."""
        return np.array(self.points)

    @property
    def bounds(self) -> Bounds:
        """The smallest axis-parallel rectangle around it."""
        return _bounds_of(self.vertices)

    def moved(self, offset: ArrayLike) -> Polygon:
        """The same polygon, displaced by `offset` `(2,)` m."""
        # Not checked anew: rounding must not turn a polygon that was accepted into an error.
        polygon = object.__new__(Polygon)
        moved = tuple(_displaced(point, offset) for point in self.points)
        object.__setattr__(polygon, "points", moved)
        return polygon

    def distance(self, points: ArrayLike) -> Array:
        """Distance in m of points `(N, 2)` to the polygon, `(N,)`, 0 inside."""
        return polygons.distance(self.vertices, _points(points))


Shape = Box | Circle | Polygon


def distance_to_shapes(shapes: Sequence[Shape], points: ArrayLike) -> Array:
    """Distance in m of points `(N, 2)` to the nearest of the shapes, `(N,)`; inf without any."""
    checked = _points(points)
    nearest = np.full(len(checked), np.inf)
    for shape in shapes:
        np.minimum(nearest, shape.distance(checked), out=nearest)
    return nearest


_KINDS: Mapping[str, type[Shape]] = {"box": Box, "circle": Circle, "polygon": Polygon}


def shape_from_mapping(mapping: Mapping[str, Any]) -> Shape:
    """A shape from `{"box": {...}}`, `{"circle": {...}}` or `{"polygon": {...}}`.

    Raises:
        InputError: Unknown kind, a missing or unknown key, or a value the shape refuses; the key
            says which.
    """
    if not isinstance(mapping, Mapping) or len(mapping) != 1:
        raise InputError("expected one shape, such as {circle: ...}", choices=_KINDS)
    kind, values = next(iter(mapping.items()))
    if kind not in _KINDS:
        raise InputError(f"unknown shape {str(kind)[:40]!r}", choices=_KINDS)
    if not isinstance(values, Mapping):
        raise InputError("expected a mapping", key=kind)
    known = {field.name: field.default for field in fields(_KINDS[kind])}
    for name, default in known.items():
        if default is MISSING and name not in values:
            raise InputError("is missing", key=f"{kind}.{name}")
    for name in values:
        if name not in known:
            raise InputError("unknown key", key=f"{kind}.{str(name)[:40]}", choices=known)
    return _KINDS[kind](**values)


def shape_to_mapping(shape: Shape) -> dict[str, dict[str, Any]]:
    """The mapping of plain lists and floats that `shape_from_mapping` turns back into `shape`."""
    if isinstance(shape, Polygon):
        return {"polygon": {"points": [list(point) for point in shape.points]}}
    if isinstance(shape, Circle):
        return {"circle": {"center": list(shape.center), "radius": shape.radius}}
    return {"box": {"center": list(shape.center), "size": list(shape.size), "yaw": shape.yaw}}


def _number(value: object, key: str) -> float:
    """`value` as a finite float of sensible size."""
    number = plain_number(value, key)
    if not math.isfinite(number) or abs(number) > MAX_COORDINATE:
        raise InputError(f"expected a finite number within ±{MAX_COORDINATE:g}", key=key)
    return number


def _pair(value: Any, key: str) -> tuple[float, float]:
    """`value` as a pair of finite floats."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise InputError("expected two numbers", key=key)
    return _number(value[0], key), _number(value[1], key)


def _displaced(point: tuple[float, float], offset: ArrayLike) -> tuple[float, float]:
    dx, dy = number_array(offset, "offset", (2,), "(2,) m").tolist()
    return point[0] + dx, point[1] + dy


def _points(points: ArrayLike) -> Array:
    """Points as a finite float array `(N, 2)`."""
    return points_of(points, 1e150)


def _bounds_of(points: Array) -> Bounds:
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return (float(x0), float(y0), float(x1), float(y1))
