"""Terrain files: what they mean, and one clear line for what they may not be."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import png
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from cavalcade.errors import MapError
from cavalcade.geometry import Array
from cavalcade.world import MapWarning, load_terrain

Write = Callable[..., Path]

_FEW = settings(
    max_examples=120,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture
def described(tmp_path: Path) -> Write:
    """Writes a description with these keys."""

    def write(**keys: Any) -> Path:
        path = tmp_path / "t.yaml"
        path.write_text(yaml.safe_dump(keys), encoding="utf-8")
        return path

    return write


def _heights(rows: int = 8, cols: int = 10) -> Array:
    return np.random.default_rng(0).integers(0, 200, (rows, cols)) / 1000.0


def _refused(path: Path, cell: float = 0.05) -> str:
    with pytest.raises(MapError) as caught:
        load_terrain(path, cell)
    said = str(caught.value)
    assert "\n" not in said
    assert len(said) < 700
    return said


def _survives(path: Path) -> None:
    """A terrain or one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            said = repr(load_terrain(path))
    except MapError as error:
        said = str(error)
    assert "\n" not in said


class TestPictures:
    def test_8_bits(self, tmp_path: Path, described: Write) -> None:
        grey = np.random.default_rng(0).integers(0, 256, (8, 10)).astype(np.uint8)
        Image.fromarray(grey).save(tmp_path / "p.png")
        path = described(file="p.png", resolution=0.05, height=[-0.1, 0.5], origin=[1, 2, 0.5])
        terrain = load_terrain(path)
        # The first row of a picture is at its top, the highest y.
        assert terrain.height == pytest.approx(-0.1 + 0.6 * grey[::-1] / 255.0)
        assert terrain.origin == (1.0, 2.0, 0.5)
        down = load_terrain(described(file="p.png", resolution=0.05, height=1, first_row="bottom"))
        assert down.height == pytest.approx(grey / 255.0)

    def test_16_bits_are_not_thrown_away(self, tmp_path: Path, described: Write) -> None:
        grey = np.random.default_rng(0).integers(0, 65536, (6, 6)).astype(np.uint16)
        Image.fromarray(grey).save(tmp_path / "p.png")
        terrain = load_terrain(described(file="p.png", resolution=0.05, height=0.4))
        assert terrain.height == pytest.approx(0.4 * grey[::-1] / 65535.0, abs=1e-9)

    @pytest.mark.parametrize("interlace", [False, True])
    @pytest.mark.parametrize(("greyscale", "alpha"), [(0, 0), (0, 1), (1, 1), (1, 0)])
    def test_colours_of_16_bits_were_cut_to_8(
        self, tmp_path: Path, described: Write, greyscale: int, alpha: int, interlace: bool
    ) -> None:
        grey = np.random.default_rng(0).integers(0, 65536, (9, 7)).astype(np.uint16)
        layers = [grey] * (1 if greyscale else 3) + [np.full_like(grey, 65535)] * alpha
        if alpha:
            layers[-1] = layers[-1].copy()
            layers[-1][4, 2:4] = (32767, 32768)
        table = np.stack(layers, axis=2)
        writer = png.Writer(
            7, 9, bitdepth=16, greyscale=bool(greyscale), alpha=bool(alpha), interlace=interlace
        )
        with (tmp_path / "p.png").open("wb") as stream:
            writer.write(stream, table.reshape(9, -1).tolist())
        terrain = load_terrain(described(file="p.png", resolution=0.05, height=10.0))
        expected = 10.0 * grey[::-1] / 65535.0
        holes = terrain.in_hole([[0.125, 0.225], [0.175, 0.225]])
        if alpha:
            assert holes[0]
            assert terrain.height[4, 3] == pytest.approx(expected[4, 3], abs=1e-9)
            expected[4, 2] = terrain.height[4, 2]
        assert terrain.height == pytest.approx(expected, abs=1e-9)

    def test_colours_of_16_bits_are_brought_to_their_luminance(
        self, tmp_path: Path, described: Write
    ) -> None:
        rows = [[1000, 20000, 40000] * 4, [65535, 0, 0] * 4]
        with (tmp_path / "p.png").open("wb") as stream:
            png.Writer(4, 2, bitdepth=16, greyscale=False).write(stream, rows)
        terrain = load_terrain(described(file="p.png", resolution=0.05, height=1.0))
        assert terrain.height[0, 0] == pytest.approx(0.299)
        assert terrain.height[1, 0] == pytest.approx((299 + 11740 + 4560) / 65535)

    @pytest.mark.parametrize(("depth", "mark"), [(8, 0), (8, 255), (16, 0), (16, 65535), (16, 77)])
    def test_a_grey_may_stand_for_missing_heights(
        self, tmp_path: Path, described: Write, depth: int, mark: int
    ) -> None:
        grey = np.full((20, 20), 60, dtype=f"uint{depth}")
        grey[5:8, 10:12] = mark
        Image.fromarray(grey).save(tmp_path / "p.png")
        said = {"file": "p.png", "resolution": 0.05, "height": 0.2 * (2**depth - 1) / 60}
        terrain = load_terrain(described(**said, nodata=mark))
        assert terrain.height == pytest.approx(np.full((20, 20), 0.2))
        assert (terrain.traversability[12:15, 10:12] == 0.0).all()

    def test_what_is_transparent_is_a_hole(self, tmp_path: Path, described: Write) -> None:
        pixels = np.full((20, 20, 4), 255, dtype=np.uint8)
        pixels[5:8, 10:12, 3] = 0
        Image.fromarray(pixels).save(tmp_path / "p.png")
        terrain = load_terrain(described(file="p.png", resolution=0.05, height=0.4))
        assert terrain.height == pytest.approx(np.full((20, 20), 0.4))
        assert (terrain.traversability[12:15, 10:12] == 0.0).all()
        assert (terrain.traversability == 0.0).sum() == 5 * 4
        filled = load_terrain(described(file="p.png", resolution=0.05, height=0.4, holes="fill"))
        assert (filled.traversability > 0.9).all()
        pixels[..., 3] = 0
        Image.fromarray(pixels).save(tmp_path / "p.png")
        line = _refused(described(file="p.png", resolution=0.05, height=0.4))
        assert "all are nan" in line

    def test_a_huge_one_is_refused_by_its_header(self, tmp_path: Path, described: Write) -> None:
        Image.fromarray(np.zeros((5000, 5000), dtype=np.uint8)).save(tmp_path / "p.png")
        line = _refused(described(file="p.png", resolution=0.05, height=1.0))
        assert "5000 x 5000 heights are too many, at most 16 million are read" in line


