"""Triangle meshes: STL and PLY, text and binary, and their surface seen from above.

Read here and not by trimesh (5.2 was tried). Of PLY that one refuses binary files whose faces
differ in their number of corners or that hold lists besides, reads damaged ones as if they were
whole (a list's length, a corner that is no whole number or below 0), brings text to single
precision and turns the corners of quadrangles round; of STL it finds nothing in files with
something behind the last facet, or cut off before their `endsolid`.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from cavalcade.errors import MapError
from cavalcade.files import read_bytes
from cavalcade.geometry import Array
from cavalcade.kernels import kernel, subroutine
from cavalcade.world.terrain.ply import parse_ply
from cavalcade.world.terrain.samples import Samples
from cavalcade.world.terrain.terrain import MAX_HEIGHT, check_terrain_size

MAX_BYTES = 256_000_000
"""Largest mesh file that is read: some 5 million triangles."""

_MAX_WORK = 2e9
"""Cells that all triangles' rectangles may cover together, one by one: some seconds."""

_MAX_EXTENT = 1e6
_HEADER, _FACET = 84, 50
_PLY, _BOM = (b"ply\n", b"ply\r"), b"\xef\xbb\xbf"

_NAME = re.compile(rb"^[ \t]*(?:end)?solid\b[^\n]*?(?=\bfacet\s+normal\s+[-+.\d]|$)", re.MULTILINE)
"""`solid` with a name, up to the end of the line or the first facet."""


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
    if content.startswith(_PLY):
        return parse_ply(content)
    # Some binary files begin with `solid`, too: only their length tells.
    if len(content) >= _HEADER:
        count = int.from_bytes(content[80:84], "little")
        if len(content) == _HEADER + _FACET * count or not is_mesh(content):
            return _binary_stl(content, count)
    if is_mesh(content):
        return _text_stl(content)
    raise MapError("expected a mesh: STL or PLY")


def is_mesh(content: bytes) -> bool:
    """Whether this is the beginning of a PLY file or of an STL file in text."""
    beginning = content[:512].removeprefix(_BOM).lstrip()[:5].lower()
    return content.startswith(_PLY) or beginning == b"solid"


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
    """Words in any case; what follows `solid` and `endsolid` in their lines is a name."""
    text = content.removeprefix(_BOM).replace(b"\r", b"\n").lower()
    words = _NAME.sub(b" ", text).split()
    corners: list[list[float]] = []
    begun = 0  # corners before this facet
    for k, word in enumerate([*words, b"facet"]):
        if word == b"vertex":
            try:
                corners.append([float(number) for number in words[k + 1 : k + 4]])
            except ValueError:
                corners.append([])
            if len(corners[-1]) != 3:
                raise MapError("expected three numbers after each `vertex` of the STL mesh")
        elif word == b"facet":
            if len(corners) not in (begun + 3, 0):
                raise MapError("a facet of the STL mesh has not three corners")
            begun = len(corners)
    return np.array(corners, dtype=np.float64).reshape(-1, 3, 3)


@kernel
def covered_cells(triangles: Array, cell: float, rows: int, cols: int) -> float:
    """How many cells the triangles' bounding rectangles cover together, one by one.

    Their corners `(N, 3, 3)` are x, y, z in m, seen from the grid's lower-left corner.
    """
    total = 0.0
    for k in range(triangles.shape[0]):
        r0, r1, c0, c1 = _window(triangles[k], cell, rows, cols)
        total += max(r1 - r0, 0) * max(c1 - c0, 0)
    return total


@subroutine
def _window(corners: Array, cell: float, rows: int, cols: int) -> tuple[int, int, int, int]:
    """Half-open rows and columns of the cells whose centres a triangle's rectangle holds."""
    x0 = min(corners[0, 0], corners[1, 0], corners[2, 0])
    x1 = max(corners[0, 0], corners[1, 0], corners[2, 0])
    y0 = min(corners[0, 1], corners[1, 1], corners[2, 1])
    y1 = max(corners[0, 1], corners[1, 1], corners[2, 1])
    slack = 1e-6
    c0 = max(int(math.ceil(x0 / cell - 0.5 - slack)), 0)
    c1 = min(int(math.floor(x1 / cell - 0.5 + slack)) + 1, cols)
    r0 = max(int(math.ceil(y0 / cell - 0.5 - slack)), 0)
    r1 = min(int(math.floor(y1 / cell - 0.5 + slack)) + 1, rows)
    return r0, r1, c0, c1


@kernel
def highest_surface(triangles: Array, cell: float, rows: int, cols: int) -> Array:
    """Heights `(rows, cols)` m of the highest triangle over each centre; nan where there is none.

    Upright triangles have no surface seen from above and are left out.
    """
    out = np.full((rows, cols), np.nan)
    for k in range(triangles.shape[0]):
        corners = triangles[k]
        r0, r1, c0, c1 = _window(corners, cell, rows, cols)
        if r0 >= r1 or c0 >= c1:
            continue
        ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
        ux, uy, uz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
        vx, vy, vz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
        area = ux * vy - uy * vx
        longest = max(abs(ux), abs(uy), abs(vx), abs(vy))
        if abs(area) <= 1e-12 * longest * longest:
            continue
        for row in range(r0, r1):
            for col in range(c0, c1):
                px, py = (col + 0.5) * cell - ax, (row + 0.5) * cell - ay
                s = (px * vy - py * vx) / area
                t = (ux * py - uy * px) / area
                # Centres on an edge belong to both triangles: rounding must not leave cracks.
                if s >= -1e-9 and t >= -1e-9 and s + t <= 1.0 + 1e-9:
                    z = az + s * uz + t * vz
                    if not out[row, col] >= z:
                        out[row, col] = z
    return out
