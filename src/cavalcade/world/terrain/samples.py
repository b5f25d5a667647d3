"""Heights as files give them (pictures, tables, archives), brought to a terrain's grid."""

from __future__ import annotations

import io
import math
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.geometry import Array
from cavalcade.kernels import kernel
from cavalcade.world._images import (
    decode_deep_colours,
    decode_png,
    has_deep_colours,
    png_size,
)
from cavalcade.world.terrain.filters import filled
from cavalcade.world.terrain.terrain import check_terrain_size, checked_heights, sample

MAX_SAMPLES = 16_000_000
"""Most heights that are read from a file."""

MAX_BYTES = 128_000_000
"""Largest file that is read."""

_EVEN = 1e-3
"""Distances of samples may differ by this share of themselves."""

_NAMES = ("height", "elevation", "z")

_USUAL_NODATA = (-9999.0, -99999.0, -32767.0, -32768.0, 32767.0, -3.4028235e38, 3.4028235e38)
"""What tools for maps of the earth write where they have no height."""


@dataclass(frozen=True)
class Samples:
    """Heights at even distances.

    Attributes:
        heights: `(rows, cols)` m, row 0 at the lowest y; nan in holes.
        step: Distance of two neighbours, m; None if the file does not say.
        corner: x, y in m of the lower-left corner of the ground; None if the file does not say.
        cells: Whether each height stands for a cell around it (as the pixels of a picture do);
            otherwise the ground ends at the outermost ones.
    """

    heights: Array
    step: float | None = None
    corner: tuple[float, float] | None = None
    cells: bool = True


def check_sample_count(rows: int, cols: int) -> None:
    """Refuse files with too many heights before memory is taken for them."""
    if rows * cols > MAX_SAMPLES:
        raise MapError(
            f"{rows} x {cols} heights are too many, at most {MAX_SAMPLES / 1e6:g} million are read"
        )


def to_grid(samples: Samples, cell: float, holes: bool = True) -> Array:
    """Heights `(rows, cols)` on cells of side `cell`; nan in holes unless they are to be filled.

    Finer samples are averaged first, then values are taken bilinearly; a cell is a hole where
    holes weigh half or more.

    Raises:
        MapError: Too few, too many or no heights, or no `step`.
    """
    heights = checked_heights(samples.heights)
    if samples.step is None:
        raise MapError("is missing", key="resolution")
    step = samples.step
    unknown = np.isnan(heights)
    if samples.cells and abs(step - cell) <= 1e-9 * cell:
        check_terrain_size(*heights.shape)
        return heights if holes else filled(heights, unknown)
    last = 0 if samples.cells else 1
    width, length = (step * (count - last) for count in heights.shape[::-1])
    rows, cols = (math.floor(side / cell + 1e-6) for side in (length, width))
    check_terrain_size(rows, cols)
    low = 0.0  # of the ground, seen from the first sample or block
    solid = filled(heights, unknown)
    weight = unknown.astype(float)
    block = math.floor(cell / step + 1e-9)
    if block >= 2 and min(heights.shape) >= block:
        solid, weight = block_means(solid, block), block_means(weight, block)
        low = -0.5 * (block - 1) * step
        step *= block
    if samples.cells:
        low -= 0.5 * samples.step
    out = np.empty((rows, cols))
    resample(solid, step, out, cell, low, low)
    if holes and unknown.any():
        share = np.empty((rows, cols))
        resample(weight, step, share, cell, low, low)
        out[share >= 0.5] = np.nan
        if np.isnan(out).all():
            raise MapError("expected at least one height; all are nan", key="heights")
    return out


@kernel
def resample(field: Array, step: float, out: Array, cell: float, x0: float, y0: float) -> None:
    """Fill `out` `(rows, cols)` of cells `cell` from a grid of samples `step` apart.

    Sample [0, 0] stands at (0, 0), not at a cell's centre; the lower-left corner of cell [0, 0]
    lies at (x0, y0), m.
    """
    for row in range(out.shape[0]):
        for col in range(out.shape[1]):
            x = x0 + (col + 0.5) * cell
            y = y0 + (row + 0.5) * cell
            out[row, col] = sample(field, step, x + 0.5 * step, y + 0.5 * step)