class TestTables:
    @pytest.mark.parametrize("mark", [",", ";", " ", "\t", ", "])
    def test_csv(self, tmp_path: Path, described: Write, mark: str) -> None:
        heights = _heights()
        lines = [mark.join(f"{value:.3f}" for value in row) for row in heights]
        (tmp_path / "h.csv").write_text("# heights\n" + "\n".join(lines) + "\n\n")
        terrain = load_terrain(described(file="h.csv", resolution=0.05))
        assert terrain.height == pytest.approx(heights)
        twice = load_terrain(described(file="h.csv", resolution=0.05, scale=2, first_row="top"))
        assert twice.height == pytest.approx(2.0 * heights[::-1])

    def test_empty_fields_and_nan_are_holes(self, tmp_path: Path, described: Write) -> None:
        (tmp_path / "h.csv").write_text(
            "0,0,0,0,,0,0\n" * 3 + "0,0,0,0,0,0,nan,\n" + ",0,0,0,0,0,0\n"
        )
        terrain = load_terrain(described(file="h.csv", resolution=0.05))
        holes = terrain.traversability == 0.0
        assert terrain.height.shape == (5, 7)
        assert holes[3, 0]
        assert holes[0, 3:6].all()
        assert holes[3, 5:].all()
        assert not holes[:3, 1].any()

    def test_archives(self, tmp_path: Path, described: Write) -> None:
        heights = _heights()
        np.savez(tmp_path / "h.npz", height=heights, resolution=0.05, origin=[1.0, 2.0])
        terrain = load_terrain(tmp_path / "h.npz")
        assert terrain.height == pytest.approx(heights)
        assert terrain.origin == (1.0, 2.0, 0.0)
        np.savez_compressed(tmp_path / "g.npz", ground=heights.astype(np.float32))
        assert load_terrain(described(file="g.npz", resolution=0.05)).height == pytest.approx(
            heights, abs=1e-6
        )

    def test_triples(self, tmp_path: Path, described: Write) -> None:
        heights = _heights()
        y, x = np.indices(heights.shape) * 0.2
        for name, table in (("x", x - 1.0), ("y", y + 3.0), ("z", heights)):
            np.savetxt(tmp_path / f"{name}_data.csv", table, delimiter=",", fmt="%.6g")
        terrain = load_terrain(tmp_path)
        assert terrain.origin == pytest.approx((-1.0, 3.0, 0.0))
        assert terrain.size == pytest.approx((1.8, 1.4))
        assert terrain.heights_at([(-0.2 + 0.025, 3.4 + 0.025)])[0] == pytest.approx(
            terrain.height[8, 16]
        )
        # At a cell's centre right beside a sample, an eighth of the way to the next one.
        s = 0.125
        corner = heights[2:4, 4:6]
        mixed = (1 - s) ** 2 * corner[0, 0] + s * (1 - s) * (corner[0, 1] + corner[1, 0])
        assert terrain.height[8, 16] == pytest.approx(mixed + s * s * corner[1, 1])
        named = described(file="z_data.csv", x="x_data.csv", y="y_data.csv")
        assert load_terrain(named) == terrain


