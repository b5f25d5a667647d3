"""The YAML description of a ROS map: keys, types and ranges as Nav2's map server reads them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast, get_args

import yaml

from cavalcade.errors import MapError
from cavalcade.world._yaml import choice, flag, in_file, load_mapping, number, numbers, text
from cavalcade.world.occupancy import Unknown, checked_origin, checked_resolution

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
    """Read and check the YAML description of a map.

    Raises:
        MapError: The file cannot be read, is no YAML mapping, or a key is missing or wrong.
    """
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
        raise in_file(error, path) from None
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
