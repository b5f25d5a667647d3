"""Contact of footprints with solid cells and with each other over time, against exact distances."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import Footprint, footprints_meet
from cavalcade.lattice.collision import (
    Margins,
    Scene,
    grid_of,
    move_free,
    occupied_until,
    place_free,
    pose_free,
)
from cavalcade.lattice.dubins import connect, no_words
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.lattice.motion_limits import footprint, motion_limits
from cavalcade.lattice.planner import NOBODY, Others, others_of
from cavalcade.lattice.primitives import make_move, sample_moves, trapezoid
from cavalcade.robots import MODELS, robot_model
from cavalcade.world import OccupancyMap

Shape = tuple[float, float, bool]

_FEW = settings(max_examples=60, deadline=None)
_NAMES = st.sampled_from(sorted(MODELS))
_SEEDS = st.integers(0, 2**32 - 1)


def _ground(rng: np.random.Generator, cell: float, share: float) -> Ground:
    return make_ground(OccupancyMap(rng.random((40, 50)) < share, cell))


def _room(gap: Callable[..., Array], ground: Ground, shape: Shape, poses: Array) -> Array:
    """Exact distances `(K,)` of footprints from all solid cells and from the grid's border."""
    rows, cols = np.nonzero(ground.solid)
    cell, half = ground.cell, ground.cell / 2
    squares = np.column_stack([cols * cell + half, rows * cell + half, np.zeros(len(rows))])
    width, height = ground.solid.shape[1] * cell, ground.solid.shape[0] * cell
    # The border: four slabs as long as nothing else here.
    slabs = [
        ((50.0, 50.0, False), (-50.0, 0.0)),
        ((50.0, 50.0, False), (width + 50.0, 0.0)),
        ((50.0, 50.0, False), (0.0, -50.0)),
        ((50.0, 50.0, False), (0.0, height + 50.0)),
    ]
    room = np.full(len(poses), np.inf)
    for slab, at in slabs:
        there = np.tile([*at, 0.0], (len(poses), 1))
        room = np.minimum(room, gap(shape, poses, slab, there))
    if len(squares):
        each = np.repeat(poses, len(squares), axis=0)
        many = np.tile(squares, (len(poses), 1))
        gaps = gap(shape, each, (half, half, False), many)
        room = np.minimum(room, gaps.reshape(len(poses), -1).min(axis=1))
    return room


def _free(ground: Ground, poses: Array, shape: Shape, margin: float) -> Array:
    grid, one = grid_of(ground), Footprint(*shape)
    return np.array([pose_free(grid, one, *p, margin) for p in poses])


@_FEW
@given(_NAMES, _SEEDS, st.sampled_from((0.025, 0.05, 0.1)), st.sampled_from((0.0, 0.005, 0.05)))
@example("spirit", 2360713, 0.025, 0.05)  # a cell beyond a corner
def test_free_places_keep_the_margin_and_roomy_ones_are_free(
    footprint_gap, name, seed, cell, margin
):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    shape = (model.length / 2, model.width / 2, model.round)
    ground = _ground(rng, cell, rng.choice((0.0, 0.002, 0.01, 0.05)))
    size = np.array([ground.solid.shape[1], ground.solid.shape[0]]) * cell
    poses = np.column_stack(
        [rng.uniform(-0.3, size + 0.3, (60, 2)), rng.choice((0.0, 0.5, 1.0), 60) * np.pi]
    )
    poses[::2, 2] = rng.uniform(-4, 4, 30)
    poses[::5, :2] = np.round(poses[::5, :2] / cell) * cell
    room = _room(footprint_gap, ground, shape, poses)
    free = _free(ground, poses, shape, margin)
    assert (room[free] >= margin - 2e-9).all()
    # At corners, what is square is kept apart along both sides.
    assert free[room >= margin * (1.0 if model.round else math.sqrt(2.0)) + 1e-9].all()
    if margin == 0.0:
        # Without a margin the answer is exact.
        assert free[room > 1e-9].all()


@pytest.mark.parametrize("cell", [0.025, 0.05, 0.1])
@pytest.mark.parametrize("name", ["unicycle-sphere", "double-integrator", "go1"])
def test_bodies_may_touch_border_and_cells(name, cell):
    model = robot_model(name)
    shape = (model.length / 2, model.width / 2, model.round)
    for count in range(40, 240, 3):
        ground = make_ground(OccupancyMap(np.zeros((count, count), dtype=bool), cell))
        size = count * cell
        poses = np.array(
            [
                (model.length / 2, model.width / 2, 0.0),
                (size - model.length / 2, size - model.width / 2, 0.0),
                (size - model.length / 2, size - model.width / 2, math.pi),
            ]
        )
        assert _free(ground, np.round(poses, 9), shape, 0.0).all()
        assert not _free(ground, poses - [0.01, 0.0, 0.0], shape, 0.0)[0]
        assert not _free(ground, poses + [0.01, 0.0, 0.0], shape, 0.0)[1:].any()


