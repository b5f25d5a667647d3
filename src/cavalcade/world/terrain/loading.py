"""Terrain files: a description in YAML, or a file that says enough by itself.

Keys of a description, beside `file`: `resolution` (m between heights), `height` (m of black and
white of a picture), `scale` (m of one unit of any other file), `origin` (pose of the lower-left
corner in the map frame), `first_row`, `nodata` and `holes`; see docs/how-to/terrain.md.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from cavalcade.errors import MapError
from cavalcade.files import read_head
from cavalcade.values import path_of
from cavalcade.world._descriptions import as_float, choice, load_mapping, numbers
from cavalcade.world._images import PNG_SIGNATURE
from cavalcade.world.occupancy import checked_origin, checked_resolution
from cavalcade.world.ros_map import MapWarning, warn_of_degrees
from cavalcade.world.terrain.meshes import is_mesh, read_mesh
from cavalcade.world.terrain.samples import (
    Samples,
    likely_nodata,
    read_archive,
    read_picture,
    read_table,
    read_triple,
    to_grid,
    without,
)
from cavalcade.world.terrain.terrain import MAX_HEIGHT, RESOLUTION, Terrain, checked_cell

Kind = Literal["picture", "archive", "mesh", "table", "description"]

KEYS = (
    "file",
    "x",
    "y",
    "resolution",
    "height",
    "scale",
    "origin",
    "first_row",
    "nodata",
    "holes",
)
"""Keys of a description."""

_FORMATS = "a description in YAML, or a PNG, NPZ, CSV, STL or PLY file"

_TABLES = ("x_data.csv", "y_data.csv", "z_data.csv")


def load_terrain(path: str | Path, resolution: float = RESOLUTION) -> Terrain:
    """Read a terrain and bring it to cells of `resolution` m.

    Args:
        path: A description (YAML), a mesh (STL or PLY), an NPZ archive that gives its resolution,
            or a folder with x_data.csv, y_data.csv and z_data.csv.
        resolution: Side of the terrain's cells, m.

    Raises:
        MapError: The file cannot be used; the message is one line that says which and why.
    """
    path = path_of(path, kind=MapError)
    cell = checked_cell(resolution)
    try:
        # Numbers of damaged files overflow, or are signals; what comes of them is looked at.
        with np.errstate(over="ignore", invalid="ignore"):
            return _loaded(path, cell)
    except MapError as error:
        raise (error.at(file=path, key=error.key) if error.file is None else error) from None
    except MemoryError:
        raise MapError("is too large for the memory there is", file=path) from None


def _loaded(path: Path, cell: float) -> Terrain:
    if path.is_dir():
        samples = read_triple(*(path / name for name in _TABLES))
        return _terrain(_known(samples, {}, path), cell, {})
    kind = _kind_of(path)
    if kind == "description":
        return _described(path, cell)
    if kind in ("picture", "table"):
        raise MapError(f"a {kind} needs a description in YAML with file and resolution")
    return _terrain(_read(kind, path, cell, {}), cell, {})


def _described(path: Path, cell: float) -> Terrain:
    said = load_mapping(path, "file and resolution")
    for key in said:
        if key not in KEYS:
            raise MapError("unknown key", file=path, key=key[:40], choices=KEYS)
    file = _name(said, "file", path)
    try:
        if "x" in said or "y" in said:
            samples = read_triple(_name(said, "x", path), _name(said, "y", path), file)
            samples = _known(samples, said, file)
        else:
            kind = _kind_of(file)
            if kind == "description":
                raise MapError("expected a PNG, NPZ, CSV, STL or PLY file", key="file")
            samples = _read(kind, file, cell, said)
        terrain = _terrain(samples, cell, said)
        warn_of_degrees(path, terrain.origin[2])
        return terrain
    except MapError as error:
        if error.file is not None:
            raise
        # What concerns a key stands in the description, the rest in the file itself.
        raise error.at(file=path if error.key in KEYS else file, key=error.key) from None


def _read(kind: Kind, file: Path, cell: float, said: dict[str, Any]) -> Samples:
    if kind == "picture":
        low, high = _range(said)
        samples = read_picture(file, _nodata(said))
        samples = replace(samples, heights=low + (high - low) * samples.heights)
        return _turned(samples, said, "top")
    if "height" in said:
        raise MapError("is for pictures; expected scale", key="height")
    scale = as_float(said["scale"], "scale") if "scale" in said else 1.0
    if not 1e-6 <= scale <= 1e6:
        raise MapError("expected a number from 1e-6 to 1e6", key="scale")
    if kind == "mesh":
        for key in ("resolution", "first_row", "nodata"):
            if key in said:
                raise MapError("a mesh has none", key=key)
        return read_mesh(file, cell, scale)
    samples = read_archive(file) if kind == "archive" else read_table(file)
    samples = _known(samples, said, file, scale)
    samples = replace(samples, heights=scale * samples.heights)
    return _turned(samples, said, "bottom")


def _nodata(said: dict[str, Any]) -> float | None:
    """What stands for missing heights in the file, if the description says so."""
    return as_float(said["nodata"], "nodata") if "nodata" in said else None


def _known(samples: Samples, said: dict[str, Any], file: Path, scale: float = 1.0) -> Samples:
    """The heights without those that only mark missing ones; a warning where nobody said which."""
    nodata = _nodata(said)
    if nodata is None and (mark := likely_nodata(samples.heights)) is not None:
        text = f"heights of {mark:g} look as if they stood for missing ones"
        hint = f"expected nodata: {mark:g} in its description, if so"
        if scale * abs(mark) > MAX_HEIGHT:
            raise MapError(f"{text}; {hint}", file=file)
        warnings.warn(f"{file}: {text}; {hint}", MapWarning, stacklevel=2)
    return without(samples, nodata)


def _terrain(samples: Samples, cell: float, said: dict[str, Any]) -> Terrain:
    if "resolution" in said:
        step = checked_resolution(as_float(said["resolution"], "resolution"))
        samples = replace(samples, step=step)
    corner = samples.corner or (0.0, 0.0)
    origin = checked_origin(numbers(said, "origin")) if "origin" in said else (*corner, 0.0)
    holes = choice(said, "holes", ("keep", "fill"), "keep") == "keep"
    return Terrain.from_heights(to_grid(samples, cell, holes), cell, origin)


def _kind_of(file: Path) -> Kind:
    """Told by the content, where that is possible."""
    head = read_head(file, 512)
    if head.startswith(PNG_SIGNATURE):
        return "picture"
    if head.startswith(b"PK\x03\x04"):
        return "archive"
    suffix = file.suffix.lower()
    if is_mesh(head) or suffix == ".stl":
        return "mesh"
    if suffix in (".csv", ".txt"):
        return "table"
    if suffix not in ("", ".yaml", ".yml"):
        raise MapError(f"unknown format {suffix[:20]}; expected {_FORMATS}", file=file)
    return "description"


def _turned(samples: Samples, said: dict[str, Any], usual: str) -> Samples:
    """Row 0 of the file is at the lowest y (pictures: the last one) unless told otherwise."""
    if choice(said, "first_row", ("bottom", "top"), usual) == usual:
        return samples
    return replace(samples, heights=samples.heights[::-1])


def _range(said: dict[str, Any]) -> tuple[float, float]:
    """Heights of black and white."""
    if "scale" in said:
        raise MapError(
            "a picture has none; expected height: metres of black and white", key="scale"
        )
    value = said.get("height")
    if value is None:
        raise MapError("is missing; expected metres of white, or [black, white]", key="height")
    if isinstance(value, list):
        if len(value) != 2:
            raise MapError("expected [black, white]: 2 numbers", key="height")
        return as_float(value[0], "height"), as_float(value[1], "height")
    return 0.0, as_float(value, "height")


def _name(said: dict[str, Any], key: str, path: Path) -> Path:
    """The file that a key names, relative to the description."""
    value = said.get(key)
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise MapError("expected the name of a file", file=path, key=key)
    return path.parent / value
