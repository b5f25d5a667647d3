"""The YAML description of a ROS map: keys, types and ranges as Nav2's map server reads them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast, get_args

import yaml

from cavalcade.errors import MapError
from cavalcade.world._files import read_bytes
from cavalcade.world.occupancy import Unknown, checked_origin, checked_resolution

Mode = Literal["trinary", "scale", "raw"]

MODES: tuple[Mode, ...] = get_args(Mode)

_MAX_BYTES = 100_000


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


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML brings no types
    """YAML without merge keys: no map needs them, and nested ones can grow without bound."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        for key, _ in node.value:
            if key.tag == "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(problem="merge keys are not supported")


def read_description(path: Path) -> MapDescription:
    """Read and check the YAML description of a map.

    Raises:
        MapError: The file cannot be read, is no YAML mapping, or a key is missing or wrong.
    """
    document = _load_yaml(path)
    try:
        description = MapDescription(
            image=_text(document, "image"),
            resolution=checked_resolution(_number(document, "resolution")),
            origin=checked_origin(_numbers(document, "origin")),
            mode=_choice(document, "mode", MODES, "trinary"),
            negate=_flag(document, "negate"),
            free_thresh=_threshold(document, "free_thresh"),
            occupied_thresh=_threshold(document, "occupied_thresh"),
            unknown=_choice(document, "unknown", get_args(Unknown), "occupied"),
        )
    except MapError as error:
        # The parts know the key; the file is known here.
        raise _in_file(error, path) from None
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


def _load_yaml(path: Path) -> dict[str, Any]:
    content = read_bytes(path, _MAX_BYTES)
    try:
        document = yaml.load(content, _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f" in line {mark.line + 1}" if mark else ""
        raise MapError(f"is not valid YAML: {error.problem}{place}", file=path) from None
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        # Besides its own errors the parser lets through those of dates, numbers and deep nesting.
        raise MapError("is not valid YAML", file=path) from None
    if not isinstance(document, dict):
        raise MapError("expected a mapping of keys such as image and resolution", file=path)
    return document


def _in_file(error: MapError, path: Path) -> MapError:
    text = str(error).removeprefix(f"{error.key}: ")
    return MapError(text, file=path, key=error.key)


def _value(document: dict[str, Any], key: str) -> object:
    if document.get(key) is None:
        raise MapError("is missing", key=key)
    return document[key]


def _text(document: dict[str, Any], key: str) -> str:
    value = _value(document, key)
    if not isinstance(value, str) or not value.strip():
        raise MapError("expected the name of a picture", key=key)
    return value


def _as_float(value: object, key: str) -> float:
    """A number; YAML 1.1 leaves some, such as 5e-2, as text."""
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            number = math.nan
        if math.isfinite(number):
            return number
    raise MapError("expected a finite number", key=key)


def _number(document: dict[str, Any], key: str) -> float:
    return _as_float(_value(document, key), key)


def _numbers(document: dict[str, Any], key: str) -> list[float]:
    value = _value(document, key)
    if not isinstance(value, list) or len(value) != 3:
        raise MapError("expected three numbers: [x, y, yaw]", key=key)
    return [_as_float(part, key) for part in value]


def _threshold(document: dict[str, Any], key: str) -> float:
    number = _number(document, key)
    if not 0.0 <= number <= 1.0:
        raise MapError("expected a number from 0 to 1", key=key)
    return number


def _flag(document: dict[str, Any], key: str) -> bool:
    value = _value(document, key)
    if not isinstance(value, (bool, int)):
        raise MapError("expected 0 or 1", key=key)
    return bool(value)


def _choice(document: dict[str, Any], key: str, choices: tuple[Any, ...], default: str) -> Any:
    value = document.get(key)
    if value is None:
        return default
    if not isinstance(value, str) or value.lower() not in choices:
        raise MapError("expected another value", key=key, choices=choices)
    return value.lower()
