"""Meshes: STL and PLY in text and binary say the same, and are seen from above."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.errors import MapError
from cavalcade.geometry import Array
from cavalcade.world import load_terrain
from cavalcade.world.terrain.meshes import covered_cells, highest_surface, parse_mesh

_FEW = settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def _mesh(count: int = 6, seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(0.0, 2.0, (count, 3, 3)).astype(np.float32) * 1.0


def binary_stl(triangles: Array, head: bytes = b"") -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *map(float, t.ravel()), 0) for t in triangles)
    return head.ljust(80, b"\0") + struct.pack("<I", len(triangles)) + body


def text_stl(triangles: Array) -> bytes:
    facets = "".join(
        "facet normal 0 0 1\n outer loop\n"
        + "".join(f"  vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in t)
        + " endloop\nendfacet\n"
        for t in triangles
    )
    return f"solid ground\n{facets}endsolid ground\n".encode()


def ply(triangles: Array, kind: str, extra: bool = False) -> bytes:
    """With `extra`, more properties than are needed and an element nobody knows."""
    points, faces = triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
    header = f"ply\nformat {kind} 1.0\ncomment made by hand\n"
    if extra:
        header += "element camera 2\nproperty float fov\nproperty list uchar short lens\n"
    header += f"element vertex {len(points)}\nproperty float x\nproperty double y\n"
    header += "property float z\n" + ("property uchar red\n" if extra else "")
    header += f"element face {len(faces)}\n" + ("property int group\n" if extra else "")
    header += "property list uchar int vertex_indices\nend_header\n"
    if kind == "ascii":
        lines = ["1.5 2 7 8", "1.5 0"] if extra else []
        lines += [f"{x:.9g} {y:.17g} {z:.9g}" + " 255" * extra for x, y, z in points]
        lines += ["5 " * extra + f"3 {a} {b} {c}" for a, b, c in faces]
        return (header + "\n".join(lines) + "\n").encode()
    order = "<" if kind == "binary_little_endian" else ">"
    body = b""
    if extra:
        body += struct.pack(order + "fBhh", 1.5, 2, 7, 8) + struct.pack(order + "fB", 1.5, 0)
    for x, y, z in points:
        body += struct.pack(order + "fdf", x, y, z) + b"\xff" * extra
    for a, b, c in faces:
        body += struct.pack(order + "i", 5) if extra else b""
        body += struct.pack(order + "Biii", 3, a, b, c)
    return header.encode() + body


_PLY = ("ascii", "binary_little_endian", "binary_big_endian")


@pytest.mark.parametrize("kind", _PLY)
@pytest.mark.parametrize("extra", [False, True])
def test_every_kind_of_ply_says_the_same(kind: str, extra: bool) -> None:
    triangles = _mesh()
    assert parse_mesh(ply(triangles, kind, extra)) == pytest.approx(triangles, abs=1e-6)


def test_every_kind_of_stl_says_the_same() -> None:
    triangles = _mesh()
    assert parse_mesh(binary_stl(triangles)) == pytest.approx(triangles, abs=1e-6)
    assert parse_mesh(text_stl(triangles)) == pytest.approx(triangles, abs=1e-6)
    # Binary files that begin like text ones are met in the wild.
    assert parse_mesh(binary_stl(triangles, b"solid x")) == pytest.approx(triangles, abs=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace(b"solid", b"Solid"),
        lambda text: text.upper(),
        lambda text: b"\xef\xbb\xbf" + text,
        lambda text: b"\n \t" + text,
        lambda text: text.replace(b"\n", b"\r\n"),
        lambda text: text.replace(b"\n", b"\r"),
        lambda text: text.replace(b"\n", b" "),
        lambda text: text.replace(b"solid ground", b"solid"),
        lambda text: text.replace(b"solid ground", b"solid vertex plate"),
        lambda text: text.replace(b"solid ground", b"solid a facet normal of vertex 1 2 3 and 4"),
        lambda text: text.replace(b"endsolid ground", b"endsolid vertex facet"),
        lambda text: text + b"solid nothing\nendsolid nothing\n",
        lambda text: text + b"\xff\xfe",
        lambda text: text.replace(b"ground", "Gelände".encode()),
    ],
)
def test_texts_of_stl_were_told_by_their_small_letters_and_names(
    tmp_path: Path, change: Callable[[bytes], bytes]
) -> None:
    triangles = _mesh()
    assert parse_mesh(change(text_stl(triangles))) == pytest.approx(triangles, abs=1e-6)
    path = tmp_path / "ground.txt"  # told by its content
    path.write_bytes(change(text_stl(_BOX)))
    assert load_terrain(path).height.shape == (20, 20)


@pytest.mark.parametrize("counts", [(4, 2), (2, 4), (3, 4, 3), (3, 2), (6,), (3, 0, 3), (1,)])
def test_facets_of_other_than_three_corners_were_joined(counts: tuple[int, ...]) -> None:
    facets = "".join(
        "facet normal 0 0 1\nouter loop\n" + "vertex 1 2 3\n" * count + "endloop\nendfacet\n"
        for count in counts
    )
    with pytest.raises(MapError, match="a facet of the STL mesh has not three corners"):
        parse_mesh(f"solid\n{facets}endsolid\n".encode())


@pytest.mark.parametrize("kind", _PLY)
def test_faces_of_many_corners_are_fans(kind: str) -> None:
    header = (
        f"ply\nformat {kind} 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement face 2\nproperty list uchar uint vertex_index\nend_header\n"
    ).encode()
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 2]], dtype=float)
    if kind == "ascii":
        body = b"\n".join(b" ".join(b"%g" % v for v in p) for p in points) + b"\n4 0 1 2 3\n3 0 1 4"
    else:
        order = "<" if "little" in kind else ">"
        body = b"".join(struct.pack(order + "3f", *p) for p in points)
        body += struct.pack(order + "B4I", 4, 0, 1, 2, 3) + struct.pack(order + "B3I", 3, 0, 1, 4)
    expected = points[[[0, 1, 2], [0, 2, 3], [0, 1, 4]]]
    assert parse_mesh(header + body) == pytest.approx(expected)


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
@settings(deadline=None, max_examples=50)
def test_the_highest_surface_is_that_of_the_slow_way(seed: int, count: int) -> None:
    triangles = np.random.default_rng(seed).uniform(-0.3, 1.3, (count, 3, 3))
    rows, cols, cell = 8, 10, 0.1
    seen = highest_surface(triangles, cell, rows, cols)
    for row in range(rows):
        for col in range(cols):
            best = -np.inf
            for a, b, c in triangles:
                sides = np.column_stack((b[:2] - a[:2], c[:2] - a[:2]))
                point = np.array([(col + 0.5) * cell, (row + 0.5) * cell]) - a[:2]
                s, t = np.linalg.solve(sides, point)
                if min(s, t, 1.0 - s - t) > 1e-9:
                    best = max(best, a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2]))
            if best > -np.inf:
                assert seen[row, col] == pytest.approx(best)
            else:
                assert np.isnan(seen[row, col])
    assert covered_cells(triangles, cell, rows, cols) >= np.isfinite(seen).sum()


def test_the_surface_does_not_depend_on_order_or_sense_of_triangles() -> None:
    triangles = np.random.default_rng(1).uniform(0.0, 1.0, (9, 3, 3))
    one = highest_surface(triangles, 0.05, 20, 20)
    other = highest_surface(np.ascontiguousarray(triangles[::-1, ::-1]), 0.05, 20, 20)
    assert other == pytest.approx(one, nan_ok=True)


def _sheet(cells: int, side: float, height: Callable[[Array, Array], Array]) -> Array:
    """A square sheet of triangles over [0, side]²."""
    v, u = np.meshgrid(*2 * [np.linspace(0.0, side, cells + 1)], indexing="ij")
    points = np.stack([u, v, height(u, v)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate([np.stack([a, b, c], 2), np.stack([a, c, d], 2)]).reshape(-1, 3, 3)


def test_a_sheet_has_no_cracks(tmp_path: Path) -> None:
    mesh = _sheet(40, 2.0, lambda u, v: 0.1 * u + 0.05 * v) + (5.0, -3.0, 1.0)
    path = tmp_path / "sheet.stl"
    path.write_bytes(binary_stl(mesh))
    terrain = load_terrain(path)
    assert terrain.origin == pytest.approx((5.0, -3.0, 0.0))
    assert terrain.height.shape == (40, 40)
    assert (terrain.traversability > 0.0).all()
    y, x = (np.indices((40, 40)) + 0.5) * 0.05
    assert terrain.height == pytest.approx(1.0 + 0.1 * x + 0.05 * y, abs=1e-5)


def test_a_large_mesh_is_taken(tmp_path: Path) -> None:
    mesh = _sheet(300, 30.0, lambda u, v: 0.2 * np.sin(u) * np.sin(v))
    path = tmp_path / "hills.stl"
    path.write_bytes(binary_stl(mesh))
    terrain = load_terrain(path)
    assert terrain.height.shape == (600, 600)


_BOX = _sheet(4, 1.0, lambda u, v: 0.0 * u)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (binary_stl(_BOX)[:-7], "expected an STL mesh of 32 triangles, 1684 bytes; it has 1677"),
        (binary_stl(_BOX[:0]), "there is no triangle in the mesh"),
        (b"solid x\nendsolid", "there is no triangle in the mesh"),
        (b"solid x\nvertex 1 2 x\n", "expected three numbers after each `vertex`"),
        (b"solid x\nvertex 1 2 3\n", "has not three corners"),
        (binary_stl(_BOX * np.nan), "a corner of the mesh is not finite"),
        (binary_stl(_BOX * 1e5), "mesh: 2000000 x 2000000 cells are too many"),
        (binary_stl(_BOX * 1e9), "expected a mesh within ±1e+06 m"),
        (binary_stl(_BOX + (0, 0, 1e6)), "expected heights within ±10000 m"),
        (binary_stl(_BOX * 0.01), "mesh: 0 x 0 cells are no terrain"),
        (b"ply\nformat ascii 1.0\n", "the header of the PLY mesh has no end"),
        (b"ply\nformat xml 1.0\nend_header\n", "unknown format of the PLY mesh (one of: ascii"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n", "unknown type"),
        (
            b"ply\nformat ascii 1.0\nsurprise\nend_header\n",
            "cannot read the line of the PLY header",
        ),
        (b"ply\nformat ascii 1.0\nend_header\n", "expected vertices with x, y and z"),
        (ply(_BOX, "ascii")[:-30], "the PLY mesh is truncated or damaged"),
        (ply(_BOX, "binary_big_endian")[:-30], "the PLY mesh is truncated or damaged"),
        (
            ply(_BOX, "ascii").replace(b"\n3 0 1 2", b"\n3 0 1 999"),
            "names a vertex that is not there",
        ),
    ],
)
def test_bad_meshes_are_one_clear_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bad.stl"
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        load_terrain(path)
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@given(st.data())
@_FEW
def test_damaged_meshes_never_end_in_a_traceback(tmp_path: Path, data: st.DataObject) -> None:
    good = data.draw(
        st.sampled_from([binary_stl(_BOX), text_stl(_BOX), *(ply(_BOX, k, True) for k in _PLY)])
    )
    content = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / "m.stl"
    path.write_bytes(content[: data.draw(st.integers(len(content) // 2, len(content)))])
    try:
        said = repr(load_terrain(path))
    except MapError as error:
        said = str(error)
    assert "\n" not in said


class TestDataOfOthers:
    """Meshes of Quad-SDK; their tops lie at 0.1 m."""

    def test_small_ones_that_failed(self, shared_data: Callable[[str], Path]) -> None:
        for path in sorted(shared_data("cases/stl").glob("*.stl")):
            if "4" in path.name:
                with pytest.raises(MapError, match="has not three corners"):
                    load_terrain(path)
            else:
                assert load_terrain(path).height.shape == (40, 40)

    @pytest.mark.parametrize(
        ("name", "top", "hole"),
        [
            ("flat", 0.1, 0.0),
            ("gap_20cm", 0.1, 0.3),
            ("gap_40cm", 0.1, 0.5),
            ("step_25cm", 0.35, 0.0),
        ],
    )
    def test_gaps_and_steps(
        self, shared_data: Callable[[str], Path], name: str, top: float, hole: float
    ) -> None:
        terrain = load_terrain(shared_data(f"terrain/quad_sdk/{name}/{name}.stl"))
        assert terrain.size == pytest.approx((9.0, 4.0))
        assert terrain.height.max() == pytest.approx(top, abs=1e-6)
        # Without ground in between, and a cell on each side where no foot may stand.
        assert (terrain.traversability[40] == 0.0).sum() * 0.05 == pytest.approx(hole)

    def test_rough_ground(self, shared_data: Callable[[str], Path]) -> None:
        terrain = load_terrain(shared_data("terrain/quad_sdk/rough_25cm/rough_25cm.stl"))
        assert terrain.size == pytest.approx((10.0, 8.0))
        assert np.ptp(terrain.height) == pytest.approx(0.25, abs=0.02)
