"""Files that may be anything: each is read, or refused in one line of our own, and gives no nan.

Files of every kind are damaged: values of descriptions replaced, renamed and repeated, bytes of
pictures, tables and meshes changed and cut off. The cases are the same in every run; `FUZZ_CASES`
says how many of each kind there are (20 if it is not set):

    FUZZ_CASES=1000 .venv/bin/python -m pytest -q tests/fuzz
"""

from __future__ import annotations

import copy
import io
import os
import re
import struct
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import png
import pytest
import yaml
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st
from PIL import Image

from cavalcade.campaign.suite import SUITES, load_suite
from cavalcade.checking.mapfile import read_movingai, read_ros_map
from cavalcade.errors import CavalcadeError, RecordingError
from cavalcade.locomotion import LegControl
from cavalcade.robots import load_model, robot_model
from cavalcade.scenario import (
    ScenarioWarning,
    build_world,
    dump_scenario,
    import_problem,
    load_scenario,
    resolve_scenario,
    scenario_names,
)
from cavalcade.scenario.shipped import LIBRARY
from cavalcade.scenario.spellings import RenamedWarning
from cavalcade.world import (
    MapWarning,
    OccupancyMap,
    load_barn,
    load_map,
    load_movingai,
    load_terrain,
)

Files = dict[str, bytes]

_MANY = settings(
    max_examples=int(os.environ.get("FUZZ_CASES", "20")),
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
_RANDOM = st.integers(0, 2**40).map(Random)

_ODD: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 2, -0.0, 0.5, 1e-3, 1e-9, 1e-300, 5e-324, 90, 1e5, 1e6, 1e7),
    *(1e308, 2**31, 2**63, -(2**63), 10**400, float("nan"), float("inf"), float("-inf"), -9999),
    *("", " ", "x", "0.5", "1e400", "1e-3", "nan", "no", "../x", "a\nb", "\x00", "ü", "2024-01-01"),
    *([], {}, [1], [1, 2], [1, 2, 3], [[1, 2], [3]], ["a", None], {"a": 1}, [[]], [[[0]]]),
)


def damaged_data(data: Any, random: Random) -> Any:
    """Plain data of a file with a few values replaced, moved, renamed, removed or repeated."""
    data = copy.deepcopy(data)
    names = sorted(_names(data))
    for _ in range(random.choice((0, 1, 1, 1, 2, 3, 6))):
        here = data
        while isinstance(here, dict | list) and here:
            key: Any = random.choice(list(here) if isinstance(here, dict) else range(len(here)))
            if isinstance(here[key], dict | list) and here[key] and random.random() < 0.75:
                here = here[key]
                continue
            _change(here, key, names, random)
            break
    return data


def _change(here: Any, key: Any, names: list[str], random: Random) -> None:
    value, change = here[key], random.randrange(7)
    if change == 0:
        del here[key]
    elif change == 1 and isinstance(here, dict):
        here[random.choice(names)] = here.pop(key)
    elif change == 2 and isinstance(here, list):
        here[key:key] = [copy.deepcopy(value)] * random.choice((1, 2, 20))
    elif change == 3 and type(value) in (int, float) and abs(value) < 1e200:
        here[key] = value * random.choice((-1, 0, 0.1, 0.999, 1.001, 10, 1e3, 1e9, 1e100))
    elif change == 4 and isinstance(here, dict):
        here[random.choice(names)] = copy.deepcopy(value)
    else:
        here[key] = copy.deepcopy(random.choice(_ODD))


def _names(data: Any) -> set[str]:
    if isinstance(data, list):
        return set().union(*map(_names, data)) if data else {"a"}
    return set(data).union(*map(_names, data.values())) if isinstance(data, dict) else {"a"}


def damaged_bytes(content: bytes, random: Random) -> bytes:
    """A file with a few bytes changed, put in, taken out or repeated, or with its end cut off."""
    data = bytearray(content)
    for _ in range(random.choice((0, 1, 1, 2, 4, 10))):
        at, change = random.randrange(len(data) + 1), random.randrange(6)
        if change == 0:
            data[at : at + 1] = bytes([random.randrange(256)])
        elif change == 1:
            data[at:at] = random.choice(
                (b"\0", b"\n", b"-", b"9", b"e9", b",", b" ", b"nan", b"\xff")
            )
        elif change == 2:
            del data[at : at + random.choice((1, 4, 20))]
        elif change == 3:
            part = data[at : at + random.choice((1, 8, 60))]
            data[at:at] = part
        elif change == 4 and len(data) > 8:
            at = random.randrange(len(data) - 4)
            number = random.choice((0, 1, 255, 65535, 2**31 - 1, 2**32 - 1))
            data[at : at + 4] = struct.pack(random.choice("<>") + "I", number)
        elif random.random() < 0.3:
            del data[at:]
    return bytes(data)


