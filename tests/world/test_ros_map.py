from __future__ import annotations

import io
import os
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from cavalcade.errors import MapError, OutputError
from cavalcade.world import MapWarning, OccupancyMap, load_map, save_map

KEYS = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [1.0, -2.0, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
EVERY_GREY = np.arange(256, dtype=np.uint8).reshape(8, 32)


def write(folder, picture=EVERY_GREY, **changes):
    """A description in `folder` with changed keys (None: left out), and its picture."""
    keys = {**KEYS, **changes}
    lines = [f"{key}: {value}" for key, value in keys.items() if value is not None]
    path = folder / "map.yaml"
    path.write_text("\n".join(lines))
    if isinstance(picture, bytes):
        (folder / "map.pgm").write_bytes(picture)
    elif picture is not None:
        image = Image.fromarray(picture)
        image.save(folder / "map.pgm", format="PPM" if image.mode == "L" else "PNG")
    return path


def occupancy_as_nav2(grey, mode, negate, occupied_thresh, free_thresh, alpha=255):
    """Slow reference: one pixel, in single precision, as nav2_map_server has it."""
    if mode == "raw":
        return grey if grey <= 100 else -1
    if alpha < 255:
        return -1
    one = np.float32(1)
    occ = np.float32(grey) / np.float32(255)
    occ = occ if negate else one - occ
    if occ >= np.float32(occupied_thresh):
        return 100
    if occ <= np.float32(free_thresh):
        return 0
    if mode == "trinary":
        return -1
    return int(
        (occ - np.float32(free_thresh)) / np.float32(occupied_thresh - free_thresh) * 100 + 0.5
    )


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("thresholds", [
    *((0.65, 0.196), (0.9, 0.1), (1.0, 0.0), (0.2, 0.19)),
    *((0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.65, 0.65), (0.2, 0.2), (100 / 255, 100 / 255)),
])  # fmt: skip
@pytest.mark.filterwarnings("ignore:.*free_thresh")
def test_every_grey_as_nav2(tmp_path, mode, negate, thresholds):
    occupied, free = thresholds
    path = write(tmp_path, mode=mode, negate=negate, occupied_thresh=occupied, free_thresh=free)
    expected = [
        [occupancy_as_nav2(int(g), mode, negate, occupied, free) for g in row] for row in EVERY_GREY
    ]
    assert load_map(path).grid[::-1].tolist() == expected


@pytest.mark.parametrize("thresholds", [(0.65, 0.65), (0.1, 0.9), (65, "wide"), (None, None)])
def test_thresholds_of_raw_maps_were_looked_at(tmp_path, thresholds):
    occupied, free = thresholds
    path = write(tmp_path, mode="raw", occupied_thresh=occupied, free_thresh=free)
    expected = [[g if g <= 100 else -1 for g in row] for row in EVERY_GREY.tolist()]
    assert load_map(path).grid[::-1].tolist() == expected


def test_comparisons_are_inclusive(tmp_path):
    path = write(
        tmp_path, np.array([[0, 255, 100]], dtype=np.uint8), occupied_thresh=1.0, free_thresh=0.0
    )
    assert load_map(path).grid.tolist() == [[100, 0, -1]]


def test_the_usual_greys_and_the_way_up(tmp_path):
    picture = np.array([[254, 205], [0, 254]], dtype=np.uint8)
    occupancy = load_map(write(tmp_path, picture))
    assert occupancy.grid.tolist() == [[100, 0], [0, -1]]
    assert (occupancy.resolution, occupancy.origin) == (0.05, (1.0, -2.0, 0.5))
    assert occupancy.occupied.tolist() == [[True, False], [False, True]]


def test_unknown_ground(tmp_path):
    picture = np.array([[254, 205]], dtype=np.uint8)
    assert load_map(write(tmp_path, picture), unknown="free").occupied.tolist() == [[False, False]]
    path = write(tmp_path, picture, unknown="free")
    assert load_map(path).unknown == "free"
    assert load_map(path, unknown="occupied").unknown == "occupied"


def test_a_threshold_that_loses_unknown_ground_warns(tmp_path):
    path = write(tmp_path, np.array([[254, 205]], dtype=np.uint8), free_thresh=0.25)
    with pytest.warns(MapWarning, match=r"map\.yaml: free_thresh: 0\.25 .* 0\.196"):
        assert load_map(path).grid.tolist() == [[0, 0]]
    path = write(tmp_path, np.array([[254, 0]], dtype=np.uint8), free_thresh=0.25)
    load_map(path)  # nothing is lost: no warning, which would be an error here


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
def test_pixels_that_are_not_opaque(tmp_path, mode):
    grey = np.array([[10, 90, 255]], dtype=np.uint8)
    alpha = np.array([[255, 254, 0]], dtype=np.uint8)
    path = write(tmp_path, np.stack([grey, grey, grey, alpha], axis=2), mode=mode)
    expected = [
        occupancy_as_nav2(g, mode, 0, 0.65, 0.196, a)
        for g, a in zip((10, 90, 255), (255, 254, 0), strict=True)
    ]
    assert load_map(path).grid.tolist() == [expected]


@pytest.mark.parametrize("kind", ["L", "LA", "RGB", "RGBA", "P", "1", "I;16"])
def test_kinds_of_png(tmp_path, kind):
    grey = np.array([[0, 255], [255, 255]], dtype=np.uint8)
    image = Image.fromarray(grey)
    # Pillow's own conversion to 16 bits does not scale.
    deep = Image.fromarray(grey.astype(np.uint16) * 257)
    image = deep if kind == "I;16" else image.convert(kind)
    image.save(tmp_path / "map.pgm", format="PNG")
    assert load_map(write(tmp_path, None)).grid.tolist() == [[0, 0], [100, 0]]


def test_palette_with_a_transparent_colour(tmp_path):
    image = Image.fromarray(np.array([[0, 255, 0]], dtype=np.uint8)).convert("P")
    image.save(tmp_path / "map.pgm", format="PNG", transparency=int(image.getpixel((1, 0))))
    assert load_map(write(tmp_path, None)).grid.tolist() == [[100, -1, 100]]


def test_colours_count_by_luminance(tmp_path):
    picture = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], dtype=np.uint8)
    path = write(tmp_path, picture, mode="scale", free_thresh=0.0, occupied_thresh=1.0)
    assert load_map(path).grid[0].tolist() == pytest.approx([70, 41, 89], abs=1)


