"""Descriptions in YAML: values with their types and ranges, and what a ROS map says of itself.

The keys of a ROS map are read as Nav2's map server reads them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast, get_args

import yaml

from cavalcade.errors import MapError
from cavalcade.files import read_bytes
from cavalcade.world.occupancy import Unknown, checked_origin, checked_resolution
from cavalcade.yaml_text import parse_yaml

_MAX_BYTES = 100_000

Mode = Literal["trinary", "scale", "raw"]

MODES: tuple[Mode, ...] = get_args(Mode)


@dataclass(frozen=True)
class MapDescription:
    """What the YAML file says.

    Attributes:
        image: The picture as it is named there: relative to the YAML file, or absolute.
        resolution: m per cell.
        origin: Pose (x m, y m, yaw rad) of the lower-left corner of the picture.
        mode: How grey becomes occupancy.
        negate: White is occupied instead of black.
        free_thresh: At most this occupancy is free, 0 to 1.
        occupied_thresh: At least this occupancy is occupied, 0 to 1.
        unknown: Whether unknown ground counts as an obstacle; a key of our own, which other
            readers ignore.
    """

    image: str
    resolution: float
    origin: tuple[float, float, float]
    mode: Mode
    negate: bool
    free_thresh: float
    occupied_thresh: float
    unknown: Unknown = "occupied"


def read_description(path: Path) -> MapDescription:
    """Read and check the YAML description of a map."""
    document = load_mapping(path)
    try:
        description = MapDescription(
            image=text(document, "image"),
            resolution=checked_resolution(number(document, "resolution")),
            origin=checked_origin(numbers(document, "origin")),
            mode=choice(document, "mode", MODES, "trinary"),
            negate=flag(document, "negate"),
            free_thresh=_threshold(document, "free_thresh"),
            occupied_thresh=_threshold(document, "occupied_thresh"),
            unknown=choice(document, "unknown", get_args(Unknown), "occupied"),
        )
    except MapError as error:
        # The parts know the key; the file is known here.
        raise error.at(file=path, key=error.key) from None
    if description.free_thresh >= description.occupied_thresh:
        raise MapError("must be less than occupied_thresh", file=path, key="free_thresh")
    return description


def description_text(description: MapDescription) -> str:
    """The YAML text that `read_description` turns back into `description`."""
    document: dict[str, Any] = {
        "image": description.image,
        "mode": description.mode,
        "resolution": description.resolution,
        "origin": list(description.origin),
        "negate": int(description.negate),
        "occupied_thresh": description.occupied_thresh,
        "free_thresh": description.free_thresh,
    }
    if description.unknown != "occupied":
        document["unknown"] = description.unknown
    return cast(str, yaml.safe_dump(document, sort_keys=False, default_flow_style=None))


def _threshold(document: dict[str, Any], key: str) -> float:
    threshold = number(document, key)
    if not 0.0 <= threshold <= 1.0:
        raise MapError("expected a number from 0 to 1", key=key)
    return threshold


def load_mapping(path: Path, such_as: str = "image and resolution") -> dict[str, Any]:
    """The mapping that a YAML file holds; `such_as` names some of its keys for the error."""
    document = parse_yaml(read_bytes(path, _MAX_BYTES), file=path, kind=MapError)
    if not isinstance(document, dict):
        raise MapError(f"expected a mapping of keys such as {such_as}", file=path)
    return document


def required(document: dict[str, Any], key: str) -> object:
    """The value of a key that must be there."""
    if document.get(key) is None:
        raise MapError("is missing", key=key)
    return document[key]


def text(document: dict[str, Any], key: str) -> str:
    """The name of a picture."""
    value = required(document, key)
    if not isinstance(value, str) or not value.strip():
        raise MapError("expected the name of a picture", key=key)
    return value


def as_float(value: object, key: str) -> float:
    """A number; YAML 1.1 leaves some, such as 5e-2, as text."""
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        try:
            result = float(value)
        except (ValueError, OverflowError):
            result = math.nan
        if math.isfinite(result):
            return result
    raise MapError("expected a finite number", key=key)


def number(document: dict[str, Any], key: str) -> float:
    """A finite number."""
    return as_float(required(document, key), key)


def numbers(document: dict[str, Any], key: str) -> list[float]:
    """Three finite numbers: a pose."""
    value = required(document, key)
    if not isinstance(value, list) or len(value) != 3:
        raise MapError("expected three numbers: [x, y, yaw]", key=key)
    return [as_float(part, key) for part in value]


def flag(document: dict[str, Any], key: str) -> bool:
    """0 or 1, false or true."""
    value = required(document, key)
    if not isinstance(value, (bool, int)):
        raise MapError("expected 0 or 1", key=key)
    return bool(value)


def choice(document: dict[str, Any], key: str, choices: tuple[Any, ...], default: str) -> Any:
    """One of the choices, in any case of letters."""
    value = document.get(key)
    if value is None:
        return default
    if not isinstance(value, str) or value.lower() not in choices:
        raise MapError("expected another value", key=key, choices=choices)
    return value.lower()