def block_means(field: Array, size: int) -> Array:
    """Means of whole blocks of `size` x `size` values; nan where one is."""
    rows, cols = (count // size for count in field.shape)
    total = np.zeros((rows, cols))
    for i in range(size):
        for j in range(size):
            total += field[i : rows * size : size, j : cols * size : size]
    return total / (size * size)


def read_picture(path: Path, nodata: float | None = None) -> Samples:
    """Brightness 0 (black) to 1 (white) of a PNG of 8 or 16 bits; nan where it is transparent.

    Args:
        path: The picture.
        nodata: Grey, 0 to 255 or 65535, that stands for missing heights.

    Raises:
        MapError: Not such a picture, damaged or too large.
    """
    head = read_head(path, 64)
    width, height = png_size(head, path)
    check_sample_count(height, width)
    content = read_bytes(path, 16 * width * height + 1_000_000)
    values: Array
    if has_deep_colours(head):
        values, missing = decode_deep_colours(content, path)
        white = 65535
    else:
        grey, alpha = decode_png(content, path)
        values, white = grey.astype(np.float64), int(np.iinfo(grey.dtype).max)
        missing = np.zeros(grey.shape, bool) if alpha is None else alpha < 128
    if nodata is not None:
        missing |= _equal(values, nodata)
    heights = values / white
    heights[missing] = np.nan
    return Samples(heights[::-1])


def without(samples: Samples, nodata: float | None) -> Samples:
    """The same heights, nan where they are `nodata`; None if no number says that."""
    if nodata is None:
        return samples
    missing = _equal(samples.heights, nodata)
    return replace(samples, heights=np.where(missing, np.nan, samples.heights))


def _equal(values: Array, nodata: float) -> NDArray[np.bool_]:
    """Where values are a number, but for the digits that a text or single precision cuts off."""
    equal: NDArray[np.bool_] = np.abs(values - nodata) <= 1e-6 * abs(nodata)
    return equal


def likely_nodata(heights: Array) -> float | None:
    """The value that looks as if it stood for missing heights, if one does.

    It is the lowest or the highest of them, far from all others: a usual mark at least as far as
    these are apart, any other number ten times as far and at least 100.
    """
    known = heights[np.isfinite(heights)]
    for extreme in (known.min(initial=np.inf), known.max(initial=-np.inf)):
        others = known[~_equal(known, extreme)]
        if not others.size:
            continue
        gap = float(np.abs(others - extreme).min())
        usual = any(_equal(extreme, mark) for mark in _USUAL_NODATA)
        spread = float(np.ptp(others))
        if gap >= (spread if usual else max(100.0, 10.0 * spread)):
            return float(extreme)
    return None


def read_table(path: Path) -> Samples:
    """A grid of numbers, one row a line, row 0 first; empty fields and `nan` are holes.

    Separated by commas, semicolons or white space; lines that begin with `#` are skipped.

    Raises:
        MapError: Not such a file, or too large.
    """
    return Samples(_numbers(path))


def read_triple(x: Path, y: Path, z: Path) -> Samples:
    """Heights `z` at places `x`, `y`, three tables of one shape, as Quad-SDK writes them.

    Raises:
        MapError: The tables differ in shape, or the places are no even grid.
    """
    along, across, heights = _numbers(x), _numbers(y), _numbers(z)
    if not along.shape == across.shape == heights.shape:
        raise MapError(f"differs in shape from {x.name} and {y.name}")
    if min(heights.shape) < 2:
        raise MapError("expected at least 2 x 2 heights")
    places = []
    for name, table in ((x.name, along), (y.name, across.T)):
        line = table[0]
        steps = np.diff(line)
        step = float(steps.mean())
        with np.errstate(invalid="ignore"):
            even = step != 0.0 and bool((np.abs(steps - step) <= _EVEN * abs(step)).all())
            even = even and bool((np.abs(table - line) <= _EVEN * abs(step)).all())
        if not even:
            raise MapError(f"{name} gives no even grid: expected x along lines and y down them")
        places.append((float(line.min()), step))
    (x0, dx), (y0, dy) = places
    if abs(abs(dx) - abs(dy)) > _EVEN * abs(dx):
        raise MapError(f"expected the same distance in x and y, not {abs(dx):g} and {abs(dy):g} m")
    heights = heights[:: 1 if dy > 0 else -1, :: 1 if dx > 0 else -1]
    return Samples(heights, abs(dx), (x0, y0), cells=False)


def read_archive(path: Path) -> Samples:
    """The array `height` (or `elevation`, `z`, or the only one) of an NPZ archive.

    `resolution` (m) and `origin` (x, y) are taken from it if they are there; row 0 is the first.

    Raises:
        MapError: Not such an archive, or too large.
    """
    content = read_bytes(path, MAX_BYTES)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(member.file_size for member in archive.infolist()) > 4 * MAX_BYTES:
                raise MapError(f"unpacks to more than {4 * MAX_BYTES // 1_000_000} MB")
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            found = {name: np.asarray(arrays[name]) for name in arrays.files}
    except (MapError, MemoryError):
        raise
    except Exception:
        # Damaged archives are answered with errors of zipfile, zlib, struct, numpy and more.
        raise MapError("not a readable NPZ archive of plain arrays") from None
    grids = [name for name, array in found.items() if array.ndim == 2]
    name = next((name for name in _NAMES if name in grids), None)
    if name is None and len(grids) == 1:
        name = grids[0]
    if name is None:
        raise MapError("expected an array `height` of two dimensions in the archive")
    if found[name].dtype.kind not in "fiub":
        raise MapError(f"expected numbers in the array {name[:40]!r}")
    check_sample_count(*found[name].shape)
    step = _given(found, "resolution", 1)
    corner = _given(found, "origin", 2, 3)
    return Samples(
        found[name].astype(np.float64),
        None if step is None else step[0],
        None if corner is None else (corner[0], corner[1]),
    )


def _given(found: dict[str, Array], name: str, *counts: int) -> list[float] | None:
    if name not in found:
        return None
    array = found[name].ravel()
    if array.dtype.kind not in "fiu" or array.size not in counts or not np.isfinite(array).all():
        raise MapError(f"expected {counts[0]} finite number(s) in the array {name!r}")
    return [float(value) for value in array]


def _numbers(path: Path) -> Array:
    """The numbers of a text file `(rows, cols)`; nan where a field is empty or says so."""
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise MapError("expected a text file of numbers", file=path) from None
    lines = {
        number: line
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    }
    if not lines:
        raise MapError("there is no number in it", file=path)
    first = next(iter(lines.values()))
    mark = next((mark for mark in (",", ";") if mark in first), None)
    width = len(_fields(first, mark))
    check_sample_count(len(lines), width)
    table = np.empty((len(lines), width))
    for row, (number, line) in enumerate(lines.items()):
        fields = _fields(line, mark)
        if len(fields) != width:
            text = f"{len(fields)} numbers, where the lines before have {width}"
            raise MapError(text, file=path, key=f"line {number}")
        try:
            table[row] = fields
        except ValueError:
            raise MapError("expected numbers", file=path, key=f"line {number}") from None
    return table


def _fields(line: str, mark: str | None) -> list[str]:
    """The fields of a line between marks, or white space; `nan` where there is nothing."""
    if mark is None:
        return line.split()
    # An end of line after the last separator closes the field, it opens no new one.
    return [field.strip() or "nan" for field in line.rstrip().removesuffix(mark).split(mark)]