@pytest.mark.parametrize(
    "picture",
    [
        b"P2\n# by hand\n3 2 # columns, rows\n255\n254 0 205\n0 254 254\n",
        b"P2 3 2 15 15 0 12 0 15 15",
        b"P5 3 2 255\n\xfe\x00\xcd\x00\xfe\xfe",
        b"P5\n#\n#\r\n3\n2\n255\n\xfe\x00\xcd\x00\xfe\xfe trailing",
        b"P5 3 2 65535\n\xff\xff\x00\x00\xcd\xcd\x00\x00\xfe\xfe\xff\xff",
    ],
)
def test_kinds_of_pgm(tmp_path, picture):
    grid = load_map(write(tmp_path, picture, free_thresh=0.1)).grid
    assert grid.tolist() == [[100, 0, 0], [0, 100, -1]]


values = st.integers(1, 6).flatmap(
    lambda cols: st.lists(
        st.lists(st.integers(-1, 100), min_size=cols, max_size=cols), min_size=1, max_size=6
    )
)
coordinate = st.floats(-1e5, 1e5)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    values,
    st.floats(1e-3, 10),
    st.tuples(coordinate, coordinate, coordinate),
    st.sampled_from(["pgm", "png"]),
    st.sampled_from(["occupied", "free"]),
    st.booleans(),
)
@pytest.mark.filterwarnings("ignore:.*a yaw of")
def test_a_saved_map_loads_back_equal(tmp_path, grid, resolution, origin, image, unknown, trinary):
    array = np.array(grid)
    if trinary:
        array = np.array([-1, 0, 100])[array % 3]
    occupancy = OccupancyMap(array, resolution, origin, unknown)
    save_map(occupancy, tmp_path / "saved.yaml", image)
    assert load_map(tmp_path / "saved.yaml") == occupancy
    save_map(occupancy, tmp_path / "scaled.yml", "png", "scale")
    assert load_map(tmp_path / "scaled.yml") == occupancy


