from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.world import (
    GENERATORS,
    Box,
    Circle,
    Polygon,
    distance_to_shapes,
    generate,
    is_connected,
)

SIZE = (14.0, 10.0)


@pytest.mark.parametrize("kind", GENERATORS)
def test_the_same_seed_gives_the_same_world(kind):
    assert generate(kind, SIZE, 7) == generate(kind, SIZE, 7)
    assert generate(kind, SIZE, 7).shapes != generate(kind, SIZE, 8).shapes


@pytest.mark.parametrize("kind", GENERATORS)
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**63 - 1))
def test_worlds_are_sound(kind, seed):
    world = generate(kind, SIZE, seed)
    assert world.feasible
    assert is_connected(world.shapes, SIZE, world.start, world.goal, 0.30)
    occupancy = world.to_map()
    assert occupancy.size == pytest.approx(SIZE)
    ends = np.array([world.start, world.goal])[:, :2]
    assert occupancy.contains(ends).all()
    assert distance_to_shapes(world.shapes, ends).min() > 0.30
    assert np.abs(ends[0] - ends[1]).max() > 5.0


def test_clutter_is_drawn_as_defined():
    shapes = [
        shape
        for seed in range(40)
        for shape in generate("clutter", SIZE, seed, require_feasible=False, obstacles=50).shapes
    ]
    circles = [shape for shape in shapes if isinstance(shape, Circle)]
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    assert len(circles) == len(boxes) == 1000

    def spans(values, low, high):
        values = np.array(values)
        assert low <= values.min() < low + 0.02 * (high - low)
        assert high - 0.02 * (high - low) < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, abs=0.05 * (high - low))

    spans([c.radius for c in circles], 0.10, 0.35)
    spans([b.size[0] for b in boxes], 0.20, 1.40)
    spans([b.size[1] for b in boxes], 0.20, 0.60)
    spans([b.yaw for b in boxes], 0.0, math.pi)
    spans([s.center[0] for s in shapes], 2.8, 11.2)
    spans([s.center[1] for s in shapes], 0.0, 10.0)


def test_of_an_odd_number_one_more_is_a_circle():
    shapes = generate("clutter", SIZE, 3).shapes
    assert [isinstance(s, Circle) for s in shapes].count(True) == 13
    assert len(shapes) == 25


def test_infeasible_worlds_are_drawn_again_or_reported():
    raw = [generate("clutter", SIZE, s, obstacles=90, require_feasible=False) for s in range(12)]
    assert {world.feasible for world in raw} == {True, False}
    for world in raw:
        assert world.attempts == 1
        again = generate("clutter", SIZE, world.seed, obstacles=90)
        assert again.feasible
        assert (again.attempts == 1) == world.feasible
        assert (again.shapes == world.shapes) == world.feasible
    hopeless = generate("clutter", SIZE, 0, obstacles=400, attempts=3)
    assert not hopeless.feasible
    assert hopeless.attempts == 3


def test_a_wider_disc_needs_more_room():
    assert not generate("corridor", SIZE, 0, radius=0.55, attempts=2).feasible
    assert generate("corridor", SIZE, 0, radius=0.45).feasible


def test_trunks_keep_their_distance():
    trunks = generate("forest", SIZE, 5, spacing=0.8).shapes
    assert len(trunks) > 20
    for i, a in enumerate(trunks):
        assert 0.10 <= a.radius <= 0.30
        for b in trunks[:i]:
            assert math.dist(a.center, b.center) - a.radius - b.radius >= 0.8
    assert len(generate("forest", SIZE, 5, trees=7).shapes) == 7


@pytest.mark.parametrize("seed", range(4))
def test_every_room_can_be_reached(seed):
    world = generate("rooms", (16, 12), seed, door=1.0, extra=0.0)
    for col in range(4):
        for row in range(3):
            place = (2 + 4 * col, 2 + 4 * row)
            assert is_connected(world.shapes, world.size, world.start, place, 0.40)


def test_doors_have_their_width():
    world = generate("rooms", (8.0, 4.0), 1, door=1.3)
    (x, _), height = world.shapes[0].center, np.linspace(0.0, 4.0, 4001)
    assert x == pytest.approx(4.0)
    free = distance_to_shapes(world.shapes, np.column_stack([np.full(4001, x), height])) > 0
    assert free.sum() * 0.001 == pytest.approx(1.3, abs=0.002)


@pytest.mark.parametrize(
    ("bends", "angle", "width"), [(2, 45.0, 1.0), (3, 50.0, 0.9), (4, 45, 1.1)]
)
@pytest.mark.parametrize("seed", range(3))
def test_corridors_have_their_width_and_bends(seed, bends, angle, width):
    size = (16.0, 9.0)
    world = generate("corridor", size, seed, bends=bends, angle=angle, width=width)
    upper, lower = (np.array(wall.points) for wall in world.shapes)
    upper, lower = upper[:-2], lower[-3::-1]
    slope = np.degrees(np.arctan2(*np.diff(upper, axis=0).T[::-1]))
    assert len(slope) == bends + 1
    assert np.abs(np.diff(slope)).min() >= angle - 1e-6
    for wall, line in ((world.shapes[1], upper), (world.shapes[0], lower)):
        middles = (line[1:] + line[:-1]) / 2
        assert wall.distance(middles[1:-1]) == pytest.approx(width)
        assert wall.distance(line).min() >= width - 1e-9 or bends % 2 == 1
    assert is_connected(world.shapes, size, world.start, world.goal, width / 2 - 0.06)
    assert not is_connected(world.shapes, size, world.start, world.goal, width / 2 + 0.01)


