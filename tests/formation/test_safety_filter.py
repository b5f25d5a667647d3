"""Laws of the safety filter, judged by geometry of the tests' own."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance
from cavalcade.formation import SafetyFilter, SafetyInputs
from cavalcade.formation._clearance import ObstacleBoxes, Surroundings
from cavalcade.formation._least_change import TeamState
from cavalcade.robots import robot_model
from cavalcade.robots.motion import advance, limits_of
from cavalcade.world import OccupancyMap

GO1 = robot_model("go1")
SIZE = (GO1.length, GO1.width)
LIMITS = limits_of(GO1)
PERIOD, CELL, RADIUS = 0.05, 0.05, 0.30
STOP = round(0.7 / PERIOD)

seeds = st.integers(0, 2**32 - 1)


class Scene:
    """A team on a map, and the filter that watches over it."""

    def __init__(self, poses, occupied, boxes=None, frozen=(), radius=RADIUS):
        self.poses = np.array(poses, dtype=float)
        self.velocities = np.zeros_like(self.poses)
        self.occupied = occupied
        self.distances = surface_distance(occupied, CELL)
        self.boxes = boxes or ObstacleBoxes.none()
        self.frozen = np.isin(np.arange(len(poses)), frozen)
        self.rank = np.arange(len(poses))
        self.radius = radius
        self.filter = SafetyFilter(GO1, PERIOD)

    def commands(self, wanted):
        wanted, count = np.array(wanted, dtype=float), len(self.poses)
        team = TeamState(
            self.poses, self.velocities, wanted, self.rank, self.frozen, np.zeros(count, bool),
            np.full(count, self.radius),
        )  # fmt: skip
        return self.filter.apply(
            SafetyInputs(team, Surroundings(self.distances, CELL, *self.boxes))
        )

    def advance(self, commands, cycles=1, seen=None, substeps=5):
        """Obey for so many cycles; `seen` is called with the poses of every substep."""
        for _ in range(cycles * substeps):
            for k, command in enumerate(commands):
                state = (*self.poses[k], *self.velocities[k])
                state = advance(state, tuple(command), PERIOD / substeps, LIMITS)
                self.poses[k], self.velocities[k] = state[:3], state[3:]
            if seen is not None:
                seen(self.poses)

    def copy(self):
        other = Scene(self.poses, self.occupied, self.boxes, (), self.radius)
        other.velocities, other.frozen = self.velocities.copy(), self.frozen
        other.rank = self.rank
        return other


class Closest:
    """Least gap of each pair and of each robot to the map, over what was seen."""

    def __init__(self, tools, scene):
        self.tools, self.scene = tools, scene
        count = len(scene.poses)
        self.pairs = dict.fromkeys(combinations(range(count), 2), math.inf)
        self.map = [math.inf] * count

    def __call__(self, poses):
        for i, j in self.pairs:
            if math.dist(poses[i, :2], poses[j, :2]) < 1.0:
                gap = self.tools.sampled_gap(poses[i], poses[j], SIZE, SIZE)
                self.pairs[i, j] = min(self.pairs[i, j], gap)
        for k, pose in enumerate(poses):
            gap = self.tools.occupied_gap(pose, SIZE, self.scene.occupied, CELL)
            self.map[k] = min(self.map[k], gap)

    @property
    def least(self):
        return min([*self.pairs.values(), *self.map])


def random_scene(tools, seed, moving=False, attempts=60):
    """Robots at rest (or moving) in a small cluttered room, none of them touching anything."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros((70, 70), dtype=bool)
    for row, col in rng.integers(10, 60, (3, 2)):
        occupied[row : row + rng.integers(1, 6), col : col + rng.integers(1, 6)] = True
    poses: list[np.ndarray] = []
    for _ in range(attempts):
        pose = np.append(rng.uniform(0.4, 3.1, 2), rng.uniform(-np.pi, np.pi))
        free = tools.occupied_gap(pose, SIZE, occupied, CELL) > 0.05
        apart = all(tools.sampled_gap(pose, other, SIZE, SIZE) > 0.05 for other in poses)
        if free and apart and len(poses) < 6:
            poses.append(pose)
    scene = Scene(poses, occupied)
    scene.rank = rng.permutation(len(poses))
    if moving:
        heading = rng.uniform(-np.pi, np.pi, len(poses))
        pace = rng.uniform(0.0, 1.0, len(poses))
        body = pace[:, None] * np.column_stack([0.5 * np.cos(heading), 0.2 * np.sin(heading)])
        c, s = np.cos(scene.poses[:, 2]), np.sin(scene.poses[:, 2])
        scene.velocities[:, 0] = c * body[:, 0] - s * body[:, 1]
        scene.velocities[:, 1] = s * body[:, 0] + c * body[:, 1]
        scene.velocities[:, 2] = rng.uniform(-1.2, 1.2, len(poses))
    return scene, rng


