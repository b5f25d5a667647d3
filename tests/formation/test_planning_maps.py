"""The planner's view of the map, and what changes in it when cells change."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import FormationSettings
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.world import Box, OccupancyMap

CELL = 0.05
SETTINGS = FormationSettings(d_safe_a=0.6, d_safe_b=0.3)


def speeds(maps):
    """W_A and W_B as arrays, as the fields see them."""
    return maps.leader.speed, maps.speed_b


def assert_same(maps, fresh):
    for a, b in zip(speeds(maps), speeds(fresh), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)
    # What the filter asks of distances: exact as far as it looks.
    near = fresh.distance < maps.radius + 0.5
    np.testing.assert_allclose(maps.distance[near], fresh.distance[near], atol=1e-9)
    assert (maps.distance[~near] >= maps.radius + 0.5 - 1e-9).all()


@st.composite
def changes(draw):
    """A grid and a few successive changes of small regions."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = draw(st.sampled_from([(90, 130), (140, 60), (30, 200)]))
    occupied = rng.random(shape) < draw(st.sampled_from([0.0, 0.002, 0.02]))
    states = [occupied]
    for _ in range(draw(st.integers(1, 4))):
        occupied = occupied.copy()
        row, col = rng.integers(0, shape[0]), rng.integers(0, shape[1])
        size = rng.integers(1, 12, 2)
        patch = occupied[row : row + size[0], col : col + size[1]]
        patch[:] = rng.random(patch.shape) < rng.choice([0.0, 0.3, 1.0])
        states.append(occupied)
    return states


@settings(max_examples=40, deadline=None)
@given(changes())
def test_a_changed_ground_equals_one_built_anew(states):
    maps = PlanningMaps(states[0], CELL, SETTINGS)
    for occupied in states[1:]:
        maps = maps.changed(occupied)
        assert_same(maps, PlanningMaps(occupied, CELL, SETTINGS))


@settings(max_examples=10, deadline=None)
@given(changes())
def test_also_for_the_robots_of_a_tight_route(states):
    maps = PlanningMaps(states[0], CELL, SETTINGS).changed(states[-1]).tightened(0.21)
    assert_same(maps, PlanningMaps(states[-1], CELL, SETTINGS, 0.21))


def test_also_where_the_followers_keep_the_larger_distance():
    settings_ = FormationSettings(d_safe_a=0.3, d_safe_b=1.2)
    occupied = np.zeros((160, 240), dtype=bool)
    changed = occupied.copy()
    changed[80, 120] = True
    maps = PlanningMaps(occupied, CELL, settings_).changed(changed)
    fresh = PlanningMaps(changed, CELL, settings_)
    np.testing.assert_allclose(maps.speed_b, fresh.speed_b, atol=1e-9)


def test_also_for_a_rigid_body_of_many_robots():
    occupied = np.zeros((240, 240), dtype=bool)
    changed = occupied.copy()
    changed[20, 20] = True
    wide = PlanningMaps(occupied, CELL, SETTINGS).changed(changed).tightened(2.0)
    np.testing.assert_allclose(
        speeds(wide)[0], speeds(PlanningMaps(changed, CELL, SETTINGS, 2.0))[0], atol=1e-9
    )


def test_without_a_change_it_is_the_same_ground():
    maps = PlanningMaps(np.zeros((20, 30), dtype=bool), CELL, SETTINGS)
    assert maps.changed(np.zeros((20, 30), dtype=bool)) is maps


def test_the_velocity_maps_are_the_papers():
    maps = PlanningMaps(np.zeros((100, 140), dtype=bool), CELL, FormationSettings())
    distance = np.minimum.reduce(
        [np.broadcast_to(np.minimum(k + 0.5, n - 0.5 - k), (100, 140)) * CELL
         for k, n in ((np.arange(100)[:, None], 100), (np.arange(140)[None], 140))]
    )  # fmt: skip
    np.testing.assert_allclose(maps.distance, distance)
    leader, follower = speeds(maps)
    np.testing.assert_allclose(follower, np.clip((distance - 0.30) / 0.50, 0, 1), atol=1e-9)
    np.testing.assert_allclose(leader, np.clip((distance - 0.30) / 1.50, 0, 1), atol=1e-9)