def _with_marks(mark: float, low: float = 0.0, high: float = 0.4) -> Array:
    heights = np.linspace(low, high, 400).reshape(20, 20)
    heights[5:8, 10:12] = mark
    return heights


class TestMissingHeights:
    @pytest.mark.parametrize("kind", ["csv", "npz", "triple"])
    @pytest.mark.parametrize("mark", [-9999.0, -32768.0, 1e20, -3.4028235e38, 0.0, -1.0])
    def test_numbers_for_missing_heights_became_pits(
        self, tmp_path: Path, described: Write, kind: str, mark: float
    ) -> None:
        heights = _with_marks(mark, 0.1)
        said: dict[str, Any] = {"file": "h.csv", "nodata": mark}
        if kind == "npz":
            said["file"] = "h.npz"
            np.savez(tmp_path / "h.npz", height=heights.astype(np.float32))
        else:
            np.savetxt(tmp_path / "h.csv", heights, "%.7g", ",")
        if kind == "triple":
            y, x = np.indices((20, 20)) * 0.05
            np.savetxt(tmp_path / "x.csv", x, delimiter=",")
            np.savetxt(tmp_path / "y.csv", y, delimiter=",")
            said |= {"x": "x.csv", "y": "y.csv"}
        else:
            said["resolution"] = 0.05
        terrain = load_terrain(described(**said))
        assert terrain.height.min() >= 0.099
        assert terrain.height.max() <= 0.401
        assert (terrain.traversability[6, 10:12] == 0.0).all()
        filled = load_terrain(described(**said, holes="fill"))
        assert (filled.traversability > 0.0).all()

    @pytest.mark.parametrize(
        ("mark", "high", "warned"),
        [
            (-9999.0, 0.4, True),
            (-9999.0, 900.0, True),
            (-9999.0, 5000.0, True),  # in mm
            (-9999.0, 10000.0, False),  # it may well be one of them
            (-99.0, 0.4, False),
            (-101.0, 0.4, True),
            (-101.0, 12.0, False),
            (150.0, 0.4, True),
            (0.4, 0.4, False),
        ],
    )
    def test_numbers_that_look_like_missing_heights_are_warned_about(
        self, tmp_path: Path, described: Write, mark: float, high: float, warned: bool
    ) -> None:
        np.savez(tmp_path / "h.npz", height=_with_marks(mark, 0.0, high))
        path = described(file="h.npz", resolution=0.05)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            terrain = load_terrain(path)
        assert (mark in terrain.height) or not warned
        assert [one.category for one in caught] == [MapWarning] * warned
        if warned:
            assert f"h.npz: heights of {mark:g} look as if" in str(caught[0].message)
            assert f"nodata: {mark:g}" in str(caught[0].message)

    def test_numbers_beyond_all_heights_are_named(self, tmp_path: Path, described: Write) -> None:
        np.savez(tmp_path / "h.npz", height=_with_marks(-3.4028235e38))
        line = _refused(described(file="h.npz", resolution=0.05))
        assert "expected nodata: -3.40282e+38 in its description" in line

    @pytest.mark.parametrize("value", ["none", ".nan", [1], ".inf"])
    def test_nodata_is_a_number(self, tmp_path: Path, described: Write, value: Any) -> None:
        np.savez(tmp_path / "h.npz", height=_heights())
        line = _refused(described(file="h.npz", resolution=0.05, nodata=value))
        assert "t.yaml: nodata: expected a finite number" in line


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("h.csv", b"1,2,3\n# and\n\n4,5\n", "h.csv: line 4: 2 numbers, where the lines"),
        ("h.csv", b"1 2 3\n4 5 6 7\n", "h.csv: line 2: 4 numbers, where"),
        ("h.csv", b"1,2\n3,x\n", "h.csv: line 2: expected numbers"),
        ("h.csv", b"height,width\n3,4\n", "h.csv: line 1: expected numbers"),
        ("dem.tif", b"II*\0" + bytes(40), "dem.tif: unknown format .tif; expected a description"),
        ("dem.asc", b"ncols 4\n", "dem.asc: unknown format .asc; expected"),
        ("dem", b"II*\0" + bytes(40), "dem: expected a description in YAML with file"),
    ],
)  # fmt: skip
def test_messages_of_libraries_came_through(
    tmp_path: Path, described: Write, name: str, content: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(content)
    assert message in _refused(
        described(file=name, resolution=0.05) if "csv" in name else tmp_path / name
    )
    if name == "dem.tif":
        assert message in _refused(described(file=name, resolution=0.05))


def test_coarser_cells_are_bilinear_finer_ones_averages(described: Write, tmp_path: Path) -> None:
    y, x = np.indices((40, 60)) * 0.1
    plane = 0.2 * x - 0.1 * y
    np.savez(tmp_path / "h.npz", height=plane, resolution=0.1)
    rows, cols = np.indices((80, 120))
    terrain = load_terrain(tmp_path / "h.npz")
    inner = np.s_[2:-2, 2:-2]
    expected = 0.2 * ((cols + 0.5) * 0.05 - 0.05) - 0.1 * ((rows + 0.5) * 0.05 - 0.05)
    assert terrain.height[inner] == pytest.approx(expected[inner])
    np.savez(tmp_path / "h.npz", height=plane, resolution=0.01)
    fine = load_terrain(tmp_path / "h.npz")
    assert fine.height == pytest.approx(plane.reshape(8, 5, 12, 5).mean(axis=(1, 3)))


def test_holes_keep_their_place_on_another_grid(tmp_path: Path) -> None:
    heights = np.zeros((20, 20))
    heights[5:9, 10:14] = np.nan
    np.savez(tmp_path / "h.npz", height=heights, resolution=0.1)
    hole = load_terrain(tmp_path / "h.npz").traversability == 0.0
    rows, cols = np.nonzero(hole)
    assert (rows.min(), rows.max()) == (9, 18)
    assert (cols.min(), cols.max()) == (19, 28)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "t.yaml: file: expected the name of a file"),
        ({"file": 3}, "file: expected the name of a file"),
        ({"file": "no.png"}, "no.png: no such file"),
        ({"file": "h.csv"}, "t.yaml: resolution: is missing"),
        ({"file": "h.csv", "resolution": "fine"}, "t.yaml: resolution: expected a finite number"),
        ({"file": "h.csv", "resolution": 0}, "t.yaml: resolution: expected metres per cell"),
        ({"file": "h.csv", "resolution": 0.05, "heigth": 1}, "heigth: unknown key (one of: file,"),
        (
            {"file": "h.csv", "resolution": 0.05, "height": 1},
            "height: is for pictures; expected sc",
        ),
        ({"file": "h.csv", "resolution": 0.05, "scale": 0}, "scale: expected a number from 1e-6"),
        ({"file": "h.csv", "resolution": 0.05, "origin": [1]}, "origin: expected three numbers"),
        (
            {"file": "h.csv", "resolution": 0.05, "holes": "dig"},
            "holes: expected another value (one",
        ),
        ({"file": "h.csv", "resolution": 1e-4}, "h.csv: heights: 0 x 0 cells are no terrain"),
        ({"file": "h.csv", "x": "no.csv", "y": "h.csv"}, "no.csv: no such file"),
        ({"file": "h.csv", "x": "h.csv", "y": "h.csv"}, "h.csv: h.csv gives no even grid"),
        ({"file": "p.png", "resolution": 0.05}, "t.yaml: height: is missing; expected metres of"),
        ({"file": "p.png", "resolution": 0.05, "height": [1]}, "height: expected [black, white]"),
        ({"file": "p.png", "height": 1}, "t.yaml: resolution: is missing"),
        (
            {"file": "p.png", "resolution": 0.05, "height": 1, "scale": 2},
            "scale: a picture has non",
        ),
        ({"file": "one.csv", "resolution": 0.05}, "one.csv: heights: 1 x 1 cells are no terrain"),
        ({"file": "nan.csv", "resolution": 0.05}, "nan.csv: heights: expected at least one height"),
        (
            {"file": "odd.csv", "resolution": 0.05},
            "odd.csv: line 2: 3 numbers, where the lines",
        ),
        ({"file": "word.csv", "resolution": 0.05}, "word.csv: line 2: expected numbers"),
        (
            {"file": "inf.csv", "resolution": 0.05},
            "inf.csv: heights: expected finite heights or nan",
        ),
        ({"file": "empty.csv", "resolution": 0.05}, "empty.csv: there is no number in it"),
        ({"file": "bad.npz", "resolution": 0.05}, "bad.npz: not a readable NPZ archive"),
        ({"file": "cube.npz", "resolution": 0.05}, "cube.npz: expected an array `height`"),
        ({"file": "words.npz", "resolution": 0.05}, "words.npz: expected numbers in the array"),
        ({"file": "t.yaml"}, "file: expected a PNG, NPZ, CSV, STL or PLY file"),
    ],
)
def test_bad_files_are_one_clear_line(
    tmp_path: Path, described: Write, keys: dict[str, Any], message: str
) -> None:
    Image.fromarray(np.zeros((4, 4), dtype=np.uint8)).save(tmp_path / "p.png")
    for name, text in (
        ("h.csv", "0,0,0\n0,0,1\n"),
        ("one.csv", "1\n"),
        ("nan.csv", "nan,nan\nnan,nan\n"),
        ("odd.csv", "1,2\n1,2,3\n"),
        ("word.csv", "1,2\n1,two\n"),
        ("inf.csv", "1,inf\n1,2\n"),
        ("empty.csv", "\n# nothing\n"),
    ):
        (tmp_path / name).write_text(text)
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04rubbish")
    np.savez(tmp_path / "cube.npz", cube=np.zeros((2, 2, 2)))
    np.savez(tmp_path / "words.npz", height=np.array([["a", "b"], ["c", "d"]]))
    assert message in _refused(described(**keys))