def wishes(rng, count):
    """Wanted velocities, many of them far too fast."""
    return np.column_stack([rng.normal(0.0, 0.6, (count, 2)), rng.normal(0.0, 1.5, count)])


@example(1045)
@example(1065)
@settings(max_examples=12, deadline=None)
@given(seeds)
def test_from_rest_no_wish_ever_leads_to_contact(tools, seed):
    """Wishes change every half second; the team is followed through every cycle and a stop."""
    scene, rng = random_scene(tools, seed)
    closest = Closest(tools, scene)
    for _ in range(6):
        wanted = wishes(rng, len(scene.poses))
        for _ in range(10):
            commands, _ = scene.commands(wanted)
            scene.advance(commands)
            closest(scene.poses)
    scene.advance(np.zeros_like(scene.poses), STOP, closest, 2)
    assert closest.least > 0.0


@settings(max_examples=25, deadline=None)
@given(seeds)
def test_commands_keep_clear_what_stopping_keeps_clear(tools, seed):
    """Also from states that no filter let happen: per pair and per robot, never worse."""
    scene, rng = random_scene(tools, seed, moving=True)
    commands, _ = scene.commands(wishes(rng, len(scene.poses)))
    asked, stopped = scene.copy(), scene.copy()
    after, instead = Closest(tools, asked), Closest(tools, stopped)
    asked.advance(commands, 1, after, 4)
    asked.advance(np.zeros_like(commands), STOP, after, 3)
    stopped.advance(np.zeros_like(commands), STOP + 1, instead, 3)
    for pair, gap in instead.pairs.items():
        assert after.pairs[pair] > 0.0 or gap < 0.03
    for found, gap in zip(after.map, instead.map, strict=True):
        assert found > 0.0 or gap < 0.05


@settings(max_examples=30, deadline=None)
@given(seeds)
def test_a_free_robot_gets_what_it_wants(seed):
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid([2.0, 5.0], [2.0, 5.0]), axis=-1).reshape(-1, 2)
    scene = Scene(np.column_stack([places, rng.uniform(-3, 3, 4)]), np.zeros((140, 140), bool))
    wanted = wishes(rng, 4)
    commands, levels = scene.commands(wanted)
    np.testing.assert_allclose(commands, scene.filter.in_body(scene.poses, wanted), atol=1e-12)
    assert (levels == 0).all()


