"""Shapes in the words of a scenario file, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cavalcade.errors import InputError
from cavalcade.world.shapes import Box, Circle, Polygon, Shape

_KEYS: Mapping[str, tuple[frozenset[str], frozenset[str]]] = {
    "box": (frozenset({"center", "size"}), frozenset({"yaw"})),
    "circle": (frozenset({"center", "radius"}), frozenset()),
    "polygon": (frozenset({"points"}), frozenset()),
}
"""Kind to its required and its optional keys."""


def shape_from_mapping(mapping: Mapping[str, Any]) -> Shape:
    """A shape from `{"box": {...}}`, `{"circle": {...}}` or `{"polygon": {...}}`.

    Raises:
        InputError: Unknown kind, a missing or unknown key, or a value the shape refuses; the key
            says which.
    """
    if not isinstance(mapping, Mapping) or len(mapping) != 1:
        raise InputError("expected one shape, such as {circle: ...}", choices=_KEYS)
    kind, values = next(iter(mapping.items()))
    if kind not in _KEYS:
        raise InputError(f"unknown shape {str(kind)[:40]!r}", choices=_KEYS)
    if not isinstance(values, Mapping):
        raise InputError("expected a mapping", key=kind)
    required, optional = _KEYS[kind]
    for name in sorted(required - set(values)):
        raise InputError("is missing", key=f"{kind}.{name}")
    for name in values:
        if name not in required | optional:
            allowed = sorted(required) + sorted(optional)
            raise InputError("unknown key", key=f"{kind}.{str(name)[:40]}", choices=allowed)
    if kind == "box":
        return Box(values["center"], values["size"], values.get("yaw", 0.0))
    if kind == "circle":
        return Circle(values["center"], values["radius"])
    return Polygon(values["points"])


def shape_to_mapping(shape: Shape) -> dict[str, dict[str, Any]]:
    """The mapping of plain lists and floats that `shape_from_mapping` turns back into `shape`."""
    if isinstance(shape, Box):
        box = {"center": list(shape.center), "size": list(shape.size), "yaw": shape.yaw}
        return {"box": box}
    if isinstance(shape, Circle):
        return {"circle": {"center": list(shape.center), "radius": shape.radius}}
    return {"polygon": {"points": [list(point) for point in shape.points]}}
