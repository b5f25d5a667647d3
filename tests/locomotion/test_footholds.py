from __future__ import annotations

import numpy as np
import pytest

from cavalcade.geometry import inverse_transform_points, transform_points
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion import leg_lengths, longest_leg, plan_footholds
from cavalcade.locomotion.footholds import FARTHEST
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap, generate_terrain

SPIRIT = robot_model("spirit")


@pytest.fixture
def level():
    return make_ground(OccupancyMap.empty((8.0, 4.0)))


def test_a_standing_robots_feet_are_below_its_hips(walk, level):
    path = walk(length=1.0, wait=3.0, start=(2.0, 2.0, 0.5))
    feet = plan_footholds(path, SPIRIT, level)
    first = feet[feet[:, 0] == 0.0]
    hips = transform_points(
        (2.0, 2.0, 0.5),
        [(SPIRIT.legs.hip_x * a, SPIRIT.legs.hip_y * b) for a in (1, -1) for b in (1, -1)],
    )
    assert first[:, 2].tolist() == [0.0, 1.0, 2.0, 3.0]
    np.testing.assert_allclose(first[:, 3:5], hips, atol=0.02)


def test_steps_of_an_even_walk_are_centred_below_the_hips(walk, level):
    path = walk(length=5.0)
    feet = plan_footholds(path, SPIRIT, level)
    inner = feet[(feet[:, 0] > 1.0) & (feet[:, 1] < path.duration - 1.0)]
    middle = path.poses_at(0.5 * (inner[:, 0] + inner[:, 1]))
    front = np.where(inner[:, 2] < 2, 1.0, -1.0)
    left = np.where(inner[:, 2] % 2 == 0, 1.0, -1.0)
    np.testing.assert_allclose(inner[:, 3], middle[:, 0] + front * SPIRIT.legs.hip_x, atol=2e-3)
    np.testing.assert_allclose(inner[:, 4], middle[:, 1] + left * SPIRIT.legs.hip_y, atol=1e-9)
    assert (inner[:, 5] == 0.0).all()


def test_a_moved_and_turned_walk_has_the_footholds_moved_and_turned(walk, level):
    plain = plan_footholds(walk(length=2.5, wait=0.4), SPIRIT, level)
    pose = (3.0, 1.5, 0.7)
    turned = plan_footholds(walk(length=2.5, wait=0.4, start=pose), SPIRIT, level)
    np.testing.assert_allclose(turned[:, :3], plain[:, :3], atol=1e-9)
    expected = transform_points(pose, plain[:, 3:5] - (1.0, 1.0))
    np.testing.assert_allclose(turned[:, 3:5], expected, atol=1e-9)


def test_the_ground_may_lie_anywhere_in_the_map(walk):
    terrain = generate_terrain("gap", (9.0, 4.0), seed=0, width=0.2)
    ground = make_ground(OccupancyMap.empty((9.0, 4.0)), terrain)
    origin = (-2.0, 5.0, 0.6)
    here = walk(length=5.0, start=(2.0, 2.0, 0.0))
    x, y = transform_points(origin, [(2.0, 2.0)])[0]
    there = walk(length=5.0, start=(x, y, 0.6))
    feet, moved = (
        plan_footholds(here, SPIRIT, ground),
        plan_footholds(there, SPIRIT, ground, origin),
    )
    np.testing.assert_allclose(moved[:, :3], feet[:, :3], atol=1e-9)
    np.testing.assert_allclose(
        inverse_transform_points(origin, moved[:, 3:5]), feet[:, 3:5], atol=1e-6
    )
    np.testing.assert_allclose(moved[:, 5], feet[:, 5], atol=1e-6)
    np.testing.assert_allclose(
        leg_lengths(moved, there, SPIRIT, ground, origin),
        leg_lengths(feet, here, SPIRIT, ground),
        atol=1e-6,
    )


def test_feet_keep_off_ground_that_does_not_carry(walk):
    terrain = generate_terrain("gap", (9.0, 4.0), seed=0, width=0.2)
    ground = make_ground(OccupancyMap.empty((9.0, 4.0)), terrain)
    path = walk(length=5.0, start=(2.0, 2.0, 0.0))
    feet = plan_footholds(path, SPIRIT, ground)
    cells = np.floor(feet[:, 4:2:-1] / ground.cell).astype(int)
    assert (ground.traversability[cells[:, 0], cells[:, 1]] >= 0.3).all()
    np.testing.assert_allclose(feet[:, 5], terrain.heights_at(feet[:, 3:5]), atol=0.02)
    free = plan_footholds(path, SPIRIT, make_ground(OccupancyMap.empty((9.0, 4.0))))
    moved = np.hypot(*(feet - free)[:, 3:5].T)
    assert 0.0 < moved.max() <= FARTHEST + ground.cell
    assert (moved == 0.0).mean() > 0.7


def test_feet_keep_off_solid_obstacles(walk):
    grid = np.zeros((80, 160), dtype=bool)
    grid[22:24, 40:60] = True  # y from 1.10 to 1.20 m: where the left feet would stand
    ground = make_ground(OccupancyMap(grid, 0.05))
    feet = plan_footholds(walk(length=5.0, start=(1.0, 1.08, 0.0)), SPIRIT, ground)
    cells = np.floor(feet[:, 4:2:-1] / 0.05).astype(int)
    assert not grid[cells[:, 0], cells[:, 1]].any()


def test_legs_reach_their_footholds_in_a_leap(leap, level):
    path = leap(speed=1.5)
    feet = plan_footholds(path, SPIRIT, level)
    assert leg_lengths(feet, path, SPIRIT, level).max() <= longest_leg(SPIRIT.legs)


def test_a_foot_that_cannot_be_reached_is_said_so(walk, level):
    path = walk()
    feet = plan_footholds(path, SPIRIT, level)
    feet[5, 3] += 1.0
    lengths = leg_lengths(feet, path, SPIRIT, level)
    assert np.flatnonzero(lengths > longest_leg(SPIRIT.legs)).tolist() == [5]


def test_robots_without_legs_have_no_feet(walk, level):
    model = robot_model("unicycle")
    feet = plan_footholds(walk(), model, level)
    assert feet.shape == (0, 6)
    assert leg_lengths(feet, walk(), model, level).shape == (0,)