_BODY = st.one_of(
    st.sampled_from([(m.length / 2, m.width / 2, m.round) for m in MODELS.values()]),
    st.tuples(st.floats(0.05, 1.0), st.floats(0.02, 1.0), st.just(False)).map(
        lambda s: (max(s[:2]), min(s[:2]), False)
    ),
    st.floats(0.05, 1.0).map(lambda r: (r, r, True)),
)
_NEAR = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-7.0, 7.0))


@settings(max_examples=500, deadline=None)
@given(_BODY, _NEAR, _BODY, _NEAR, st.sampled_from((0.0, 0.003, 0.02, 0.05, 0.3)))
def test_bodies_meet_where_their_distance_is_less_than_the_margin(
    footprint_gap, one, here, other, there, margin
):
    gap = footprint_gap(one, np.array([here]), other, np.array([there]))[0]
    first, second = (Footprint(float(s[0]), float(s[1]), s[2]) for s in (one, other))
    meet = footprints_meet(first, here, second, there, margin)
    assert meet == footprints_meet(second, there, first, here, margin)
    if gap < margin - 1e-9:
        assert meet
    # At corners boxes are kept apart a little farther than that, discs are not.
    if gap > margin * (1.0 if one[2] or other[2] else math.sqrt(2.0)) + 1e-9:
        assert not meet


def _tracks(rng: np.random.Generator, count: int) -> list[Array]:
    """Walks of up to 0.8 m/s and 1.2 rad/s."""
    out = []
    for _ in range(count):
        steps = rng.uniform(-1, 1, (rng.integers(1, 60), 3)) * (0.028, 0.028, 0.06)
        at = (*rng.uniform(0, 3, 2), rng.uniform(-3, 3))
        out.append(at + np.cumsum(steps, axis=0))
    return out


def _taken(
    gap: Callable[..., Array],
    tracks: list,
    models: list,
    spans: list,
    shape: Shape,
    place: Array,
    time: Array,
    margin: float,
) -> Array:
    """Whether a place is nearer than the margin to anybody at the times, by interpolation."""
    taken = np.zeros(len(time), dtype=bool)
    for who, begin, end in spans:
        track, model = tracks[who], models[who]
        grid = np.arange(len(track)) * 0.05
        there = np.stack([np.interp(time, grid, track[:, k]) for k in range(3)], axis=1)
        other = (model.length / 2, model.width / 2, model.round)
        near = gap(shape, np.repeat(place[None], len(time), axis=0), other, there) < margin
        taken |= near & (time >= begin) & (time <= end)
    return taken


@_FEW
@given(_SEEDS, _NAMES)
def test_places_are_free_while_nobody_is_there(footprint_gap, seed, name):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    one, shape = footprint(model), (model.length / 2, model.width / 2, model.round)
    tracks = _tracks(rng, 3)
    models = [robot_model(str(rng.choice(sorted(MODELS)))) for _ in tracks]
    spans = [(0, 0.0, math.inf), (1, 0.5, 1.5), (2, 0.0, 0.7), (2, 2.0, math.inf)]
    others = others_of(tracks, models, spans)
    time = rng.uniform(0.0, 5.0, 40)
    place = np.array([*rng.uniform(0, 3, 2), rng.uniform(-3, 3)])
    free = np.array([place_free(others, one, tuple(place), t, 0.0) for t in time])
    reference = (tracks, models, spans, shape, place, time)
    assert (~free == _taken(footprint_gap, *reference, 0.0)).all()
    free = np.array([place_free(others, one, tuple(place), t, 0.05) for t in time])
    assert not free[_taken(footprint_gap, *reference, 0.05)].any()
    assert free[~_taken(footprint_gap, *reference, 0.05 * math.sqrt(2) + 1e-9)].all()


@_FEW
@given(_SEEDS, _NAMES, st.booleans())
@example(1993, "unicycle", True)
@example(1993, "unicycle", False)
def test_free_from_is_when_the_last_one_has_left(footprint_gap, seed, name, stay):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    one, shape = footprint(model), (model.length / 2, model.width / 2, model.round)
    tracks = _tracks(rng, 3)
    models = [robot_model("go1"), robot_model("unicycle"), robot_model("double-integrator")]
    late = math.inf if stay else 0.05 * (max(map(len, tracks)) - 1)
    spans = [(0, 0.0, late), (1, 0.0, late), (2, 0.3, late)]
    others = others_of(tracks, models, spans)
    place = np.array([*rng.uniform(0, 3, 2), rng.uniform(-3, 3)])
    last = occupied_until(others, one, tuple(place), 0.0, 0.0)
    time = np.arange(0.0, 10.0, 0.01)
    taken = _taken(footprint_gap, tracks, models, spans, shape, place, time, 0.0)
    if last == math.inf:
        assert stay
        assert taken[-1]
    elif last < 0.0:
        # Looks are a step of the tracks apart.
        assert not taken[::5][1:].any()
    else:
        assert not taken[::5][time[::5] > last + 0.01].any()
        # Between looks somebody may graze it by no more than what moves in half a step.
        deep = _taken(footprint_gap, tracks, models, spans, shape, place, time, -0.03)
        assert not deep[time > last + 0.05].any()
        assert taken[np.abs(time - last) <= 0.011].any()


