"""Worlds of the BARN data set (Perille et al., SSRR 2020) as lists of circles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cavalcade.errors import InputError, MapError
from cavalcade.files import read_bytes
from cavalcade.geometry import Array
from cavalcade.world.occupancy import MAX_EXTENT, OccupancyMap
from cavalcade.world.shapes import Circle

_HEADER = "x_m,y_m,radius_m"
_MAX_BYTES = 1_000_000


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
    table = _read_table(path)
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


def _read_table(path: Path) -> Array:
    """The numbers `(N, 3)`, finite, N at least 1."""
    try:
        lines = read_bytes(path, _MAX_BYTES).decode("ascii").splitlines()
    except UnicodeDecodeError:
        raise MapError("expected a text file of circles", file=path) from None
    if not lines or lines[0].replace(" ", "") != _HEADER:
        raise MapError(f"expected the first line {_HEADER!r}", file=path, key="line 1")
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
