"""Formats of maps and worlds of others, read; ROS maps have a file of their own, `ros_map`.

Fields of BARN (Perille et al., SSRR 2020) are lists of circles; grid maps of the MovingAI
benchmarks (Sturtevant, 2012) are text, one letter per cell.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cavalcade.errors import InputError, MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.geometry import Array
from cavalcade.world.occupancy import MAX_EXTENT, OccupancyMap, check_cell_count
from cavalcade.world.shapes import Circle

_BARN_HEADER = "x_m,y_m,radius_m"
_MAX_BYTES = 1_000_000

_FREE = b".GS"
"""Ground, ground, shallow water: passable."""

_BLOCKED = b"@OTW"
"""Out of bounds, out of bounds, trees, deep water: not passable."""

_MOVINGAI_HEADER = re.compile(
    rb"type[ \t]+\w+\s+height[ \t]+(\d{1,9})\s+width[ \t]+(\d{1,9})\s+map[ \t]*\r?\n"
)
_MOVINGAI_HEADER_BYTES = 1024


@dataclass(frozen=True)
class BarnWorld:
    """A field of cylinders whose lower-left corner is (0, 0).

    Attributes:
        circles: The cylinders seen from above, m.
        size: Width and height in m of the smallest field that holds them all, with the ground
            added beyond.
        offset: Where (0, 0) lies in the file's own frame, m.
    """

    circles: tuple[Circle, ...]
    size: tuple[float, float]
    offset: tuple[float, float]

    def to_map(self, resolution: float = 0.05) -> OccupancyMap:
        """The field as an occupancy map."""
        return OccupancyMap.empty(self.size, resolution).with_shapes(self.circles)


def load_barn(path: str | Path, beyond: float = 0.0) -> BarnWorld:
    """Read a circle list: lines of x, y, radius in m, after a line that names them.

    The fields of the data set are walled in on the left, on the right and at the bottom; the
    robot crosses from the bottom to the open top.

    Args:
        beyond: Free ground that is added at the top, m.

    Raises:
        MapError: Not such a file; the message names the line.
    """
    path = Path(path)
    if not (math.isfinite(beyond) and 0.0 <= beyond <= MAX_EXTENT):
        raise MapError("expected a length that is not negative", key="beyond")
    table = _circles(path)
    low = (table[:, :2] - table[:, 2:]).min(axis=0)
    high = (table[:, :2] + table[:, 2:]).max(axis=0)
    # The files give micrometres; what lies beyond is rounding.
    low, high = np.round(low, 6), np.round(high, 6)
    circles = []
    for number, (x, y, radius) in enumerate(table, start=2):
        try:
            circles.append(Circle((round(x - low[0], 9), round(y - low[1], 9)), radius))
        except InputError as error:
            raise MapError(str(error), file=path, key=f"line {number}") from None
    width, height = (round(float(side), 6) for side in high - low + (0.0, beyond))
    return BarnWorld(tuple(circles), (width, height), (float(low[0]), float(low[1])))


def _circles(path: Path) -> Array:
    """The numbers `(N, 3)`, finite, N at least 1."""
    try:
        lines = read_bytes(path, _MAX_BYTES).decode("ascii").splitlines()
    except UnicodeDecodeError:
        raise MapError("expected a text file of circles", file=path) from None
    if not lines or lines[0].replace(" ", "") != _BARN_HEADER:
        raise MapError(f"expected the first line {_BARN_HEADER!r}", file=path, key="line 1")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = [float(part) for part in line.split(",")]
        except ValueError:
            row = []
        if len(row) != 3 or not np.isfinite(row).all():
            raise MapError("expected three numbers: x,y,radius", file=path, key=f"line {number}")
        rows.append(row)
    if not rows:
        raise MapError("there is no circle in the list", file=path)
    return np.array(rows)


def load_movingai(path: str | Path, resolution: float) -> OccupancyMap:
    """Read a `.map` file; its lower-left corner becomes (0, 0).

    The file's first line is the top of the map.

    Args:
        resolution: Side of a cell in m; the files have no unit.

    Raises:
        MapError: Not such a file, truncated, too large, or an unknown letter.
    """
    path = Path(path)
    head = read_head(path, _MOVINGAI_HEADER_BYTES)
    header = _MOVINGAI_HEADER.match(head)
    if header is None:
        expected = "type octile, height, width, map"
        raise MapError(f"expected a MovingAI map with the lines {expected}", file=path)
    height, width = (int(part) for part in header.groups())
    check_cell_count(height, width, file=str(path), key="height, width")
    content = read_bytes(path, _MOVINGAI_HEADER_BYTES + (width + 2) * (height + 64))
    lines = content[header.end() :].splitlines()[:height]
    if len(lines) < height:
        raise MapError(f"the map is truncated: {len(lines)} of {height} lines", file=path)
    passable = np.zeros(256, dtype=bool)
    passable[list(_FREE)] = True
    grid = np.empty((height, width), dtype=bool)
    for row, line in enumerate(lines):
        place = f"map line {row + 1}"
        if len(line) != width:
            raise MapError(f"{len(line)} cells instead of {width}", file=path, key=place)
        unknown = line.translate(None, _FREE + _BLOCKED)
        if unknown:
            letter = chr(unknown[0])
            raise MapError(f"unknown letter {letter!r}, expected .GS@OTW", file=path, key=place)
        grid[height - 1 - row] = ~passable[np.frombuffer(line, dtype=np.uint8)]
    return OccupancyMap(grid, resolution)