def test_nobody_is_never_in_the_way():
    go1 = footprint(robot_model("go1"))
    assert place_free(NOBODY, go1, (0.0, 0.0, 0.0), 0.0, 1.0)
    assert occupied_until(NOBODY, go1, (0.0, 0.0, 0.0), 0.0, 1.0) == -1.0


def _one(model: str, track: Array) -> Others:
    return others_of([track], [robot_model(model)], [(0, 0.0, math.inf)])


def test_a_robot_that_stays_takes_the_place_for_good():
    go1, here = footprint(robot_model("go1")), (0.0, 0.0, 0.0)
    track = np.linspace((5.0, 0.0, 0.0), (0.0, 0.0, 0.0), 101)
    others = _one("go1", track)
    assert place_free(others, go1, here, 0.0, 0.0)
    assert not place_free(others, go1, here, 1e5, 0.0)
    assert occupied_until(others, go1, here, 0.0, 0.0) == math.inf
    # Where it came from, it is gone after 0.65 m at 1 m/s.
    assert occupied_until(others, go1, (5.0, 0.0, 0.0), 0.0, 0.0) == pytest.approx(0.65, abs=0.051)


@_FEW
@given(_SEEDS, _NAMES)
def test_a_free_move_meets_nothing_all_along(footprint_gap, seed, name):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    limits, shape = motion_limits(model), (model.length / 2, model.width / 2, model.round)
    ground = _ground(rng, 0.1, 0.004)
    tracks = _tracks(rng, 2)
    others = others_of(tracks, [robot_model("go1")] * 2, [(0, 0.0, math.inf), (1, 0.0, math.inf)])
    margins = Margins(0.005, 0.05, 0.04, 0.08, 0.06, 0)
    scene = Scene(grid_of(ground), others, limits, margins, 1.0)
    lonely, words = scene._replace(others=NOBODY), no_words()
    for _ in range(4):
        a, b = (np.array([*rng.uniform(0.5, 3.5, 2), rng.uniform(-3, 3)]) for _ in range(2))
        number = connect(a, 0.0, b, 0.0, limits, 1.0, words)
        pick = rng.integers(number)
        at, t = a.copy(), float(rng.uniform(0.0, 2.0))
        for row in words.moves[pick, : words.counts[pick]]:
            time = np.arange(0.0, row[5], 0.01)
            motion = sample_moves(at, row[None], limits, time)[:, :3]
            alone = move_free(lonely, tuple(at), row, t, False)
            if alone and len(motion) > 1:
                # At the first pose nobody looks: the move before has ended there.
                room = _room(footprint_gap, ground, shape, motion[::11])
                assert room[1:].min(initial=1.0) > 0.0 or room[0] <= 0.005
            free = move_free(scene, tuple(at), row, t, False)
            assert alone or not free
            if free:
                met = [_gap_to(footprint_gap, shape, motion, track, t + time) for track in tracks]
                assert min(gap[1:].min(initial=1.0) for gap in met) > 0.0 or (
                    min(gap[:1].min(initial=1.0) for gap in met) <= 0.05
                )
            at = sample_moves(at, row[None], limits, np.array([row[5] + 1.0]))[0, :3]
            t += row[5]


def _gap_to(
    gap: Callable[..., Array], shape: Shape, poses: Array, track: Array, time: Array
) -> Array:
    grid = np.arange(len(track)) * 0.05
    there = np.stack([np.interp(time, grid, track[:, k]) for k in range(3)], axis=1)
    return gap(shape, poses, (0.325, 0.14, False), there)


@settings(max_examples=40, deadline=None)
@given(st.data(), st.sampled_from((1, 2, 8, 9, 63, 64, 65, 150)), st.floats(-1.0, 1.0))
def test_every_pose_of_a_move_counts_whichever_is_looked_at_first(data, looks, turn):
    """Passes from coarse to fine leave none out: a tiny body and a single cell in its way."""
    model = robot_model("go1").with_limits(length=0.004, width=0.002)
    limits, row, start = motion_limits(model), np.zeros(6), (1.0, 2.0, 0.0)
    assert make_move(row, 2.0, turn, 0.0, 0.0, limits.speed, limits)
    _, peak = trapezoid(2.0, 0.0, 0.0, limits.speed, limits.acceleration)
    margins = Margins(0.0, 0.0, peak * row[5] / (looks - 0.5), 100.0, 100.0, 0)
    poses = sample_moves(np.array(start), row[None], limits, row[5] * np.arange(looks + 1) / looks)
    solid = np.zeros((800, 800), dtype=bool)
    met = data.draw(st.integers(0, looks))
    solid[int(poses[met, 1] / 0.005), int(poses[met, 0] / 0.005)] = True
    grid, body = grid_of(make_ground(OccupancyMap(solid, 0.005))), footprint(model)
    free = move_free(Scene(grid, NOBODY, limits, margins, 1.0), start, row, 0.0, False)
    assert free == all(pose_free(grid, body, *pose, 0.0) for pose in poses[1:, :3].tolist())
    assert not (free and met)