def mended_png(content: bytes) -> bytes:
    """A damaged PNG whose checksums are right again, so that its content is looked at."""
    at, out = 8, bytearray(content[:8])
    while at + 12 <= len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        if length > len(content) - at - 12:
            break
        chunk = content[at + 4 : at + 8 + length]
        out += content[at : at + 4] + chunk + struct.pack(">I", zlib.crc32(chunk))
        at += 12 + length
    return bytes(out + content[at:])


def as_yaml(data: Any) -> bytes:
    """A description as a file; text that no file can hold is replaced."""
    return yaml.safe_dump(data, allow_unicode=True).encode("utf-8", "replace")


def _picture(random: Random, rows: int, cols: int) -> tuple[str, bytes]:
    """A picture of any kind that is read, and a few that are not."""
    rng = np.random.default_rng(random.randrange(2**32))
    kind = random.choice(("P2", "P5", "P5-16", "L", "LA", "RGB", "RGBA", "P", "1", "I;16", "deep"))
    grey = rng.choice(np.array([0, 50, 100, 205, 254, 255], np.uint8), (rows, cols))
    if kind == "P2":
        text = " ".join(map(str, grey.ravel()))
        return "pgm", f"P2\n# by hand\n{cols} {rows}\n255\n{text}\n".encode()
    if kind.startswith("P5"):
        deep = kind == "P5-16"
        body = (grey.astype(">u2") * 257).tobytes() if deep else grey.tobytes()
        return "pgm", b"P5\n%d %d\n%d\n" % (cols, rows, 65535 if deep else 255) + body
    stream = io.BytesIO()
    if kind == "deep":
        planes = random.choice((2, 3, 4))
        table = rng.integers(0, 65536, (rows, cols * planes)).tolist()
        writer = png.Writer(
            cols, rows, bitdepth=16, greyscale=planes == 2, alpha=planes != 3,
            interlace=random.random() < 0.3,
        )  # fmt: skip
        writer.write(stream, table)
    elif kind == "I;16":
        Image.fromarray(grey.astype(np.uint16) * 257).save(stream, "PNG")
    else:
        Image.fromarray(grey).convert(kind).save(stream, "PNG")
    return "png", stream.getvalue()


def _written(folder: Path, files: Files) -> None:
    for name, content in files.items():
        (folder / name).write_bytes(content)