def test_a_saved_trinary_map_is_what_ros_expects(tmp_path):
    save_map(OccupancyMap(np.array([[0, 100, -1]]), 0.05), tmp_path / "m.yaml")
    assert (tmp_path / "m.pgm").read_bytes() == b"P5\n3 1\n255\n\xfe\x00\xcd"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.pgm", "m.yaml"]
    assert (tmp_path / "m.yaml").read_text() == (
        "image: m.pgm\nmode: trinary\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def test_saving_refuses_what_would_lose_values(tmp_path):
    grey = OccupancyMap(np.array([[50, -1]]), 0.05)
    for image, mode in (("pgm", "trinary"), ("png", "trinary"), ("pgm", "scale")):
        with pytest.raises(MapError, match="mode"):
            save_map(grey, tmp_path / "m.yaml", image, mode)
    for arguments in (("m.txt",), ("m.yaml", "bmp"), ("m.yaml", "pgm", "grey")):
        with pytest.raises(MapError):
            save_map(grey, tmp_path / arguments[0], *arguments[1:])
    assert list(tmp_path.iterdir()) == []


def test_saving_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    for target in (tmp_path / "missing" / "m.yaml", tmp_path / "file" / "m.yaml"):
        with pytest.raises(OutputError, match=r"m\.pgm: cannot be written"):
            save_map(OccupancyMap(np.array([[0]]), 0.05), target)


@pytest.mark.parametrize("image", ["pgm", "png"])
def test_two_thousand_squared_loads(tmp_path, image):
    grid = np.random.default_rng(0).choice(np.array([0, 100, -1], dtype=np.int8), (2000, 2000))
    save_map(OccupancyMap(grid, 0.05), tmp_path / "m.yaml", image)
    assert load_map(tmp_path / "m.yaml") == OccupancyMap(grid, 0.05)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        *[({name: None}, name) for name in KEYS],
        ({"image": "''"}, "image"),
        ({"image": 3}, "image"),
        ({"image": "missing.pgm"}, "image"),
        ({"image": "'a\\0b'"}, "image"),
        ({"image": "x" * 5000}, "image"),
        ({"resolution": 0}, "resolution"),
        ({"resolution": -1}, "resolution"),
        ({"resolution": ".nan"}, "resolution"),
        ({"resolution": "fine"}, "resolution"),
        ({"resolution": "true"}, "resolution"),
        ({"resolution": "9" * 400}, "resolution"),
        ({"origin": "[0, 0]"}, "origin"),
        ({"origin": "[0, 0, .inf]"}, "origin"),
        ({"origin": "[0, 0, x]"}, "origin"),
        ({"origin": "{}"}, "origin"),
        ({"occupied_thresh": 65}, "occupied_thresh"),
        ({"free_thresh": -0.1}, "free_thresh"),
        ({"free_thresh": 0.651}, "free_thresh"),
        ({"negate": "maybe"}, "negate"),
        ({"mode": "ternary"}, "mode"),
        ({"mode": "[raw]"}, "mode"),
        ({"unknown": "wall"}, "unknown"),
    ],
)
def test_bad_descriptions_name_file_and_key(tmp_path, changes, key):
    path = write(tmp_path, **changes)
    with pytest.raises(MapError) as caught:
        load_map(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert str(caught.value).startswith(f"{path}: {key}: ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 6000


@pytest.mark.parametrize("text", ["5e-2", "'0.05'", "+.05"])
def test_numbers_that_yaml_takes_for_text(tmp_path, text):
    assert load_map(write(tmp_path, resolution=text)).resolution == 0.05


def test_words_for_negate_and_capitals_for_mode(tmp_path):
    assert load_map(write(tmp_path, negate="yes", mode="RAW")).grid[-1, 3] == 3
    assert load_map(write(tmp_path, negate="true")).grid[-1, 0] == 0


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"- 1\n- 2\n",
        b"image: [",
        b"\xff\xfe\x00",
        b"\x00\x01\x02",
        b"[" * 50_000,
        b"a: 2001-99-99",
        b"image: a\nimage: b",
        b"origin: &a [*a, *a, *a]",
        b"a: &a {b: 1}\nc: {<<: *a}",
        b"!!python/object/apply:os.getcwd []",
        b"#" * 200_000,
    ],
)
def test_files_that_are_no_description(tmp_path, content):
    path = tmp_path / "map.yaml"
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        load_map(path)
    assert caught.value.file == str(path)


def test_places_that_are_no_file(tmp_path):
    for path in (tmp_path, tmp_path / "missing.yaml"):
        with pytest.raises(MapError):
            load_map(path)
    fifo = tmp_path / "fifo.yaml"
    os.mkfifo(fifo)
    with pytest.raises(MapError, match="not a regular file"):
        load_map(fifo)
    (tmp_path / "map.pgm").mkdir()
    with pytest.raises(MapError, match="not a regular file"):
        load_map(write(tmp_path, None))


def png_bytes(picture):
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, format="PNG")
    return stream.getvalue()


