"""Values with their types and ranges, out of descriptions in YAML."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from cavalcade.errors import MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.yaml_text import parse_yaml

_MAX_BYTES = 100_000
_PICTURES = (b"\x89PN", b"P2\n", b"P5\n", b"P2 ", b"P5 ", b"\xff\xd8\xff", b"GIF", b"II*", b"MM\0")
"""Beginnings of PNG, PGM, JPEG, GIF and TIFF."""


def load_mapping(path: Path, such_as: str = "image and resolution") -> dict[str, Any]:
    """The mapping that a YAML file holds; `such_as` names some of its keys for the error."""
    head = read_head(path, 8)
    if b"\0" in head or head[:3] in _PICTURES:
        raise MapError(f"expected a description in YAML with {such_as}, not a picture", file=path)
    document = parse_yaml(read_bytes(path, _MAX_BYTES), file=path, kind=MapError)
    if not isinstance(document, dict):
        raise MapError(f"expected a mapping of keys such as {such_as}", file=path)
    return document


def required(document: dict[str, Any], key: str) -> object:
    """The value of a key that must be there."""
    if document.get(key) is None:
        raise MapError("is missing", key=key)
    return document[key]


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


def choice(document: dict[str, Any], key: str, choices: tuple[Any, ...], default: str) -> Any:
    """One of the choices, in any case of letters."""
    value = document.get(key)
    if value is None:
        return default
    if not isinstance(value, str) or value.lower() not in choices:
        raise MapError("expected another value", key=key, choices=choices)
    return value.lower()