@settings(max_examples=30, deadline=None)
@given(seeds)
def test_wishes_become_body_velocities_within_the_limits(seed):
    rng = np.random.default_rng(seed)
    scene = Scene([[2.0, 2.0, rng.uniform(-3.0, 3.0)]], np.zeros((80, 80), bool))
    wanted = wishes(rng, 1)
    (command,) = scene.filter.in_body(scene.poses, wanted)
    assert math.hypot(command[0] / GO1.max_speed_x, command[1] / GO1.max_speed_y) <= 1 + 1e-9
    assert abs(command[2]) <= GO1.max_yaw_rate
    # The direction is kept.
    yaw = scene.poses[0, 2]
    back = np.array([math.cos(yaw) * command[0] - math.sin(yaw) * command[1],
                     math.sin(yaw) * command[0] + math.cos(yaw) * command[1]])  # fmt: skip
    assert back @ wanted[0, :2] == pytest.approx(np.hypot(*back) * np.hypot(*wanted[0, :2]))


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_the_mirrored_problem_has_the_mirrored_answer(tools, seed):
    scene, rng = random_scene(tools, seed, moving=True)
    wanted = wishes(rng, len(scene.poses))
    commands, levels = scene.commands(wanted)
    flip = np.array([1.0, -1.0, -1.0])
    mirrored = Scene(scene.poses * flip + (0.0, 70 * CELL, 0.0), scene.occupied[::-1].copy())
    mirrored.velocities, mirrored.rank = scene.velocities * flip, scene.rank
    found, steps = mirrored.commands(wanted * flip)
    np.testing.assert_allclose(found, commands * flip, atol=1e-6)
    np.testing.assert_array_equal(steps, levels)


@settings(max_examples=15, deadline=None)
@given(seeds)
def test_the_same_problem_has_the_same_answer(tools, seed):
    scene, rng = random_scene(tools, seed, moving=True)
    wanted = wishes(rng, len(scene.poses))
    first, _ = scene.commands(wanted)
    second, _ = scene.copy().commands(wanted)
    np.testing.assert_array_equal(first, second)


def facing(gap):
    """Two robots nose to nose, `gap` apart, in the middle of a hall."""
    half = (gap + GO1.length) / 2.0
    return Scene([[3.0 - half, 3.0, 0.0], [3.0 + half, 3.0, np.pi]], np.zeros((120, 120), bool))


def nose_to_nose(cycles=120):
    """Gaps and commands of two robots that want through each other."""
    scene, log = facing(2.0), []
    for _ in range(cycles):
        commands, _ = scene.commands([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]])
        scene.advance(commands)
        log.append((scene.poses.copy(), commands))
    poses, commands = zip(*log, strict=True)
    return np.array(poses), np.array(commands)


def test_nose_to_nose_they_keep_apart(tools):
    poses, _ = nose_to_nose()
    gaps = [tools.sampled_gap(*pair, SIZE, SIZE) for pair in poses]
    assert min(gaps) > 0.0
    assert gaps[-1] < 0.12


def test_nose_to_nose_nobody_shakes():
    _, commands = nose_to_nose()
    assert np.abs(commands[60:, :, 2]).mean() < 0.2


def test_the_later_in_rank_gives_way_more():
    scene = facing(0.35)
    wanted = np.array([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]])
    for rank in ((0, 1), (1, 0)):
        scene.rank = np.array(rank)
        commands, _ = scene.commands(wanted)
        changes = np.abs(commands[:, 0] - 0.5)
        assert changes[rank.index(0)] < changes[rank.index(1)]


def test_parting_robots_are_not_held():
    scene = facing(0.08)
    wanted = np.array([[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0]])
    commands, levels = scene.commands(wanted)
    np.testing.assert_allclose(commands[:, 0], -0.4, atol=1e-6)
    assert (levels == 0).all()


