"""The ground as body planners' kernels take it: solid obstacles, heights, traversability.

Everything is in the grid's own frame: x, y in m from the lower-left corner of cell [0, 0].
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.lattice.outlines import NO_OUTLINES, Outlines, outlines_of
from cavalcade.values import instance_of, number_in
from cavalcade.world import OccupancyMap, Shape, Terrain


class Ground(NamedTuple):
    """Arrays on one grid, `[row, col]` = `[y, x]`; a value stands at its cell's centre.

    Attributes:
        cell: Side of a cell, m.
        solid: `(rows, cols)` obstacles of unlimited height; all beyond the grid is one, too.
        clearance: `(rows, cols)` from the cell's centre to the nearest solid's surface, m.
        flat: No heights: the five arrays below are `(1, 1)` and of no interest.
        height: `(rows, cols)` of the ground, m.
        smooth: `(rows, cols)` smoothed height, which the body follows, m.
        slope_x, slope_y: `(rows, cols)` derivatives of `smooth`.
        traversability: `(rows, cols)` 0 (no foot may stand) to 1.
        outlines: Where the obstacles in `solid` cells really end, as far as that is known.
    """

    cell: float
    solid: NDArray[np.bool_]
    clearance: Array
    flat: bool
    height: Array
    smooth: Array
    slope_x: Array
    slope_y: Array
    traversability: Array
    outlines: Outlines = NO_OUTLINES


def make_ground(
    map: OccupancyMap, terrain: Terrain | None = None, shapes: Sequence[Shape] = ()
) -> Ground:
    """The ground of a world: what is solid, and heights on the same grid unless it is flat.

    Obstacles among the map's cells are known as squares, `shapes` (map frame) as what they are.
    """
    instance_of(map, OccupancyMap, "map")
    solid = np.ascontiguousarray(map.with_shapes(shapes).occupied)
    outlines = NO_OUTLINES
    if shapes:
        outlines, clearance = outlines_of(shapes, map.origin, map.resolution, solid, map.occupied)
    else:
        clearance = np.ascontiguousarray(surface_distance(solid, map.resolution))
    if terrain is None:
        none = np.zeros((1, 1))
        one = np.ones((1, 1))
        return Ground(map.resolution, solid, clearance, True, none, none, none, none, one, outlines)
    instance_of(terrain, Terrain, "terrain")
    if terrain.height.shape != solid.shape:
        raise InputError(
            f"expected {solid.shape} cells as the map has, got {terrain.height.shape}",
            key="terrain",
        )
    normal_z = np.maximum(terrain.normals[..., 2], 1e-6)
    return Ground(
        map.resolution,
        solid,
        clearance,
        False,
        np.ascontiguousarray(terrain.height),
        np.ascontiguousarray(terrain.smooth),
        np.ascontiguousarray(-terrain.normals[..., 0] / normal_z),
        np.ascontiguousarray(-terrain.normals[..., 1] / normal_z),
        np.ascontiguousarray(terrain.traversability),
        outlines,
    )


def check_ground(ground: Ground) -> None:
    """Refuse what kernels cannot take; what `make_ground` makes passes.

    Raises:
        InputError: One line with the name of the part.
    """
    instance_of(ground, Ground, "ground", "a Ground, see make_ground")
    number_in(ground.cell, "ground.cell", 1e-4, 1e4, "m")
    instance_of(ground.flat, bool, "ground.flat", "True or False")
    instance_of(ground.outlines, Outlines, "ground.outlines")
    shape = np.shape(ground.solid)
    value: Any
    for name, value in zip(ground._fields, ground, strict=True):
        if name in ("cell", "flat", "outlines"):
            continue
        wanted = shape if name in ("solid", "clearance") or not ground.flat else (1, 1)
        kind = np.bool_ if name == "solid" else np.float64
        right = type(value) is np.ndarray and value.dtype == kind and value.flags.c_contiguous
        if not right or value.ndim != 2 or value.shape != wanted or not value.size:
            raise InputError(f"expected an array {wanted} of {kind.__name__}", key=f"ground.{name}")
        if np.isnan(value).any():
            raise InputError("expected numbers, not nan", key=f"ground.{name}")


def read_only(ground: Ground) -> Ground:
    """The same ground; its arrays are of one type for all grounds, so kernels compile once."""
    return ground._replace(**_views(ground), outlines=Outlines(**_views(ground.outlines)))


def _views(record: Ground | Outlines) -> dict[str, Any]:
    """Read-only views of a record's arrays, by name."""
    arrays: dict[str, Any] = {}
    for name, value in zip(record._fields, record, strict=True):
        if isinstance(value, np.ndarray):
            arrays[name] = value.view()
            arrays[name].setflags(write=False)
    return arrays
