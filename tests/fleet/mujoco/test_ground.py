"""The ground that physics feels is the ground that maps and terrain say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco import PhysicsGround, TeamSimulator
from cavalcade.fleet.mujoco.ground import movable_spans
from cavalcade.robots import robot_model
from cavalcade.scenario import build_world, load_scenario
from cavalcade.world import OccupancyMap, Terrain

mujoco = pytest.importorskip("mujoco")

GO1 = robot_model("go1")


def simulated(ground, pose=(1.0, 1.0, 0.0)):
    return TeamSimulator([GO1], [pose], ground)


def heights(simulator, points, above=5.0):
    """Heights `(N,)` of what a ray from above hits at points `(N, 2)`, robots left out."""
    hit = np.zeros(1, dtype=np.int32)
    found = []
    groups = np.array([1, 1, 1, 0, 1, 1], dtype=np.uint8)  # robots' solids are of group 3
    for x, y in points:
        away = mujoco.mj_ray(
            simulator.model,
            simulator.data,
            np.array([x, y, above]),
            np.array([0.0, 0.0, -1.0]),
            groups,
            1,
            -1,
            hit,
        )
        found.append(above - away)
    return np.array(found)


def points_on(grid, count, seed=0, inset=0.0):
    """Random points `(count, 2)` in the map frame on a map or terrain."""
    random = np.random.default_rng(seed)
    size = np.array(grid.size)
    local = inset + random.random((count, 2)) * (size - 2.0 * inset)
    x, y, yaw = grid.origin
    c, s = math.cos(yaw), math.sin(yaw)
    return local @ np.array([[c, s], [-s, c]]) + (x, y)


def hilly(origin, rows=30, cols=50, cell=0.1):
    y, x = np.mgrid[0:rows, 0:cols] * cell
    return Terrain.from_heights(
        0.2 * np.sin(1.3 * x) + 0.1 * np.cos(2.1 * y) + 0.05 * x, cell, origin
    )


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (2.0, -1.0, 0.7), (-3.0, 4.0, -2.5)])
def test_rays_meet_the_terrain_where_its_heights_are(origin):
    terrain = hilly(origin)
    start = points_on(terrain, 1, inset=1.2)[0]
    simulator = simulated(PhysicsGround.of_terrain(terrain), (*start, 0.0))
    points = points_on(terrain, 200, seed=1, inset=0.05)
    # Triangles there, bilinear patches here: they differ by less than the patches' twist.
    np.testing.assert_allclose(
        heights(simulator, points), terrain.heights_at(points), atol=0.25 * 0.1**2
    )
    centers = OccupancyMap(np.zeros((30, 50), bool), 0.1, origin).centers([[3, 40], [25, 7]])
    np.testing.assert_allclose(
        heights(simulator, centers), terrain.height[[3, 25], [40, 7]], atol=1e-5
    )


def test_a_single_bump_is_where_it_is_said_to_be():
    raw = np.zeros((20, 40))
    raw[5, 30] = 0.1
    terrain = Terrain.from_heights(raw, 0.1)
    simulator = simulated(PhysicsGround.of_terrain(terrain))
    places = np.array([[3.05, 0.55], [0.55, 3.05], [3.05, 1.55], [0.95, 0.55]])
    np.testing.assert_allclose(heights(simulator, places[:1]), [0.1], atol=1e-6)
    np.testing.assert_allclose(heights(simulator, places[2:]), 0.0, atol=1e-6)


def test_walls_stand_around_terrain_and_nothing_within():
    terrain = hilly((2.0, -1.0, 0.7))
    start = points_on(terrain, 1, inset=1.2)[0]
    simulator = simulated(PhysicsGround.of_terrain(terrain), (*start, 0.0))
    c, s = math.cos(0.7), math.sin(0.7)
    local = np.array([[-0.1, 1.5], [5.1, 1.5], [2.5, -0.1], [2.5, 3.1]])
    beyond = local @ np.array([[c, s], [-s, c]]) + (2.0, -1.0)
    assert (heights(simulator, beyond) > terrain.heights_at(beyond) + 0.4).all()


def test_level_terrain_is_a_plane_at_its_height():
    terrain = Terrain.from_heights(np.full((20, 20), 0.3), 0.1)
    simulator = simulated(PhysicsGround.of_terrain(terrain))
    assert simulator.model.nhfield == 0
    np.testing.assert_allclose(heights(simulator, [[1.0, 0.5]]), 0.3)
    assert simulator.qpos[0, 2] == pytest.approx(0.3 + GO1.description.stand_height)


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (1.0, -2.0, 0.5)])
def test_rays_meet_obstacles_where_the_map_is_occupied(origin):
    random = np.random.default_rng(3)
    grid = random.random((40, 60)) < 0.1
    grid[15:25, 25:35] = False
    map = OccupancyMap(grid, 0.1, origin)
    start = map.centers([[20, 30]])[0]
    simulator = simulated(PhysicsGround.of_map(map), (*start, 0.0))
    cells = np.argwhere(np.ones_like(grid))[::7]
    hit = heights(simulator, map.centers(cells)) > 0.25
    np.testing.assert_array_equal(hit, grid[tuple(cells.T)])


def test_robots_stand_on_the_slope_they_start_on(hold):
    x = np.mgrid[0:40, 0:40][1] * 0.1
    terrain = Terrain.from_heights(0.1 * x, 0.1)
    simulator = simulated(PhysicsGround.of_terrain(terrain), (2.0, 2.0, 0.3))
    angles = simulator.qpos[:, 7:]
    assert simulator.data.contact.dist.min() > -0.01
    hold(simulator, 750, wanted=angles)
    weight = 9.81 * GO1.description.mass
    total = np.zeros(3)
    force = np.zeros(6)
    for number in range(simulator.data.ncon):
        mujoco.mj_contactForce(simulator.model, simulator.data, number, force)
        frame = simulator.data.contact.frame[number].reshape(3, 3)
        total += frame.T @ force[:3]
    np.testing.assert_allclose(np.abs(total), [0.0, 0.0, weight], atol=0.03 * weight)
    assert (simulator.foot_forces > 0.0).all()


def test_a_robot_is_stopped_by_a_wall():
    grid = np.zeros((40, 40), bool)
    grid[:, 20] = True  # from x = 2.0 to 2.1 m
    simulator = simulated(PhysicsGround.of_map(OccupancyMap(grid, 0.1)), (1.5, 2.0, 0.0))
    simulator.push(0, (200.0, 0.0, 0.0), 1.0)
    for _ in range(500):
        simulator.step(np.zeros((1, 12)))
    assert simulator.qpos[0, 0] < 2.0


def test_the_ground_of_a_scenario(tmp_path):
    text = """
