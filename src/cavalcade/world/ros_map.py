"""Occupancy maps of ROS's map server: a YAML description and a PGM or PNG picture.

Grey becomes occupancy as in Nav2's `nav2_map_server` (`map_io.cpp`, since its comparisons are
inclusive): with `occ = 1 - grey / 255`, or `grey / 255` if `negate` is set,

- `trinary`: `occ >= occupied_thresh` is 100, `occ <= free_thresh` is 0, the rest is unknown;
- `scale`: the rest is scaled to 0..100 between the two thresholds;
- `raw`: the grey itself, 0 to 100; all else is unknown. Thresholds, `negate` and opacity have no
  effect.

The two thresholds may be equal: then nothing is unknown, and what is exactly there is occupied.

In the first two modes a pixel that is not fully opaque is unknown. Row 0 of a picture is its top,
row 0 of a map is its bottom.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import yaml
from numpy.typing import NDArray

from cavalcade.errors import MapError
from cavalcade.files import write_file
from cavalcade.geometry import beyond_a_turn
from cavalcade.values import instance_of, is_missing, path_of
from cavalcade.world._descriptions import choice, load_mapping, number, numbers, required
from cavalcade.world._images import encode_pgm, encode_png, read_grey
from cavalcade.world.occupancy import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    OccupancyMap,
    Unknown,
    checked_origin,
    checked_resolution,
)

Mode = Literal["trinary", "scale", "raw"]

MODES: tuple[Mode, ...] = get_args(Mode)

_SAVED_UNKNOWN = 205
"""Grey that map savers write for unknown ground."""

_THRESHOLDS: dict[Mode, tuple[float, float]] = {
    "trinary": (0.196, 0.65),
    # The whole range, so that scaling there and back keeps every value.
    "scale": (0.0, 1.0),
    "raw": (0.196, 0.65),
}
"""free_thresh and occupied_thresh that a saved map is described with."""


@dataclass(frozen=True)
class _Description:
    """What the YAML file says; `unknown` is a key of our own, which other readers ignore."""

    image: str  # relative to the YAML file, or absolute
    resolution: float
    origin: tuple[float, float, float]
    mode: Mode
    negate: bool
    free_thresh: float
    occupied_thresh: float
    unknown: Unknown = "occupied"


class MapWarning(UserWarning):
    """A map was read as it is written, but probably not as it was meant."""


def load_map(path: str | Path, unknown: Unknown | None = None) -> OccupancyMap:
    """Read a map from its YAML description.

    Args:
        path: The YAML file; the picture it names is looked for beside it.
        unknown: Whether unknown cells count as `occupied` or `free`. By default what the file
            says in a key `unknown` of our own, else `occupied`.

    Raises:
        MapError: A file is missing or malformed; the message names file and key.

    Warns:
        MapWarning: `free_thresh` turns the grey that stands for unknown ground into free ground,
            or the origin's yaw seems to be in degrees.
    """
    path = path_of(path, kind=MapError)
    description = _read_description(path)
    warn_of_degrees(path, description.origin[2])
    picture = path.parent / description.image
    if not _exists(picture):
        raise MapError(f"no such file: {description.image}", file=path, key="image")
    grey, alpha = read_grey(picture)
    table = _occupancy_of_grey(description)
    # Scaled maps tell unknown ground by opacity, and raw ones by values above 100.
    told_by_grey = description.mode == "trinary" and not description.negate
    if told_by_grey and table[_SAVED_UNKNOWN] == FREE and (grey == _SAVED_UNKNOWN).any():
        warnings.warn(
            f"{path}: free_thresh: {description.free_thresh:g} turns unknown ground "
            f"(grey {_SAVED_UNKNOWN}) into free ground; set it to 0.196 to keep it unknown",
            MapWarning,
            stacklevel=2,
        )
    grid = table[grey]
    if alpha is not None and description.mode != "raw":
        grid[alpha < 255] = UNKNOWN
    return OccupancyMap(
        grid[::-1],
        description.resolution,
        description.origin,
        description.unknown if unknown is None else unknown,
    )


def warn_of_degrees(path: Path, yaw: float) -> None:
    """Warn of an origin that is turned by more than a turn."""
    if beyond_a_turn(yaw):
        text = f"a yaw of {yaw:g} rad is more than a turn; expected radians, not degrees"
        warnings.warn(f"{path}: origin: {text}", MapWarning, stacklevel=3)


def save_map(
    occupancy_map: OccupancyMap,
    path: str | Path,
    image: Literal["pgm", "png"] = "pgm",
    mode: Mode | None = None,
) -> None:
    """Write a map so that `load_map` gives an equal one; both files appear whole or not at all.

    Args:
        path: The YAML file to write, `*.yaml` or `*.yml`; the picture gets the same stem.
        image: Format of the picture.
        mode: `trinary`, `scale` or `raw`; by default the first of them that keeps every value.

    Raises:
        MapError: The wrong kind of name, or a mode that cannot keep the map's values.
        OutputError: A file cannot be written.
    """
    path = path_of(path, kind=MapError)
    instance_of(occupancy_map, OccupancyMap, "occupancy_map")
    if path.suffix not in (".yaml", ".yml"):
        raise MapError("expected a name ending in .yaml or .yml", file=path)
    if not isinstance(image, str) or image not in ("pgm", "png"):
        raise MapError("unknown format of picture", key="image", choices=("pgm", "png"))
    if mode is not None and (not isinstance(mode, str) or mode not in MODES):
        raise MapError("unknown mode", key="mode", choices=MODES)
    grid = occupancy_map.grid[::-1]
    chosen = next(m for m in MODES if _keeps(grid, m, image)) if mode is None else mode
    if not _keeps(grid, chosen, image):
        raise MapError(f"{chosen} in a {image} picture cannot keep this map's values", key="mode")
    grey = _GREY_OF[chosen].astype(np.uint8)[grid.astype(np.int64) + 1]
    alpha = None
    if chosen == "scale" and image == "png":
        alpha = np.where(grid == UNKNOWN, 0, 255).astype(np.uint8)
    picture = path.with_suffix(f".{image}")
    free_thresh, occupied_thresh = _THRESHOLDS[chosen]
    document: dict[str, Any] = {
        "image": picture.name,
        "mode": chosen,
        "resolution": occupancy_map.resolution,
        "origin": list(occupancy_map.origin),
        "negate": 0,
        "occupied_thresh": occupied_thresh,
        "free_thresh": free_thresh,
    }
    if occupancy_map.unknown != "occupied":
        document["unknown"] = occupancy_map.unknown
    write_file(picture, encode_pgm(grey) if image == "pgm" else encode_png(grey, alpha))
    # Last, so that a description never names a picture that is not there.
    write_file(path, yaml.safe_dump(document, sort_keys=False, default_flow_style=None))


def _read_description(path: Path) -> _Description:
    document = load_mapping(path)
    try:
        mode = choice(document, "mode", MODES, "trinary")
        _check_complete(document, mode)
        return _Description(
            image=_image(document, "image"),
            resolution=checked_resolution(number(document, "resolution")),
            origin=checked_origin(numbers(document, "origin")),
            mode=mode,
            negate=_flag(document, "negate"),
            **_thresholds(document, mode),
            unknown=choice(document, "unknown", get_args(Unknown), "occupied"),
        )
    except MapError as error:
        # The parts know the key; the file is known here.
        raise error.at(file=path, key=error.key) from None


def _check_complete(document: dict[str, Any], mode: Mode) -> None:
    """Name all that is missing at once, with the values that are usual."""
    usual = {"negate": "0"}
    if mode != "raw":
        free, occupied = _THRESHOLDS["trinary"]
        usual |= {"occupied_thresh": f"{occupied:g}", "free_thresh": f"{free:g}"}
    keys = ("image", "resolution", "origin", *usual)
    missing = [key for key in keys if document.get(key) is None]
    if not missing:
        return
    text = is_missing(missing[1:])
    said = ", ".join(f"{key}: {value}" for key, value in usual.items() if key in missing)
    if said:
        text += f"; usual is {said}"
    raise MapError(text, key=missing[0])


def _image(document: dict[str, Any], key: str) -> str:
    value = required(document, key)
    if not isinstance(value, str) or not value.strip():
        raise MapError("expected the name of a picture", key=key)
    return value


def _flag(document: dict[str, Any], key: str) -> bool:
    value = required(document, key)
    if not isinstance(value, (bool, int)):
        raise MapError("expected 0 or 1", key=key)
    return bool(value)


def _thresholds(document: dict[str, Any], mode: Mode) -> dict[str, float]:
    """The two thresholds; those of raw maps are of no account, whatever is said."""
    if mode == "raw":
        return dict(zip(("free_thresh", "occupied_thresh"), _THRESHOLDS["raw"], strict=True))
    found = {key: number(document, key) for key in ("free_thresh", "occupied_thresh")}
    for key, threshold in found.items():
        if not 0.0 <= threshold <= 1.0:
            raise MapError("expected a number from 0 to 1", key=key)
    if found["free_thresh"] > found["occupied_thresh"]:
        raise MapError("must not be more than occupied_thresh", key="free_thresh")
    return found


def _occupancy_of_grey(description: _Description) -> NDArray[np.int8]:
    """Occupancy `(256,)` for every grey; in single precision, as Nav2 compares."""
    grey = np.arange(256)
    if description.mode == "raw":
        return np.where(grey <= OCCUPIED, grey, UNKNOWN).astype(np.int8)
    occ = grey.astype(np.float32) / np.float32(255.0)
    if not description.negate:
        occ = np.float32(1.0) - occ
    low, high = np.float32(description.free_thresh), np.float32(description.occupied_thresh)
    table = np.full(256, UNKNOWN, dtype=np.int8)
    if description.mode == "scale":
        span = np.float32(description.occupied_thresh - description.free_thresh)
        between = (occ > low) & (occ < high)  # none if they are equal
        table[between] = np.floor((occ[between] - low) / span * np.float32(100.0) + 0.5)
    table[occ <= low] = FREE
    table[occ >= high] = OCCUPIED
    return table


_VALUES = np.arange(-1, 101)
_GREY_OF: dict[Mode, NDArray] = {
    "trinary": np.select([_VALUES == FREE, _VALUES == OCCUPIED], [254, 0], _SAVED_UNKNOWN),
    "scale": np.where(_VALUES == UNKNOWN, 128, np.rint((100 - _VALUES) / 100 * 255)),
    "raw": np.where(_VALUES == UNKNOWN, 255, _VALUES),
}
"""Grey `(102,)` that each mode writes for the values -1 to 100."""


def _keeps(grid: NDArray[np.int8], mode: Mode, image: str) -> bool:
    """Whether a map of these values survives being saved."""
    if mode == "trinary":
        return bool(((grid <= FREE) | (grid == OCCUPIED)).all())
    if mode == "scale":
        return image == "png" or not bool((grid == UNKNOWN).any())
    return True


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name that is too long, or with a null byte
        return False
