"""Triangle meshes: STL and PLY, text and binary, and their surface seen from above.

Read here and not by trimesh (5.2 was tried). Of PLY that one refuses binary files whose faces
differ in their number of corners or that hold lists besides, reads damaged ones as if they were
whole (a list's length, a corner that is no whole number or below 0), brings text to single
precision and turns the corners of quadrangles round; of STL it finds nothing in files with
something behind the last facet, or cut off before their `endsolid`.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from cavalcade.errors import MapError
from cavalcade.files import read_bytes
from cavalcade.geometry import Array
from cavalcade.world.terrain._mesh_raster import covered_cells, highest_surface
from cavalcade.world.terrain.ply import parse_ply
from cavalcade.world.terrain.samples import Samples
from cavalcade.world.terrain.terrain import MAX_HEIGHT, check_terrain_size

MAX_BYTES = 256_000_000
"""Largest mesh file that is read: some 5 million triangles."""

_MAX_WORK = 2e9
"""Cells that all triangles' rectangles may cover together, one by one: some seconds."""

_MAX_EXTENT = 1e6
_HEADER, _FACET = 84, 50


def read_mesh(path: Path, cell: float, scale: float = 1.0) -> Samples:
    """The highest surface of a mesh over the cells' centres; nan where there is none.

    The grid's lower-left corner is that of the mesh.

    Args:
        path: STL or PLY file; x, y and z are metres times `scale`, z up.
        cell: Side of the cells, m.
        scale: Metres of one unit of the file.

    Raises:
        MapError: Not such a file, damaged, empty or too large.
    """
    triangles = parse_mesh(read_bytes(path, MAX_BYTES)) * scale
    if not len(triangles):
        raise MapError("there is no triangle in the mesh")
    if not np.isfinite(triangles).all():
        raise MapError("a corner of the mesh is not finite")
    flat = triangles.reshape(-1, 3)
    low, high = flat.min(axis=0), flat.max(axis=0)
    if max(np.abs(low[:2]).max(), np.abs(high[:2]).max()) > _MAX_EXTENT:
        raise MapError(f"expected a mesh within ±{_MAX_EXTENT:g} m")
    if max(abs(low[2]), abs(high[2])) > MAX_HEIGHT:
        raise MapError(f"expected heights within ±{MAX_HEIGHT:g} m")
    cols, rows = (math.floor(side / cell + 1e-6) for side in (high - low)[:2])
    check_terrain_size(rows, cols, "mesh")
    triangles[..., :2] -= low[:2]
    if covered_cells(triangles, cell, rows, cols) > _MAX_WORK:
        raise MapError("the mesh lies over itself too many times")
    heights = highest_surface(triangles, cell, rows, cols)
    return Samples(heights, cell, (float(low[0]), float(low[1])))


def parse_mesh(content: bytes) -> Array:
    """The triangles `(N, 3, 3)` of an STL or PLY file.

    Raises:
        MapError: Neither, or damaged.
    """
    if content.startswith((b"ply\n", b"ply\r")):
        return parse_ply(content)
    # Some binary files begin with `solid`, too: only their length tells.
    if len(content) >= _HEADER:
        count = int.from_bytes(content[80:84], "little")
        if len(content) == _HEADER + _FACET * count or not content.lstrip().startswith(b"solid"):
            return _binary_stl(content, count)
    if content.lstrip().startswith(b"solid"):
        return _text_stl(content)
    raise MapError("expected a mesh: STL or PLY")


def _binary_stl(content: bytes, count: int) -> Array:
    if len(content) < _HEADER + _FACET * count:
        raise MapError(
            f"expected an STL mesh of {count} triangles, {_HEADER + _FACET * count} bytes; "
            f"it has {len(content)}"
        )
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("flags", "<u2")])
    facets = np.frombuffer(content, dtype=facet, count=count, offset=_HEADER)
    return facets["corners"].astype(np.float64)


def _text_stl(content: bytes) -> Array:
    words = content.split()
    try:
        corners = [
            [float(words[k + 1]), float(words[k + 2]), float(words[k + 3])]
            for k, word in enumerate(words)
            if word == b"vertex"
        ]
    except (ValueError, IndexError):
        raise MapError("expected three numbers after each `vertex` of the STL mesh") from None
    if len(corners) % 3:
        raise MapError("a facet of the STL mesh has not three corners")
    return np.array(corners, dtype=np.float64).reshape(-1, 3, 3)