def test_off_the_map_nobody_may_drive():
    maps = PlanningMaps(np.zeros((60, 80), dtype=bool), CELL, SETTINGS)
    points = np.array([[-0.1, 1.0], [1.0, 3.1], [99.0, 99.0], [2.0, 1.5]])
    assert maps.speed_at(points).tolist() == [0.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize("cell", [0.02, 0.05, 0.25, 0.5])
def test_the_distance_of_a_point_was_that_of_its_cell(cell):
    occupied = np.zeros((30, 40), dtype=bool)
    occupied[12, 17] = occupied[20, 30] = True
    maps = PlanningMaps(occupied, cell, FormationSettings())
    low = np.array([[17.0, 12.0], [30.0, 20.0]])
    for point in np.random.default_rng(0).uniform((0.0, 0.0), (40.0, 30.0), (60, 2)):
        out = np.maximum(np.maximum(low - point, point - low - 1.0), 0.0)
        exact = min(*np.hypot(*out.T), *point, *((40.0, 30.0) - point))
        assert maps.distance_at(point * cell) == pytest.approx(exact * cell, abs=1e-12)
    assert maps.distance_at(np.array([-0.1, 1.0])) == 0.0


class TestRegions:
    MAP = OccupancyMap.empty((8.0, 4.0), CELL).with_shapes([Box((4.0, 2.0), (0.4, 4.0))])
    GROUND = PlanningMaps(MAP.occupied, CELL, FormationSettings())

    def test_the_sides_of_a_wall_are_two(self):
        left, right = (self.GROUND.component(np.array([x, 2.0])) for x in (2.0, 6.0))
        assert left != right
        assert 0 not in (left, right)

    def test_a_point_in_the_inflated_zone_belongs_to_the_nearest_region(self):
        left = self.GROUND.component(np.array([2.0, 2.0]))
        assert self.GROUND.component(np.array([3.7, 2.0])) == left

    def test_ground_that_is_all_occupied_has_none(self):
        maps = PlanningMaps(np.ones((40, 40), dtype=bool), CELL, FormationSettings())
        assert maps.component(np.array([1.0, 1.0])) == 0

    def test_a_placement_is_found_in_the_wanted_region_only(self):
        left = self.GROUND.component(np.array([2.0, 2.0]))
        point, slot = np.zeros((1, 2)), np.array([[5.0, 2.0]])
        shift = self.GROUND.placement(slot, left, 3.0, point, 0.1)
        assert shift is not None
        # To 0.30 m from the wall at 3.8 m.
        assert shift[0] == pytest.approx(-1.55, abs=CELL)
        assert abs(shift[1]) < CELL
        assert self.GROUND.placement(slot + (2.5, 0.0), left, 3.0, point, 0.1) is None

    def test_a_placement_keeps_the_clearance_of_every_disc(self):
        """Discs before and behind the slot: the front one must clear the wall."""
        left = self.GROUND.component(np.array([2.0, 2.0]))
        slot = np.array([[3.45, 2.0]])  # 0.35 m to the wall
        for front, needed in ((0.2, 0.1), (0.2, 0.3), (0.4, 0.2)):
            body = np.array([[-front, 0.0], [front, 0.0]])
            shift = self.GROUND.placement(slot, left, 3.0, body, needed)
            assert shift is not None
            assert shift[0] == pytest.approx(min(0.0, 0.35 - front - needed), abs=CELL)
            where = slot + shift + body
            assert (self.GROUND.clearance(where) >= needed).all()

    def test_what_fits_is_not_moved(self):
        left = self.GROUND.component(np.array([2.0, 2.0]))
        slots = np.array([[1.0, 1.0], [2.0, 3.0]])
        body = np.array([[-0.2, 0.0], [0.2, 0.0]])
        shift = self.GROUND.placement(slots, left, 3.0, body, 0.25)
        assert shift is not None
        np.testing.assert_allclose(shift, 0.0, atol=1e-12)


class TestBodies:
    """Robots that stand for good are obstacles to find ways around."""

    GO1 = (0.65, 0.28)
    FREE = PlanningMaps(np.zeros((80, 120), dtype=bool), CELL, SETTINGS)

    @settings(max_examples=40, deadline=None)
    @given(st.floats(0.5, 5.5), st.floats(0.5, 3.5), st.floats(-4.0, 4.0))
    def test_cells_under_a_body_are_occupied_and_no_others(self, tools, x, y, yaw):
        pose = np.array([x, y, yaw])
        found = self.FREE.with_bodies(pose[None], *self.GO1).occupied
        under = tools.rectangle_points(pose, *self.GO1, 0.01) / CELL
        cols, rows = np.floor(under).astype(int).T
        missed = ~found[rows, cols]
        # Sampled at half a cell: no more than a cell's corner goes unnoticed.
        inner = tools.rectangle_points(pose, 0.60, 0.23, 0.02) / CELL
        assert found[inner[:, 1].astype(int), inner[:, 0].astype(int)].all()
        assert missed.mean() < 0.1
        rows, cols = np.nonzero(found)
        centres = (np.column_stack([cols, rows]) + 0.5) * CELL
        assert tools.distance_to_rectangle(centres, pose, *self.GO1).max() <= 1.3 * CELL

    def test_the_ground_itself_stays_as_it_is(self):
        before = self.FREE.occupied.copy()
        other = self.FREE.with_bodies(np.array([[2.0, 2.0, 0.3]]), *self.GO1)
        assert other is not self.FREE
        np.testing.assert_array_equal(self.FREE.occupied, before)
        assert self.FREE.speed_at(np.array([[2.0, 2.0]]))[0] == 1.0
        assert other.speed_at(np.array([[2.0, 2.0]]))[0] == 0.0

    def test_it_equals_one_built_with_the_bodies(self):
        poses = np.array([[2.0, 2.0, 0.3], [4.0, 1.0, -1.2]])
        other = self.FREE.with_bodies(poses, *self.GO1)
        assert_same(other, PlanningMaps(other.occupied, CELL, SETTINGS))

    @pytest.mark.parametrize("pose", [(-3.0, 2.0, 0.0), (99.0, 99.0, 1.0), (-0.6, -0.6, 0.8)])
    def test_bodies_off_the_map_are_nothing(self, pose):
        assert self.FREE.with_bodies(np.array([pose]), *self.GO1) is self.FREE

    def test_one_across_the_border_is_cut_off_there(self):
        found = self.FREE.with_bodies(np.array([[0.0, 2.0, 0.0]]), *self.GO1).occupied
        rows, cols = np.nonzero(found)
        assert cols.max() <= 7
        assert abs(rows.mean() + 0.5 - 40) < 1.0

    def test_one_in_a_door_divides_the_ground(self):
        door = np.zeros((80, 120), dtype=bool)
        door[:, 58:62] = True
        door[32:48, 58:62] = False  # 0.80 m
        open_ = PlanningMaps(door, CELL, SETTINGS)
        shut = open_.with_bodies(np.array([[3.0, 2.0, np.pi / 2]]), *self.GO1)
        left, right = np.array([1.0, 2.0]), np.array([5.0, 2.0])
        assert open_.component(left) == open_.component(right)
        assert shut.component(left) != shut.component(right)