def test_a_picture_alone_does_not_say_its_scale(tmp_path: Path) -> None:
    Image.fromarray(np.zeros((4, 4), dtype=np.uint8)).save(tmp_path / "p.png")
    assert "a picture needs a description in YAML" in _refused(tmp_path / "p.png")
    (tmp_path / "h.csv").write_text("0,0\n0,0\n")
    assert "a table needs a description in YAML" in _refused(tmp_path / "h.csv")
    assert "no such file" in _refused(tmp_path / "no.stl")
    (tmp_path / "folder").mkdir()
    assert "x_data.csv: no such file" in _refused(tmp_path / "folder")


def test_an_archive_that_unpacks_to_too_much(tmp_path: Path) -> None:
    np.savez_compressed(
        tmp_path / "h.npz", height=np.zeros((5000, 5000), np.uint8), resolution=0.05
    )
    assert "5000 x 5000 heights are too many" in _refused(tmp_path / "h.npz")
    assert os.path.getsize(tmp_path / "h.npz") < 1_000_000


@given(
    st.binary(max_size=200), st.sampled_from(["", "ply\n", "solid ", "\x89PNG\r\n\x1a\n", "PK\3\4"])
)
@_FEW
def test_random_bytes_end_in_one_line(tmp_path: Path, content: bytes, head: str) -> None:
    for name in ("t.yaml", "t.csv", "t.stl"):
        path = tmp_path / name
        path.write_bytes(head.encode("latin-1") + content)
        _refused(path)