def _read(read: Callable[[], Any], folder: Path) -> Any:
    """What is read, or None if it is refused in one line; other warnings than ours are errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in (ScenarioWarning, MapWarning, RenamedWarning):
            warnings.simplefilter("ignore", kind)
        warnings.filterwarnings("ignore", "Inertia matrix is too close", UserWarning)  # MuJoCo's
        try:
            return read()
        except CavalcadeError as error:
            said = str(error)
    assert "\n" not in said
    assert 0 < len(said) < 3000
    assert error_names_the_file(said, folder), said
    return None


def error_names_the_file(said: str, folder: Path) -> bool:
    """Whether a refusal begins with one of the files it is about."""
    return said.startswith(str(folder))


@given(_RANDOM)
@_MANY
def test_scenarios(tmp_path: Path, random: Random) -> None:
    names = [name for name in scenario_names() if name != "office"]
    said = yaml.safe_load((LIBRARY / f"{random.choice(names)}.yaml").read_text("utf-8"))
    said["world"]["obstacles"] = [{"box": {"center": [3, 3], "size": [0.2, 0.3], "yaw": 0.3}}]
    said.setdefault("execution", {})["events"] = [
        {"at": 3.0, "add": {"circle": {"center": [2, 2], "radius": 0.1}}},
        {"at": 5.0, "goals": [[2.0, 2.0, 1.0]]},
    ] * (said["task"].get("goals") != "individual")
    content = as_yaml(damaged_data(said, random))
    if random.random() < 0.2:
        content = damaged_bytes(content, random)
    note(content.decode("utf-8", "replace"))
    path = tmp_path / "s.yaml"
    path.write_bytes(content)
    scenario = _read(lambda: load_scenario(path), tmp_path)
    if scenario is None:
        return
    size = scenario.world.empty or scenario.world.generate
    if size is None or max(size.size) > 30 or scenario.world.resolution < 0.04:
        return  # large worlds, and files that are not there, are legal: it is time that they take
    world = _read(lambda: build_world(scenario), tmp_path)
    if world is None:
        return
    if world.terrain is not None:
        assert np.isfinite(world.terrain.height).all()
    dump_scenario(scenario, tmp_path / "again.yaml")
    again = _read(lambda: load_scenario(tmp_path / "again.yaml"), tmp_path)
    assert again == resolve_scenario(scenario)


@given(_RANDOM)
@_MANY
def test_maps(tmp_path: Path, random: Random) -> None:
    suffix, picture = _picture(random, random.randrange(1, 9), random.randrange(1, 9))
    said: Any = {
        "image": f"m.{suffix}",
        "resolution": 0.05,
        "origin": [1.0, -2.0, 0.3],
        "negate": random.choice((0, 1)),
        "occupied_thresh": random.choice((0.65, 0.196, 0.8)),
        "free_thresh": 0.196,
        "mode": random.choice(("trinary", "scale", "raw")),
    }
    if random.random() < 0.6:
        said = damaged_data(said, random)
    if random.random() < 0.6:
        picture = damaged_bytes(picture, random)
        if suffix == "png" and random.random() < 0.7:
            picture = mended_png(picture)
    _written(tmp_path, {"m.yaml": as_yaml(said), f"m.{suffix}": picture})
    note(str((said, picture)))
    path = tmp_path / "m.yaml"
    unknown: Any = random.choice(("occupied", "free"))
    map = _read(lambda: load_map(path, unknown), tmp_path)
    if map is None:
        return
    assert map.grid.min() >= -1
    assert map.grid.max() <= 100
    assert np.isfinite([map.resolution, *map.origin, *map.size]).all()
    seen = _read(lambda: read_ros_map(path, unknown == "free"), tmp_path)
    if seen is not None:
        _same_cells(map, seen.blocks)


def _same_cells(map: OccupancyMap, blocks: np.ndarray) -> None:
    """The checker's blocks are the map's occupied cells."""
    cells = np.zeros((map.rows, map.cols), dtype=bool)
    for x0, y0, x1, y1 in np.rint(blocks / map.resolution).astype(int):
        cells[y0:y1, x0:x1] = True
    np.testing.assert_array_equal(cells, map.occupied)


def _stl(triangles: np.ndarray, text: bool) -> bytes:
    if text:
        facets = "".join(
            "facet normal 0 0 1\nouter loop\n"
            + "".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in corners)
            + "endloop\nendfacet\n"
            for corners in triangles
        )
        return f"solid hill\n{facets}endsolid hill\n".encode()
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *corners.ravel(), 0) for corners in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


def _ply(triangles: np.ndarray, order: str) -> bytes:
    points = triangles.reshape(-1, 3)
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\nproperty float x\n"
        f"property float y\nproperty float z\nelement face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    faces = np.arange(len(points)).reshape(-1, 3)
    if not order:
        lines = [f"{x:g} {y:g} {z:g}" for x, y, z in points] + [
            f"3 {a} {b} {c}" for a, b, c in faces
        ]
        return head + "\n".join(lines).encode() + b"\n"
    body = b"".join(struct.pack(f"{order}3f", *point) for point in points)
    return head + body + b"".join(struct.pack(f"{order}B3i", 3, *face) for face in faces)


def _heights_file(random: Random) -> tuple[str, bytes]:
    rng = np.random.default_rng(random.randrange(2**32))
    heights = rng.uniform(-0.2, 0.3, (random.randrange(1, 9), random.randrange(1, 9)))
    if random.random() < 0.3:
        heights[0, 0] = random.choice((np.nan, np.inf, -9999.0, 1e20, 32767.0))
    kind = random.choice(("png", "csv", "npz", "stl", "ply"))
    if kind == "png":
        name, content = _picture(random, *heights.shape)
        return name, content
    stream = io.BytesIO()
    if kind == "csv":
        np.savetxt(stream, heights, "%.5g", random.choice((",", ";", " ", "\t")))
        return "csv", stream.getvalue()
    if kind == "npz":
        save = random.choice((np.savez, np.savez_compressed))
        extra = {"resolution": 0.05, "origin": [1.0, 2.0]} if random.random() < 0.5 else {}
        dtype = random.choice((np.float64, np.float32, np.int16, bool, np.complex64, object, "U4"))
        with np.errstate(invalid="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            table = np.nan_to_num(heights) if dtype is np.int16 else heights
            save(stream, **{random.choice(("height", "z", "a")): table.astype(dtype)}, **extra)
        return "npz", stream.getvalue()
    triangles = rng.uniform(0.0, 1.0, (4, 3, 3))
    if kind == "stl":
        return "stl", _stl(triangles, random.random() < 0.5)
    return "ply", _ply(triangles, random.choice(("", "<", ">")))


@given(_RANDOM)
@_MANY
def test_terrains(tmp_path: Path, random: Random) -> None:
    suffix, content = _heights_file(random)
    said: Any = {"file": f"h.{suffix}", "resolution": 0.05, "holes": "keep", "origin": [1, 2, 0.5]}
    if suffix in ("png", "pgm"):
        said["height"] = [0.0, 0.4]
    else:
        said["scale"] = 1.0
    if suffix in ("stl", "ply"):
        del said["resolution"]
    elif random.random() < 0.5:
        said |= {"nodata": -9999, "first_row": "top"}
    if random.random() < 0.5:
        said = damaged_data(said, random)
    if random.random() < 0.7:
        content = damaged_bytes(content, random)
        if suffix == "png" and random.random() < 0.7:
            content = mended_png(content)
    _written(tmp_path, {"t.yaml": as_yaml(said), f"h.{suffix}": content})
    note(str((said, content)))
    for path in (tmp_path / "t.yaml", tmp_path / f"h.{suffix}"):
        terrain = _read(lambda path=path: load_terrain(path, 0.05), tmp_path)
        if terrain is not None:
            for layer in (terrain.height, terrain.smooth, terrain.normals, terrain.traversability):
                assert np.isfinite(layer).all()


_PROBLEM = {
    "environment": {
        "min": [-2, 0],
        "max": [3, 5.01],
        "obstacles": [{"type": "box", "center": [0.5, 2.5], "size": [0.5, 1.0]}],
    },
    "robots": [
        {"type": "unicycle_first_order_0", "start": [-1, 2.5, 0], "goal": [2, 2.5, 1.5]},
        {"type": "unicycle1_sphere_v0", "start": [2, 1, 0], "goal": [-1.8, 1, 3]},
        {"type": "double_integrator_0", "start": [0, 4, 0, 0], "goal": [2.9, 4, 0, 0]},
    ],
}


@given(_RANDOM)
@_MANY
def test_problems(tmp_path: Path, random: Random) -> None:
    content = as_yaml(damaged_data(_PROBLEM, random))
    if random.random() < 0.3:
        content = damaged_bytes(content, random)
    note(str(content))
    path = tmp_path / "p.yaml"
    path.write_bytes(content)
    scenario = _read(lambda: import_problem(path), tmp_path)
    if scenario is None or scenario.world.empty is None:
        return
    dump_scenario(scenario, tmp_path / "s.yaml")
    assert _read(lambda: load_scenario(tmp_path / "s.yaml"), tmp_path) == scenario
    if max(scenario.world.empty.size) < 30:
        world = _read(lambda: build_world(scenario), tmp_path)
        assert world is None or np.isfinite(world.map.origin).all()


@given(_RANDOM)
@_MANY
def test_grid_maps(tmp_path: Path, random: Random) -> None:
    rows, cols = random.randrange(1, 9), random.randrange(1, 9)
    lines = ["".join(random.choice(".GS@OTW..@") for _ in range(cols)) for _ in range(rows)]
    end = random.choice(("\n", "\r\n"))
    head = ["type octile", f"height {rows}", f"width {cols}", "map"]
    path = tmp_path / "g.map"
    path.write_bytes(damaged_bytes(end.join([*head, *lines, ""]).encode(), random))
    note(str(path.read_bytes()))
    map = _read(lambda: load_movingai(path, 0.25), tmp_path)
    if map is not None:
        seen = _read(lambda: read_movingai(path, 0.25), tmp_path)
        if seen is not None:
            _same_cells(map, seen.blocks)


@given(_RANDOM)
@_MANY
def test_lists_of_circles(tmp_path: Path, random: Random) -> None:
    rows = [f"{random.uniform(-2, 3):.6f},{random.uniform(0, 5):.6f},0.075" for _ in range(5)]
    path = tmp_path / "c.csv"
    path.write_bytes(damaged_bytes("\n".join(["x_m,y_m,radius_m", *rows, ""]).encode(), random))
    note(str(path.read_bytes()))
    world = _read(lambda: load_barn(path), tmp_path)
    if world is not None:
        assert np.isfinite([*world.size, *world.offset]).all()
        if max(world.size) < 30:
            _read_map = world.to_map
            assert _read_map().rows > 0


_ROBOT = {
    "name": "mine",
    "length": 0.6,
    "width": 0.3,
    "height": 0.4,
    "max_speed_x": 0.5,
    "max_speed_y": 0.2,
    "max_yaw_rate": 1.2,
    "max_acceleration": 1.0,
    "max_yaw_acceleration": 2.0,
    "tracking_error": 0.02,
    "drive": "legged",
    "round": False,
    "source": "measured",
    "like": "go1",
}


@given(_RANDOM)
@_MANY
def test_robots(tmp_path: Path, random: Random) -> None:
    said = dict(_ROBOT)
    if random.random() < 0.5:
        del said["like"]
    content = as_yaml(damaged_data(said, random))
    if random.random() < 0.3:
        content = damaged_bytes(content, random)
    note(str(content))
    path = tmp_path / "r.yaml"
    path.write_bytes(content)
    model = _read(lambda: load_model(path), tmp_path)
    team = {
        "version": 1,
        "name": "t",
        "world": {"empty": {"size": [300, 300]}, "resolution": 1.0},
        "robots": [{"model": "r.yaml", "start": [150, 150, 0], "goal": [20, 20, 0]}],
        "task": {"goals": "individual"},
    }
    (tmp_path / "s.yaml").write_bytes(as_yaml(team))
    scenario = _read(lambda: load_scenario(tmp_path / "s.yaml"), tmp_path)
    if model is None:
        assert scenario is None
        return
    sizes = (model.length, model.width, model.height, model.max_speed_x, model.max_speed_y)
    assert np.isfinite([*sizes, model.max_yaw_rate, *model.body, model.tracking_error]).all()
    if scenario is not None:
        _read(lambda: build_world(scenario), tmp_path)


@pytest.fixture(scope="session")
def mujoco_model() -> str:
    """Go1 as a MuJoCo model."""
    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco.robot_spec import robot_spec

    description = robot_model("go1").description
    assert description is not None
    spec = robot_spec(description, (2, 1), 0.8).spec
    spec.compile()
    return re.sub(r"<site [^>]*/>|<sensor>.*</sensor>", "", spec.to_xml(), flags=re.DOTALL)


@given(_RANDOM)
@_MANY
def test_mujoco_models(tmp_path: Path, mujoco_model: str, random: Random) -> None:
    from cavalcade.fleet.mujoco import own_robot

    text, changes = mujoco_model, []
    for _ in range(random.choice((0, 1, 1, 2, 5))):
        if random.random() < 0.8:  # a number, or what stands for one
            places = [found.span() for found in re.finditer(r'(?<=[" ])-?[\d.e+-]+(?=[" ])', text)]
            new = random.choice(("0", "-1", "1e-9", "1e9", "1e300", "nan", "inf", "", "x", "1 2"))
        else:  # a tag, or an attribute with its value
            places = [found.span() for found in re.finditer(r'<[^>]*>|\w+="[^"]*"', text)]
            new = random.choice(("", "<body/>", 'name="a"'))
        begin, end = random.choice(places or [(0, 0)])
        changes.append((text[begin:end], new))
        text = text[:begin] + new + text[end:]
    path = tmp_path / "m.xml"
    path.write_text(text, encoding="utf-8")
    note(str(changes))
    robot = _read(lambda: own_robot(path, robot_model("go1")), tmp_path)
    control = None if robot is None else _read(lambda: LegControl([robot]), tmp_path)
    if control is not None:
        description = robot.description
        masses = [description.mass, description.stand_height, *description.torque_limits]
        assert np.isfinite([*masses, *np.ravel(description.joint_range)]).all()


@given(_RANDOM)
@_MANY
def test_suites_of_campaigns(tmp_path: Path, random: Random) -> None:
    source = random.choice(sorted(SUITES.glob("*.yaml")))
    content = as_yaml(damaged_data(yaml.safe_load(source.read_text("utf-8")), random))
    note(str(content))
    path = tmp_path / "s.yaml"
    path.write_bytes(content)
    _read(lambda: load_suite(path), tmp_path)


@pytest.mark.parametrize("kind", [RecordingError, CavalcadeError])
def test_refusals_are_seen_as_such(tmp_path: Path, kind: type[CavalcadeError]) -> None:
    def refuse() -> None:
        raise kind("no", file=tmp_path / "f")

    assert _read(refuse, tmp_path) is None
    with pytest.raises(ZeroDivisionError):
        _read(lambda: 1 / 0, tmp_path)