PNG = png_bytes(np.random.default_rng(1).integers(0, 255, (40, 50), dtype=np.uint8))


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        (b"", "expected a PGM"),
        (b"P6 1 1 255\n123", "expected a PGM"),
        (b"GIF89a", "expected a PGM"),
        (b"P5 2 2", "header"),
        (b"P5 2 -2 255\n1234", "header"),
        (b"P5 2 2 255\n123", "truncated: 3 of 4 bytes"),
        (b"P5 2 2 65535\n1234567", "truncated: 7 of 8 bytes"),
        (b"P5 2 2 0\n1234", "1 to 65535"),
        (b"P5 2 2 70000\n1234", "1 to 65535"),
        (b"P5 2 2 100\n1234\x65", None),
        (b"P5 1 1 100\n\x65", "exceeds"),
        (b"P5 0 2 255\n", "no ground"),
        (b"P5 10000 10000 255\n", "64 million"),
        (b"P2 2 2 255\n1 2 3", "truncated: 3 of 4 pixels"),
        (b"P2 2 2 255\n1 2 3 x", "something else than numbers"),
        (b"P2 2 2 255\n1 2 3 -4", "something else than numbers"),
        (b"P2 2 2 255\n1 2 3 256", "exceeds"),
        (b"P2 1 1 255\n" + b"9" * 60, "exceeds"),
        (PNG[:20], "header"),
        (PNG[:200], "truncated or damaged"),
        (PNG[:300] + b"\0" * 50 + PNG[350:], "truncated or damaged"),
        (PNG[:16] + (10_000).to_bytes(4, "big") * 2 + PNG[24:], "64 million"),
    ],
)
def test_bad_pictures(tmp_path, picture, message):
    path = write(tmp_path, picture)
    if message is None:
        load_map(path)
        return
    with pytest.raises(MapError, match=message) as caught:
        load_map(path)
    assert caught.value.file == str(tmp_path / "map.pgm")


def loads_or_says_why(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        message = ""
        try:
            load_map(path)
        except MapError as error:
            message = str(error)
        assert "\n" not in message


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.dates(),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2)
    ),
    max_leaves=5,
)


@settings(
    max_examples=80, deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip
@given(st.dictionaries(st.sampled_from([*KEYS, "mode", "unknown"]), anything))
def test_no_description_leads_to_another_error(tmp_path, changes):
    import yaml

    path = write(tmp_path)
    path.write_text(yaml.safe_dump({**KEYS, **changes}))
    loads_or_says_why(path)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=200) | st.text(max_size=60).map(lambda text: text.encode()))
def test_no_text_leads_to_another_error(tmp_path, content):
    path = tmp_path / "map.yaml"
    path.write_bytes(content)
    loads_or_says_why(path)


P2 = b"P2\n# text\n4 3\n255\n" + b" ".join(b"%d" % (i * 20) for i in range(12))
P5 = b"P5\n4 3\n255\n" + bytes(range(12))


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from([PNG, P2, P5]), st.data())
def test_no_damaged_picture_leads_to_another_error(tmp_path, picture, data):
    damaged = bytearray(picture)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at] = data.draw(st.integers(0, 255))
    damaged = damaged[: data.draw(st.integers(len(damaged) - 20, len(damaged)))]
    loads_or_says_why(write(tmp_path, bytes(damaged)))


@pytest.mark.parametrize(
    ("name", "shape", "warned"),
    [
        ("nav2/depot", (307, 604), True),
        ("nav2/warehouse", (1674, 1006), False),
        ("nav2/tb3_sandbox", (384, 384), False),
        ("nav2/smoothers_world", (300, 300), False),
        ("aws_small_warehouse/005/map", (423, 286), False),
    ],
)
def test_real_maps(shared_data, tmp_path, name, shape, warned):
    path = shared_data(f"ros_maps/{name}.yaml")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        occupancy = load_map(path)
    assert [w.category for w in caught] == [MapWarning] * warned
    assert occupancy.grid.shape == shape
    assert 0.01 < (occupancy.grid == 100).mean() < 0.2 or "tb3" in name
    for image in ("pgm", "png"):
        save_map(occupancy, tmp_path / "m.yaml", image)
        assert load_map(tmp_path / "m.yaml") == occupancy


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{image: m.pgm, origin: [0, 0, 0], negate: 0, occupied_thresh: 0.6, free_thresh: 0.2}",
         "resolution: is missing"),
        ("{image: m.pgm, resolution: 0.05, origin: [0, 0, 0]}",
         "negate: is missing, and so are occupied_thresh, free_thresh; usual is negate: 0, "
         "occupied_thresh: 0.65, free_thresh: 0.196"),
        ("{image: m.pgm, negate: 0, origin: [0, 0, 0], occupied_thresh: 0.6}",
         "resolution: is missing, and so is free_thresh; usual is free_thresh: 0.196"),
        ("{image: m.pgm, mode: raw, resolution: 0.05}",
         "origin: is missing, and so is negate; usual is negate: 0"),
    ],
)  # fmt: skip
def test_all_that_a_description_lacks_is_named_at_once(tmp_path, text, message):
    (tmp_path / "m.yaml").write_text(text)
    with pytest.raises(MapError) as caught:
        load_map(tmp_path / "m.yaml")
    assert str(caught.value) == f"{tmp_path / 'm.yaml'}: {message}"
