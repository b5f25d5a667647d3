"""The PLY format (Turk, 1994): triangles of its vertices and faces, text or binary."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import MapError
from cavalcade.geometry import Array

_NAMES = {
    "i1": ("char", "int8"),
    "u1": ("uchar", "uint8"),
    "i2": ("short", "int16"),
    "u2": ("ushort", "uint16"),
    "i4": ("int", "int32"),
    "u4": ("uint", "uint32"),
    "f4": ("float", "float32"),
    "f8": ("double", "float64"),
}
_TYPES = {name: code for code, names in _NAMES.items() for name in names}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_MAX_HEADER = 20_000


@dataclass
class _Element:
    """One `element` of the header; lists have two types, of their length and of their items."""

    name: str
    count: int
    properties: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)

    @property
    def has_list(self) -> bool:
        return any(len(types) == 2 for _, types in self.properties)


def parse_ply(content: bytes) -> Array:
    """The triangles `(N, 3, 3)`; faces of more corners are fans of triangles.

    Raises:
        MapError: Damaged, or without vertices x, y, z.
    """
    order, elements, start = _header(content)
    vertices: Array | None = None
    faces: list[NDArray[np.int64]] = []
    read = _TextBody(content[start:]) if order == "" else _BinaryBody(content[start:], order)
    try:
        for element in elements:
            if element.name == "vertex":
                vertices = read.table(element)
            elif element.name == "face":
                faces = read.faces(element)
            else:
                read.skip(element)
    except (ValueError, IndexError, OverflowError):
        raise MapError("the PLY mesh is truncated or damaged") from None
    if vertices is None:
        raise MapError("expected vertices with x, y and z in the PLY mesh")
    return _triangles(vertices, faces)


def _header(content: bytes) -> tuple[str, list[_Element], int]:
    """Byte order ('' for text), elements, and where the body begins."""
    end = content.find(b"end_header", 0, _MAX_HEADER)
    stop = content.find(b"\n", end) + 1
    if end < 0 or stop == 0:
        raise MapError("the header of the PLY mesh has no end")
    order: str | None = None
    elements: list[_Element] = []
    for line in content[:end].decode("ascii", "replace").splitlines()[1:]:
        words = line.split()
        kind = words[0] if words else "comment"
        if kind == "format" and len(words) >= 2:
            order = _ORDERS.get(words[1])
        elif kind == "element" and len(words) == 3 and words[2].isdecimal() and len(words[2]) < 10:
            elements.append(_Element(words[1], int(words[2])))
        elif kind == "property" and elements and len(words) in (3, 5):
            types = (words[1],) if len(words) == 3 else (words[2], words[3])
            is_list = words[1] == "list"
            if any(name not in _TYPES for name in types) or is_list != (len(words) == 5):
                raise MapError(f"unknown type in the PLY header: {line.strip()[:40]}")
            elements[-1].properties.append((words[-1], tuple(_TYPES[name] for name in types)))
        elif kind not in ("comment", "obj_info"):
            raise MapError(f"cannot read the line of the PLY header: {line.strip()[:40]}")
    if order is None:
        raise MapError("unknown format of the PLY mesh", choices=_ORDERS)
    return order, elements, stop


class _TextBody:
    """Reads elements of a text body one after another, a line each."""

    def __init__(self, body: bytes) -> None:
        self.lines = body.split(b"\n")
        self.at = 0

    def table(self, element: _Element) -> Array:
        columns = _columns(element)
        return np.array([[float(row[c]) for c in columns] for row in self._rows(element)])

    def faces(self, element: _Element) -> list[NDArray[np.int64]]:
        _corner_property(element)
        result = []
        for row in self._rows(element):
            values = iter(row)
            for name, types in element.properties:
                count = int(next(values, b"x")) if len(types) == 2 else 1
                items = [next(values, b"x") for _ in range(min(count, len(row)))]
                if name in _CORNERS:
                    result.append(np.array([int(item) for item in items], dtype=np.int64))
        return result

    def skip(self, element: _Element) -> None:
        self._rows(element)

    def _rows(self, element: _Element) -> list[list[bytes]]:
        rows = [line.split() for line in self.lines[self.at : self.at + element.count]]
        if len(rows) < element.count:
            raise ValueError
        self.at += element.count
        return rows


class _BinaryBody:
    """Reads elements of a binary body one after another."""

    def __init__(self, body: bytes, order: str) -> None:
        self.body, self.order, self.at = body, order, 0

    def table(self, element: _Element) -> Array:
        _columns(element)
        rows = self._fixed(element)
        return np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)

    def faces(self, element: _Element) -> list[NDArray[np.int64]]:
        corner = _corner_property(element)
        # Nearly all files hold triangles only: then each face has the same size.
        if sum(len(types) == 2 for _, types in element.properties) == 1:
            fields: list[tuple[str, str] | tuple[str, str, int]] = []
            for name, types in element.properties:
                if len(types) == 2:
                    fields += [("many", self.order + types[0]), (name, self.order + types[1], 3)]
                else:
                    fields.append((name, self.order + types[0]))
            kind = np.dtype(fields)
            if self.at + element.count * kind.itemsize <= len(self.body):
                rows = np.frombuffer(self.body, dtype=kind, count=element.count, offset=self.at)
                if (rows["many"] == 3).all():
                    self.at += element.count * kind.itemsize
                    return list(rows[corner].astype(np.int64))
        return [self._face(element, corner) for _ in range(element.count)]

    def skip(self, element: _Element) -> None:
        if element.has_list:
            for _ in range(element.count):
                self._face(element, "")
        else:
            self._fixed(element)

    def _face(self, element: _Element, corner: str) -> NDArray[np.int64]:
        found = np.empty(0, dtype=np.int64)
        for name, types in element.properties:
            count = int(self._take(types[0], 1)[0]) if len(types) == 2 else 1
            items = self._take(types[-1], count)
            if name == corner:
                found = items.astype(np.int64)
        return found

    def _fixed(self, element: _Element) -> NDArray[np.void]:
        kind = np.dtype([(name, self.order + types[0]) for name, types in element.properties])
        rows: NDArray[np.void] = np.frombuffer(
            self.body, dtype=kind, count=element.count, offset=self.at
        )
        self.at += element.count * kind.itemsize
        return rows

    def _take(self, kind: str, count: int) -> Array:
        dtype = np.dtype(self.order + kind)
        if count < 0:
            raise ValueError
        items = np.frombuffer(self.body, dtype=dtype, count=count, offset=self.at)
        self.at += count * dtype.itemsize
        return items


def _columns(element: _Element) -> list[int]:
    names = [name for name, _ in element.properties]
    if element.has_list or any(axis not in names for axis in "xyz"):
        raise MapError("expected vertices with x, y and z in the PLY mesh")
    return [names.index(axis) for axis in "xyz"]


def _corner_property(element: _Element) -> str:
    for name, types in element.properties:
        if name in _CORNERS and len(types) == 2:
            return name
    raise MapError("expected faces with vertex_indices in the PLY mesh")


def _triangles(vertices: Array, faces: list[NDArray[np.int64]]) -> Array:
    if all(len(face) == 3 for face in faces):
        corners = np.array(faces, dtype=np.int64).reshape(-1, 3)
    else:
        fans = [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]
        corners = np.array(fans, dtype=np.int64).reshape(-1, 3)
    if corners.size and not (corners.min() >= 0 and corners.max() < len(vertices)):
        raise MapError("a face of the PLY mesh names a vertex that is not there")
    return vertices.reshape(-1, 3)[corners]