version: 1
name: moving
world:
  empty: {size: [8, 6]}
  obstacles:
    - {box: {center: [4, 2], size: [1.0, 0.4], yaw: 0.3}}
    - {circle: {center: [6, 4], radius: 0.3}}
robots: [{model: go1, start: [1.4, 3.0, 0.0]}]
task: {formation: {shape: custom, slots: [[0, 0]]}, goals: [[2.0, 3.0, 0.0]]}
execution:
  events:
    - {at: 1.0, add: {circle: {center: [2, 5], radius: 0.25}}}
    - {at: 2.0, move: {circle: {center: [6, 4], radius: 0.3}, to: [6, 1], speed: 1.0}}
"""
    file = tmp_path / "moving.yaml"
    file.write_text(text)
    world = build_world(load_scenario(file))
    ground = PhysicsGround.of_world(world)
    assert len(ground.fixed) == 5  # the box, and walls
    assert len(ground.movable) == len(movable_spans(world)) == 2
    simulator = simulated(ground, (1.4, 3.0, 0.0))
    circle, added = [[6.0, 4.0]], [[2.0, 5.0]]
    inside_box = [[4.0 + 0.45 * math.cos(0.3), 2.0 + 0.45 * math.sin(0.3)]]
    np.testing.assert_allclose(heights(simulator, inside_box), 0.5)
    np.testing.assert_allclose(heights(simulator, [*circle, *added]), 0.0)
    for number, span in enumerate(movable_spans(world)):
        here = span.obstacle_at(0.0)
        simulator.place_obstacle(number, None if here is None else span.offset_at(0.0))
    simulator.step(np.zeros((1, 12)))
    np.testing.assert_allclose(heights(simulator, [*circle, *added]), [0.5, 0.0])
    for number, span in enumerate(movable_spans(world)):
        simulator.place_obstacle(number, span.offset_at(10.0))
    simulator.step(np.zeros((1, 12)))
    np.testing.assert_allclose(heights(simulator, [*circle, [6.0, 1.0], *added]), [0.0, 0.5, 0.5])
    with pytest.raises(InputError, match="finite"):
        simulator.place_obstacle(0, (math.nan, 0.0))


def test_obstacles_on_terrain_stand_on_it():
    terrain = hilly((0.0, 0.0, 0.0))
    ground = PhysicsGround.of_terrain(terrain)
    for block in ground.fixed:
        assert block.bottom == terrain.height.min()
        assert block.top <= terrain.height.max() + 0.5 + 1e-9
    highest = max(block.top for block in ground.fixed)
    assert highest > terrain.height.max() + 0.4