def test_a_robot_that_cannot_be_commanded_is_driven_around_not_through(tools):
    scene = facing(1.0)
    scene.frozen = np.array([False, True])
    for _ in range(80):
        commands, _ = scene.commands([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
        assert (commands[1] == 0.0).all()
        scene.advance(commands)
    assert tools.sampled_gap(*scene.poses, SIZE, SIZE) > 0.02


@pytest.mark.parametrize("radius", [0.21, 0.30])
def test_it_does_not_turn_into_a_wall(tools, radius):
    """Beside a wall there is room along the body but not across it."""
    occupied = np.zeros((80, 80), dtype=bool)
    occupied[:20] = True
    scene = Scene([[2.0, 1.0 + 0.24, 0.0]], occupied, radius=radius)
    for _ in range(60):
        commands, _ = scene.commands([[0.0, -0.1, 1.2]])
        scene.advance(commands)
        assert tools.occupied_gap(scene.poses[0], SIZE, occupied, CELL) > 0.0


@pytest.mark.parametrize("speed", [0.1, 0.3])
def test_a_slow_mover_from_behind_is_given_room(tools, speed):
    """It pushes a robot that wants to stand, as long as there is room to go."""
    box = np.array([1.0, 2.0, 0.0])
    scene = Scene([[2.0, 2.0, 0.0]], np.zeros((80, 160), bool))
    for _ in range(100):
        scene.boxes = ObstacleBoxes(box[None], np.full((1, 2), 0.15), np.array([[speed, 0.0]]))
        commands, _ = scene.commands(np.zeros((1, 3)))
        scene.advance(commands)
        box[0] += speed * PERIOD
        assert tools.sampled_gap(scene.poses[0], box, SIZE, (0.3, 0.3)) > 0.0


def test_all_rolled_out_commands_end_at_rest():
    """The certificate's horizon is long enough for a full stop from any velocity."""
    rng = np.random.default_rng(4)
    scene = Scene(np.zeros((1, 3)), np.zeros((4, 4), bool))
    horizon = scene.filter.parameters.horizon
    steps, dt = horizon.steps - horizon.substeps, PERIOD / horizon.substeps
    for _ in range(200):
        heading, yaw = rng.uniform(-np.pi, np.pi, 2)
        body = np.array([0.5 * math.cos(heading), 0.2 * math.sin(heading)])
        c, s = math.cos(yaw), math.sin(yaw)
        state = (0.0, 0.0, yaw, c * body[0] - s * body[1], s * body[0] + c * body[1],
                 rng.choice([-1.2, 1.2]))  # fmt: skip
        for _ in range(steps):
            state = advance(state, (0.0, 0.0, 0.0), dt, LIMITS)
        assert np.abs(state[3:]).max() < 0.02


@pytest.mark.parametrize("rate", [2.0, 10.0, 20.0, 50.0, 100.0])
def test_any_rate_stops_in_time(tools, rate):
    occupied = np.zeros((80, 120), dtype=bool)
    occupied[:, 100:] = True
    guard = SafetyFilter(GO1, 1.0 / rate)
    map = OccupancyMap(np.where(occupied, 100, 0).astype(np.int8), CELL)
    distances, state = None, (3.0, 2.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(round(8.0 * rate)):
        inputs = SafetyInputs.of(
            map, [state[:3]], [state[3:]], [(0.5, 0.0, 0.0)], clearance=RADIUS, distances=distances
        )
        distances = inputs.surroundings.distances
        commands, _ = guard.apply(inputs)
        for _ in range(10):
            state = advance(state, tuple(commands[0]), 0.1 / rate, LIMITS)
        assert tools.occupied_gap(np.array(state[:3]), SIZE, occupied, CELL) > 0.0
    assert state[0] > 5.0 - 0.325 - 0.15


def test_beside_a_robot_that_is_lost_only_footprints_count():
    """A slot 0.5 m beside a lost robot could not be reached for the distance of centres."""
    closest = {}
    for frozen in ((0,), ()):
        scene = Scene([[2.0, 2.0, 0.0], [2.0, 2.8, 0.0]], np.zeros((80, 80), bool), frozen=frozen)
        for _ in range(120):
            commands, _ = scene.commands([[0.0, 0.0, 0.0], [0.0, -0.2, 0.0]])
            scene.advance(commands)
        closest[frozen] = float(np.hypot(*(scene.poses[1] - scene.poses[0])[:2]))
    gaps = scene.filter.parameters.insisted
    assert closest[()] >= gaps.centres
    assert GO1.width + gaps.footprint <= closest[(0,)] < GO1.width + 0.1