@pytest.mark.parametrize("seed", range(4))
def test_mazes_connect_all_places_by_one_way(seed):
    from scipy.ndimage import label

    world = generate("maze", (9.6, 6.8), seed, 0.1, passage=1.2, wall=0.2)
    free = ~world.to_map().occupied
    assert label(free)[1] == 1
    # A spanning tree has no loop, so every wall hangs on the border.
    assert label(np.pad(~free, 1, constant_values=True), np.ones((3, 3)))[1] == 1
    looped = generate("maze", (9.6, 6.8), seed, 0.1, passage=1.2, wall=0.2, loops=1.0)
    assert looped.shapes == ()


def test_maze_passages_have_their_width():
    world = generate("maze", SIZE, 1, passage=1.2, wall=0.2)
    assert is_connected(world.shapes, SIZE, world.start, world.goal, 0.55)
    assert not is_connected(world.shapes, SIZE, world.start, world.goal, 0.70)


@pytest.mark.parametrize(
    ("arguments", "options", "key"),
    [
        (("cluster", SIZE, 0), {}, "kind"),
        ((3, SIZE, 0), {}, "kind"),
        (("clutter", (14,), 0), {}, "size"),
        (("clutter", (14, math.nan), 0), {}, "size"),
        (("clutter", (1e6, 1e6), 0), {}, "size"),
        (("clutter", (5, 10), 0), {}, "size"),
        (("clutter", SIZE, -1), {}, "seed"),
        (("clutter", SIZE, 1.5), {}, "seed"),
        (("clutter", SIZE, 0, 0.0), {}, "resolution"),
        (("clutter", SIZE, 0), {"obstacles": -1}, "obstacles"),
        (("clutter", SIZE, 0), {"obstacles": 2.5}, "obstacles"),
        (("clutter", SIZE, 0), {"trees": 3}, "trees"),
        (("clutter", SIZE, 0), {"radius": math.nan}, "radius"),
        (("clutter", SIZE, 0), {"radius": "x"}, "radius"),
        (("clutter", SIZE, 0), {"attempts": 0}, "attempts"),
        (("forest", SIZE, 0), {"spacing": 0}, "spacing"),
        (("rooms", SIZE, 0), {"door": 0.9}, "door"),
        (("rooms", SIZE, 0), {"door": 3.9}, "door"),
        (("rooms", (90, 90), 0, 0.1), {"room": 0.5}, "room"),
        (("rooms", SIZE, 0), {"extra": 2}, "extra"),
        (("corridor", SIZE, 0), {"bends": 1}, "bends"),
        (("corridor", SIZE, 0), {"bends": 40}, "size"),
        (("corridor", SIZE, 0), {"angle": 90}, "angle"),
        (("maze", (1, 1), 0), {"passage": 3}, "size"),
        (("maze", SIZE, 0), {"loops": None}, "loops"),
    ],
)
def test_bad_arguments_name_their_key(arguments, options, key):
    with pytest.raises(InputError) as caught:
        generate(*arguments, **options)
    assert caught.value.key == key


def test_errors_list_the_choices():
    with pytest.raises(InputError, match="clutter, corridor, forest, maze, rooms"):
        generate("cluster", SIZE, 0)
    with pytest.raises(InputError, match="obstacles, zone"):
        generate("clutter", SIZE, 0, obstcles=3)


def wall_with_gap(gap):
    return (
        Box((5, (5 - gap / 2) / 2), (0.4, 5 - gap / 2)),
        Box((5, 10 - (5 - gap / 2) / 2), (0.4, 5 - gap / 2)),
    )


def test_connected_is_never_claimed_wrongly():
    for gap in np.linspace(0.5, 0.8, 31):
        connected = is_connected(wall_with_gap(gap), (10, 10), (2, 5), (8, 5), 0.30)
        assert not (connected and gap < 0.6)
        assert connected or gap < 0.6 + 2.5 * 0.025


def test_not_connected_ends():
    wall = (Polygon(((4, -1), (6, -1), (6, 11), (4, 11))),)
    assert not is_connected(wall, (10, 10), (2, 5), (8, 5), 0.1)
    assert is_connected(wall, (10, 10), (2, 5), (2, 9), 0.1)
    assert not is_connected((), (10, 10), (0.1, 5), (8, 5), 0.3)
    assert not is_connected((), (10, 10), (-3, 5), (8, 5), 0.3)
    assert not is_connected((Circle((8, 5), 0.2),), (10, 10), (2, 5), (8, 5), 0.1)
    assert is_connected((), (10, 10), (2, 5), (2, 5), 0.3)


def test_a_disc_without_a_size_is_bad_input():
    with pytest.raises(InputError, match="radius"):
        is_connected((), (10, 10), (2, 5), (8, 5), math.nan)