@given(st.text(alphabet="0123456789.,;-+enai \n\t#", max_size=60))
@_FEW
def test_random_tables(tmp_path: Path, described: Write, text: str) -> None:
    (tmp_path / "h.csv").write_text(text)
    _survives(described(file="h.csv", resolution=0.05))


@given(st.data())
@_FEW
def test_damaged_files(tmp_path: Path, described: Write, data: st.DataObject) -> None:
    """Some bytes of good files are changed or cut off."""
    Image.fromarray(np.arange(16, dtype=np.uint8).reshape(4, 4)).save(tmp_path / "p.png")
    np.savez(tmp_path / "h.npz", height=_heights(4, 4), resolution=0.05)
    name = data.draw(st.sampled_from(["p.png", "h.npz"]))
    content = bytearray((tmp_path / name).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (tmp_path / name).write_bytes(content[: data.draw(st.integers(0, len(content)))])
    keys = {"height": 1.0} if name == "p.png" else {}
    _survives(described(file=name, resolution=0.05, **keys))


class TestDataOfOthers:
    """Files nobody here wrote."""

    @pytest.mark.parametrize(
        ("name", "size", "holes"), [("rough_terrain", (11, 6), 0), ("step", (11, 6), 0)]
    )
    def test_quad_sdk_tables(
        self, shared_data: Callable[[str], Path], name: str, size: tuple[float, float], holes: int
    ) -> None:
        terrain = load_terrain(shared_data(f"terrain/quad_sdk/csv/{name}"))
        assert terrain.size == pytest.approx(size)
        assert terrain.origin == (-1.0, -3.0, 0.0)
        assert (terrain.traversability == 0.0).sum() == holes

    def test_anymal_pictures(self, shared_data: Callable[[str], Path], described: Write) -> None:
        file = shared_data("terrain/anymal/real_stairs_125cm.png")
        path = described(
            file=os.path.relpath(file, described(a=1).parent), resolution=0.04, height=1.25
        )
        terrain = load_terrain(path)
        assert terrain.size == pytest.approx((4.88, 2.84), abs=0.05)
        assert 0.5 < terrain.height.max() <= 1.25
        assert 0.0 < (terrain.traversability == 0.0).mean() < 0.5
