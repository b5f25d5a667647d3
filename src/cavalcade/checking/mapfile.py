"""Occupied ground of map files, decoded on its own: squares merged into rectangles.

Nothing of the world package is used, so that a mistake there shows here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from cavalcade.errors import RecordingError
from cavalcade.geometry import Array

_OCCUPIED_FROM = 65
_MAX_CELLS = 64_000_000
_PASSABLE = b".GS"

Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Ground:
    """What a map file says.

    Attributes:
        size: Width and height in m, along the map's own axes.
        origin: Pose (x, y, yaw) of the map's lower left corner in the map frame.
        blocks: `(K, 4)` occupied rectangles x0, y0, x1, y1 in m from that corner, along the
            map's own axes; together exactly the occupied cells.
    """

    size: tuple[float, float]
    origin: tuple[float, float, float]
    blocks: Array = field(default_factory=lambda: np.empty((0, 4)))


def read_ros_map(path: Path, unknown_is_free: bool) -> Ground:
    """The ground of a ROS map_server YAML file and its picture.

    Raises:
        RecordingError: One of the two cannot be read.
    """
    try:
        words = yaml.safe_load(path.read_text(encoding="utf-8"))
        resolution = float(words["resolution"])
        x, y, yaw = (float(value) for value in words["origin"])
        shade, opaque = _read_picture(path.parent / words["image"])
        free = _free_cells(words, shade, opaque, unknown_is_free)
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise RecordingError(f"not a readable map ({error})", file=path) from error
    return _ground(~free[::-1], resolution, (x, y, yaw))


def read_movingai(path: Path, resolution: float) -> Ground:
    """The ground of a MovingAI grid map; its first line is the top row.

    Raises:
        RecordingError: It cannot be read.
    """
    try:
        head, _, body = path.read_bytes().partition(b"map")
        sizes = dict(zip(*[iter(head.split())] * 2, strict=False))
        rows, cols = int(sizes[b"height"]), int(sizes[b"width"])
        lines = [line.strip() for line in body.split(b"\n") if line.strip()][:rows]
        cells = np.frombuffer(b"".join(lines), dtype=np.uint8).reshape(rows, cols)
    except (OSError, ValueError, KeyError) as error:
        raise RecordingError(f"not a readable MovingAI map ({error})", file=path) from error
    passable = np.isin(cells, np.frombuffer(_PASSABLE, dtype=np.uint8))
    return _ground(~passable[::-1], resolution, (0.0, 0.0, 0.0))


def merge_cells(occupied: Bools) -> NDArray[np.int64]:
    """Rectangles `(K, 4)` as row0, col0, row1, col1 (ends beyond) that make up the cells.

    Runs along rows, joined with equal runs in the rows that follow.
    """
    rows, cols = occupied.shape
    edge = np.zeros((rows, cols + 2), dtype=np.int8)
    edge[:, 1:-1] = occupied
    change = np.diff(edge, axis=1)
    row, first = np.nonzero(change == 1)
    last = np.nonzero(change == -1)[1]
    if not len(row):
        return np.empty((0, 4), dtype=np.int64)
    # Equal runs in rows that follow each other become one rectangle.
    order = np.lexsort((row, last, first))
    row, first, last = row[order], first[order], last[order]
    fresh = np.ones(len(row), dtype=bool)
    fresh[1:] = (np.diff(first) != 0) | (np.diff(last) != 0) | (np.diff(row) != 1)
    begin = np.flatnonzero(fresh)
    end = np.append(begin[1:], len(row)) - 1
    return np.stack((row[begin], first[begin], row[end] + 1, last[begin]), axis=1)


def _ground(occupied: Bools, resolution: float, origin: tuple[float, float, float]) -> Ground:
    rows, cols = occupied.shape
    blocks = merge_cells(occupied)[:, [1, 0, 3, 2]].astype(np.float64) * resolution
    return Ground((cols * resolution, rows * resolution), origin, blocks)


def _read_picture(path: Path) -> tuple[NDArray[np.float32], Bools]:
    """Brightness 0 to 1 of every pixel, and whether it is fully opaque."""
    from PIL import Image

    with Image.open(path, formats=["PNG", "PPM"]) as picture:
        if picture.width * picture.height > _MAX_CELLS:
            raise ValueError(f"{picture.width} x {picture.height} cells are too many")
        if picture.mode.startswith("I"):
            deep = np.asarray(picture, dtype=np.int64)
            # Eight bits of it count, as in the other pictures.
            grey = (deep + 128) // 257
            opaque = deep != picture.info.get("transparency", -1)
        else:
            layers = picture.convert("RGBA")
            grey = np.asarray(layers.convert("RGB").convert("L"), dtype=np.int64)
            opaque = np.asarray(layers.getchannel("A")) == 255
    return (grey / np.float32(255.0)).astype(np.float32), opaque


def _free_cells(
    words: dict[str, Any], shade: NDArray[np.float32], opaque: Bools, unknown_is_free: bool
) -> Bools:
    """Which pixels count as free, by the rules of Nav2's map server."""
    mode = str(words.get("mode") or "trinary").lower()
    if mode == "raw":
        value = np.rint(shade * 255.0)
        known, free = value <= 100, value < _OCCUPIED_FROM
        return np.where(known, free, unknown_is_free)
    occupancy = shade if words.get("negate") else np.float32(1.0) - shade
    low, high = np.float32(words["free_thresh"]), np.float32(words["occupied_thresh"])
    below = occupancy < high
    free = below & (occupancy <= low)
    between = below & ~free
    if mode == "scale":
        # Where the two are equal, nothing lies between them.
        span = max(high - low, np.float32(1e-9))
        share = np.floor((occupancy - low) / span * np.float32(100.0) + np.float32(0.5))
        free = free | between & (share < _OCCUPIED_FROM)
        known = opaque
    else:
        known = opaque & ~between
    return np.where(known, free, unknown_is_free)
