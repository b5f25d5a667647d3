"""Values of YAML descriptions: keys, types and ranges, and what is said when one is wrong."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import yaml

from cavalcade.errors import MapError
from cavalcade.world._files import read_bytes

_MAX_BYTES = 100_000


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML brings no types
    """YAML without merge keys: no map needs them, and nested ones can grow without bound."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        for key, _ in node.value:
            if key.tag == "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(problem="merge keys are not supported")


def load_mapping(path: Path, such_as: str = "image and resolution") -> dict[str, Any]:
    """The mapping that a YAML file holds.

    Args:
        path: The file.
        such_as: Some of its keys, for the error.

    Raises:
        MapError: It cannot be read or holds something else.
    """
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
        raise MapError(f"expected a mapping of keys such as {such_as}", file=path)
    return document


def in_file(error: MapError, path: Path) -> MapError:
    """The same error, known to be about that file."""
    return MapError(str(error).removeprefix(f"{error.key}: "), file=path, key=error.key)


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
