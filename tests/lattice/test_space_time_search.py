"""Search in space and time: paths meet nobody, waits are found, and nothing is left to chance."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.geometry import Array
from cavalcade.lattice._search import FOUND, SearchSettings, new_frontier, search
from cavalcade.lattice.collision import Others, Scene
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.lattice.motion_limits import motion_limits, primitives_of
from cavalcade.lattice.planner import (
    MARGINS,
    NOBODY,
    TRACK_STEP,
    SpaceTimePlanner,
    TimedPath,
    others_of,
    trajectory_of,
)
from cavalcade.lattice.primitives import make_move, poses_between, sample_moves
from cavalcade.lattice.shortening import shorten, split
from cavalcade.robots import MODELS, RobotModel, robot_model
from cavalcade.world import OccupancyMap

Gap = Callable[..., Array]
CELL = 0.05


def _ground(width: float, height: float, boxes: tuple = ()) -> Ground:
    """Level ground with solid boxes (x0, y0, x1, y1) in m, whole cells."""
    solid = np.zeros((round(height / CELL), round(width / CELL)), dtype=bool)
    for x0, y0, x1, y1 in boxes:
        solid[round(y0 / CELL) : round(y1 / CELL), round(x0 / CELL) : round(x1 / CELL)] = True
    return make_ground(OccupancyMap(solid, CELL))


def _shape(model: RobotModel) -> tuple[float, float, bool]:
    return model.length / 2, model.width / 2, model.round


def _gaps(gap: Gap, path: TimedPath, others: Others, models: list[RobotModel]) -> float:
    """Least distance to each track that counts for good, until long after all have parked, m."""
    end = max(path.duration, (others.tracks.shape[1] - 1) * others.step) + 2.0
    time = np.arange(0.0, end, 0.005)
    poses = sample_moves(path.start, path.moves, path.limits, time)[:, :3]
    grid = np.arange(others.tracks.shape[1]) * others.step
    least = math.inf
    for track, model in zip(others.tracks, models, strict=True):
        there = np.stack([np.interp(time, grid, track[:, k]) for k in range(3)], axis=1)
        least = min(least, gap(_shape(path.model), poses, _shape(model), there).min())
    return least


def _on_ground(gap: Gap, path: TimedPath, ground: Ground) -> float:
    """Least distance to solid cells and the border, m."""
    time = np.arange(0.0, path.duration + 0.02, 0.02)
    poses = sample_moves(path.start, path.moves, path.limits, time)[:, :3]
    rows, cols = np.nonzero(ground.solid)
    squares = np.column_stack([(cols + 0.5) * CELL, (rows + 0.5) * CELL, np.zeros(len(rows))])
    reach = math.hypot(*_shape(path.model)[:2]) + CELL
    apart = np.linalg.norm(poses[:, None, :2] - squares[:, :2], axis=2)
    at, near = np.nonzero(apart < reach)
    square = (CELL / 2, CELL / 2, False)
    return gap(_shape(path.model), poses[at], square, squares[near]).min(initial=math.inf)


def _walk(*poses: tuple[float, float, float], speed: float = 0.5) -> Array:
    """A track through the poses; its heading need not follow."""
    rows = [np.array(poses[0])[None]]
    for a, b in itertools.pairwise(poses):
        count = max(1, math.ceil(math.dist(a[:2], b[:2]) / speed / TRACK_STEP))
        rows.append(np.linspace(a, b, count + 1)[1:])
    return np.concatenate(rows)


def _for_good(tracks: list[Array], models: list[RobotModel]) -> Others:
    return others_of(tracks, models, [(k, 0.0, math.inf) for k in range(len(tracks))])


_BOXES = ((2.0, 0.0, 2.3, 2.2), (4.0, 1.8, 4.3, 4.0), (5.5, 0.0, 5.8, 2.0))


@pytest.fixture(scope="module")
def cluttered() -> Ground:
    return _ground(8.0, 4.0, _BOXES)


@pytest.mark.parametrize("name", sorted(MODELS))
def test_alone_on_free_ground_the_first_word_is_the_path(name):
    model = robot_model(name)
    planner = SpaceTimePlanner(_ground(9.0, 4.0))
    start, goal = np.array([1.0, 2.0, 0.3]), np.array([8.0, 2.5, -0.3])
    path, spent, expansions = planner.plan(model, start, goal)
    assert not spent
    assert expansions == 1
    assert path.length == pytest.approx(math.hypot(7.0, 0.5), rel=0.03)
    end = poses_between(start, path.moves)[-1]
    assert end[:2] == pytest.approx(goal[:2])
    if not path.limits.free:
        assert math.remainder(end[2] - goal[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


_SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=12, deadline=None)
@given(_SEEDS, st.sampled_from(sorted(MODELS)))
def test_paths_meet_nobody_and_nothing(footprint_gap, cluttered, seed, name):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    planner = SpaceTimePlanner(cluttered)
    tracks, models = [], []
    for _ in range(2):
        # Nobody begins where the robot stands; they may come there.
        here, there = rng.uniform((2.0, 0.3, -3), (7.7, 3.7, 3)), rng.uniform(0.3, 3.7, 3)
        tracks.append(_walk(tuple(here), tuple(there), speed=rng.uniform(0.2, 0.75)))
        models.append(robot_model(str(rng.choice(("go1", "spirit", "double-integrator")))))
    others = _for_good(tracks, models)
    start, goal = np.array([0.7, 1.0, 0.0]), np.array([7.2, 1.0, rng.uniform(-3, 3)])
    for margins in MARGINS:
        path, spent, expansions = planner.plan(model, start, goal, others, 3_000, margins)
        # A second look where the first path is long, or none.
        assert expansions <= 2 * 3_000
        assert path is None or not spent
        if path is None:
            continue
        assert (path.start == start).all()
        assert poses_between(start, path.moves)[-1, :2] == pytest.approx(goal[:2])
        assert _gaps(footprint_gap, path, others, models) > 0.0
        assert _on_ground(footprint_gap, path, cluttered) > -1e-9


def _mirrored(pose: Array) -> Array:
    return np.array([pose[0], 4.0 - pose[1], -pose[2]])


@pytest.mark.parametrize("name", sorted(MODELS))
@pytest.mark.parametrize("goal", [(7.2, 1.0, 0.0), (7.2, 3.0, 2.0), (3.2, 3.3, -1.0)])
def test_the_mirror_image_of_a_problem_costs_the_same(cluttered, name, goal):
    model = robot_model(name)
    track = _walk((7.0, 3.0, 3.1), (1.0, 3.6, 3.1))
    start, end = np.array([0.8, 1.0, 0.0]), np.array(goal)
    planner = SpaceTimePlanner(cluttered)
    path, _, _ = planner.plan(model, start, end, _for_good([track], [robot_model("go1")]))
    image = make_ground(OccupancyMap(cluttered.solid[::-1].copy(), CELL))
    track = np.array([_mirrored(pose) for pose in track])
    others = _for_good([track], [robot_model("go1")])
    other, _, _ = SpaceTimePlanner(image).plan(model, _mirrored(start), _mirrored(end), others)
    # Bins are not symmetric: which of two states is the first in its bin is a matter of rounding.
    assert other.cost == pytest.approx(path.cost, rel=0.12)


@settings(max_examples=50, deadline=None)
@given(st.sampled_from(sorted(MODELS)), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0, 6))
def test_on_free_ground_it_does_not_matter_where_one_goes(name, yaw, last, angle):
    model = robot_model(name)
    planner = SpaceTimePlanner(_ground(12.0, 12.0))
    a, b = np.array([6.0, 6.0, yaw]), np.array([9.0, 6.5, last])
    path, _, _ = planner.plan(model, a, b)
    c, s = math.cos(angle), math.sin(angle)
    turned = np.array([6.0 + 3.0 * c - 0.5 * s, 6.0 + 3.0 * s + 0.5 * c, last + angle])
    other, _, _ = planner.plan(model, a + (0.0, 0.0, angle), turned)
    assert other.cost == pytest.approx(path.cost, abs=1e-6)


def test_the_goal_is_worth_a_detour_but_not_a_long_one():
    """Round a wall from the one end to the other, the path is about as long as a taut string."""
    ground = _ground(8.0, 6.0, ((3.0, 0.0, 3.3, 4.0),))
    model = robot_model("double-integrator")
    start, goal = np.array([2.0, 1.0, 0.0]), np.array([4.5, 1.0, 0.0])
    path, _, _ = SpaceTimePlanner(ground).plan(model, start, goal)
    taut = math.dist((2.0, 1.0), (3.0, 4.15)) + 0.3 + math.dist((3.3, 4.15), (4.5, 1.0))
    assert taut - 0.1 <= path.length <= 1.1 * taut


_DOORWAY = ((2.9, 0.0, 3.3, 1.6), (2.9, 2.4, 3.3, 4.0))


@pytest.mark.parametrize("name", ["spirit", "unicycle", "unicycle-2", "double-integrator"])
def test_a_robot_waits_before_a_doorway_until_another_has_come_through(footprint_gap, name):
    ground = _ground(6.0, 4.0, _DOORWAY)
    model, go1 = robot_model(name), robot_model("go1")
    start, goal = np.array([2.0, 2.0, 0.0]), np.array([5.0, 2.0, 0.0])
    planner = SpaceTimePlanner(ground)
    alone, _, _ = planner.plan(model, start, goal)
    # It blocks the doorway for six seconds and then comes past.
    track = np.concatenate(
        [np.tile([3.1, 2.0, math.pi], (121, 1)), _walk((3.1, 2.0, math.pi), (0.6, 3.4, math.pi))]
    )
    others = _for_good([track], [go1])
    path, _, _ = planner.plan(model, start, goal, others)
    assert path.duration > max(alone.duration, 6.0)
    assert path.length < alone.length + 4.0
    assert _gaps(footprint_gap, path, others, [go1]) > 0.0
    assert _on_ground(footprint_gap, path, ground) > 0.0


def test_arrives_only_when_the_goal_is_free_for_good(footprint_gap):
    ground = _ground(8.0, 4.0)
    spirit = robot_model("spirit")
    # It comes past the goal late, long after the robot could be there.
    track = np.concatenate([np.tile([7.5, 2.0, 0.0], (300, 1)), _walk((7.5, 2.0, 0), (0.5, 3, 0))])
    others = _for_good([track], [spirit])
    start, goal = np.array([2.0, 2.0, 0.0]), np.array([5.0, 2.0, 0.0])
    path, _, _ = SpaceTimePlanner(ground).plan(spirit, start, goal, others)
    assert path.duration > 15.0
    assert _gaps(footprint_gap, path, others, [spirit]) > 0.0


@pytest.mark.parametrize("margins", MARGINS)
def test_a_goal_that_is_taken_for_good_is_given_up_at_once(margins):
    ground = _ground(8.0, 4.0)
    model = robot_model("go1")
    start, goal = np.array([2.0, 2.0, 0.0]), np.array([5.0, 2.0, 0.0])
    others = _for_good([_walk((2.0, 3.0, 0.0), (5.2, 2.1, 0.0))], [model])
    planner = SpaceTimePlanner(ground)
    assert planner.plan(model, start, goal, others, margins=margins) == (None, False, 0)


def test_no_more_expansions_than_are_allowed(cluttered):
    model = robot_model("spirit")
    start, goal = np.array([0.8, 1.0, 0.0]), np.array([7.2, 1.0, 0.0])
    planner = SpaceTimePlanner(cluttered)
    _, _, needed = planner.plan(model, start, goal)
    assert needed > 10
    for most in (1, 5, 10):
        path, spent, expansions = planner.plan(model, start, goal, NOBODY, most)
        assert path is None
        assert spent
        assert expansions <= 2 * most  # two costs-to-go


def test_the_same_again_gives_the_same_bytes(cluttered):
    others = _for_good([_walk((7.0, 3.0, 3.1), (1.5, 3.0, 3.1))], [robot_model("go1")])
    start, goal = np.array([0.8, 1.0, 0.0]), np.array([7.2, 1.0, 0.0])
    first, second = (
        SpaceTimePlanner(cluttered).plan(robot_model("spirit"), start, goal, others)[0]
        for _ in range(2)
    )
    assert first.moves.tobytes() == second.moves.tobytes()


def test_walled_in_there_is_nothing_to_find():
    ground = _ground(6.0, 4.0, ((2.9, 0.0, 3.3, 4.0),))
    start, goal = np.array([2.0, 2.0, 0.0]), np.array([5.0, 2.0, 0.0])
    path, spent, _ = SpaceTimePlanner(ground).plan(robot_model("go1"), start, goal)
    assert path is None
    assert not spent


def _raw(
    ground: Ground, model: RobotModel, start: Array, goal: Array, others: Others
) -> tuple[int, Array, Scene]:
    """What the search itself finds, before it is shortened, and where."""
    planner = SpaceTimePlanner(ground)
    scene = planner.scene(model, others, MARGINS[0])
    settings = SearchSettings(0.1, 0.25, 1.5, 5_000, 5_000)
    to_go = planner.cost_to_go(goal, model)
    status, moves, _, _ = search(
        scene, goal, primitives_of(model), to_go, settings, new_frontier(start)
    )
    return status, moves, scene


def _cost(moves: Array, scene: Scene) -> float:
    return float(moves[:, 5].sum() + scene.metre_cost * np.abs(moves[:, 0]).sum())


@settings(max_examples=25, deadline=None)
@given(_SEEDS, st.sampled_from(sorted(MODELS)), st.sampled_from((0, 1, 3, 100)))
def test_shortening_keeps_the_path_valid_and_never_makes_it_dearer(
    footprint_gap, cluttered, seed, name, states
):
    rng = np.random.default_rng(seed)
    model = robot_model(name)
    here, there = rng.uniform((2.0, 0.3, -3), (7.7, 3.7, 3), (2, 3))
    go1 = robot_model("go1")
    others = _for_good([_walk(tuple(here), tuple(there))], [go1])
    start, goal = np.array([0.7, 1.0, 0.0]), np.array([7.2, 1.0, rng.uniform(-3, 3)])
    status, moves, scene = _raw(cluttered, model, start, goal, others)
    if status != FOUND:
        return
    shorter, changed = shorten(scene, start, split(moves, scene.limits, 1.5), 0, states)
    assert _cost(shorter, scene) <= _cost(moves, scene) + 1e-6
    if not changed:
        assert _cost(shorter, scene) == pytest.approx(_cost(moves, scene))
    end, last = poses_between(start, moves)[-1], poses_between(start, shorter)[-1]
    assert last[:2] == pytest.approx(end[:2], abs=1e-6)
    if not scene.limits.free:
        assert math.remainder(last[2] - end[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    path = TimedPath(start, shorter, scene.limits, model)
    assert _gaps(footprint_gap, path, others, [go1]) > 0.0
    assert _on_ground(footprint_gap, path, cluttered) > -1e-9
    ends = np.cumsum(shorter[:, 5])
    for at in ends[:-1]:
        pair = sample_moves(start, shorter, scene.limits, np.array([at - 1e-7, at + 1e-7]))
        assert abs(np.subtract(*np.hypot(pair[:, 3], pair[:, 4]))) < 1e-5


@settings(max_examples=50, deadline=None)
@given(_SEEDS, st.sampled_from(sorted(MODELS)), st.floats(0.05, 3.0))
def test_split_moves_are_the_same_motion(seed, name, piece):
    rng = np.random.default_rng(seed)
    limits = motion_limits(robot_model(name))
    start = np.array([0.0, 0.0, 1.0])
    length = float(rng.uniform(0.1, 6.0))
    turn = 0.0 if limits.radius == 0.0 else float(rng.uniform(-1, 1)) * length / limits.radius
    rest, rows = np.zeros(6), np.zeros((3, 6))
    rest[5] = 1.0
    vmax = float(rng.uniform(0.5, 1.0) * limits.speed)
    for row, size in zip(rows, (length, -length), strict=False):
        assert make_move(row, size, turn, 0.0, 0.0, vmax, limits)
    rows[2] = rest
    parts = split(rows, limits, piece)
    assert np.abs(parts[:, 0]).max() <= piece + 1e-9
    time = np.linspace(0.0, rows[:, 5].sum() + 0.5, 200)
    whole = sample_moves(start, rows, limits, time)
    assert sample_moves(start, parts, limits, time) == pytest.approx(whole, abs=1e-6)


@pytest.mark.parametrize("name", sorted(MODELS))
def test_trajectories_are_the_path_as_samples(cluttered, name):
    model = robot_model(name)
    path, _, _ = SpaceTimePlanner(cluttered).plan(
        model, np.array([0.8, 1.0, 0.0]), np.array([7.2, 1.0, 1.0])
    )
    t = trajectory_of(path, cluttered)
    assert t.time[0] == 0.0
    assert t.time[-1] == pytest.approx(path.duration)
    steps = np.diff(t.time)
    assert steps.min() > 0.0
    assert steps.max() <= 0.03 + 1e-9
    assert t.length == pytest.approx(path.length, rel=1e-3)
    assert (t.position[:, 2] == (model.legs.h_nom if model.legs else 0.0)).all()
    motion = sample_moves(path.start, path.moves, path.limits, t.time)
    assert t.position[:, :2] == pytest.approx(motion[:, :2])
    if model.drive.startswith("integrator"):
        assert (t.yaw == path.start[2]).all()
    else:
        assert np.abs(np.diff(t.yaw)).max() <= 1.05 * model.max_yaw_rate * 0.03
    track = path.track()
    assert (len(track) - 1) * TRACK_STEP >= path.duration - 1e-9
    assert track[-1, :2] == pytest.approx([7.2, 1.0])
    assert track[0, :2] == pytest.approx(path.start[:2])


def test_tracks_of_others_are_stretched_by_standing():
    models = [robot_model("go1"), robot_model("double-integrator")]
    tracks = [np.arange(6.0).reshape(2, 3), np.arange(15.0).reshape(5, 3)]
    others = others_of(tracks, models, [(0, 0.0, 1.0), (1, 0.5, math.inf)])
    assert others.tracks.shape == (2, 5, 3)
    assert (others.tracks[0, 1:] == tracks[0][-1]).all()
    assert (others.tracks[1] == tracks[1]).all()
    assert others.shapes.tolist() == [[0.325, 0.14, 0.0], [0.15, 0.15, 1.0]]
    assert others.spans.tolist() == [[0.0, 0.0, 1.0], [1.0, 0.5, math.inf]]
    assert others_of([], [], []) is NOBODY


def test_the_cost_to_go_never_says_that_a_path_is_longer_than_it_is(cluttered):
    """Against straight lines around corners, less a cell and a half, as the search takes it."""
    model = robot_model("double-integrator")
    planner = SpaceTimePlanner(cluttered)
    goal = np.array([7.2, 1.0, 0.0])
    lengths, cell = planner.cost_to_go(goal, model)
    rng = np.random.default_rng(0)
    checked = 0
    for start in rng.uniform((0.3, 0.3), (7.7, 3.7), (40, 2)):
        path, _, _ = planner.plan(model, np.array([*start, 0.0]), goal)
        if path is None:
            continue
        checked += 1
        said = lengths[int(start[1] / cell), int(start[0] / cell)] - 1.5 * cell
        assert said <= path.length + 1e-9
    assert checked > 20
