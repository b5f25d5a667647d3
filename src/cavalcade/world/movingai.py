"""Grid maps of the MovingAI benchmarks (Sturtevant, 2012): text, one letter per cell."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from cavalcade.errors import MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.world.occupancy import OccupancyMap, check_cell_count

_FREE = b".GS"
"""Ground, ground, shallow water: passable."""

_BLOCKED = b"@OTW"
"""Out of bounds, out of bounds, trees, deep water: not passable."""

_HEADER = re.compile(
    rb"type[ \t]+\w+\s+height[ \t]+(\d{1,9})\s+width[ \t]+(\d{1,9})\s+map[ \t]*\r?\n"
)
_HEADER_BYTES = 1024


def load_movingai(path: str | Path, resolution: float) -> OccupancyMap:
    """Read a `.map` file; its lower-left corner becomes (0, 0).

    The file's first line is the top of the map.

    Args:
        resolution: Side of a cell in m; the files have no unit.

    Raises:
        MapError: Not such a file, truncated, too large, or an unknown letter.
    """
    path = Path(path)
    head = read_head(path, _HEADER_BYTES)
    header = _HEADER.match(head)
    if header is None:
        expected = "type octile, height, width, map"
        raise MapError(f"expected a MovingAI map with the lines {expected}", file=path)
    height, width = (int(part) for part in header.groups())
    check_cell_count(height, width, file=str(path), key="height, width")
    content = read_bytes(path, _HEADER_BYTES + (width + 2) * (height + 64))
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
