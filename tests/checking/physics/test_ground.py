"""Ground with heights: where feet stand on it, and real walks over it."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking.heights import Heights
from cavalcade.checking.physics import floor_of, judge_robots
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap, generate_terrain

from .conftest import GO1, Recorder


def floor_from(height, places, cell=0.05):
    return floor_of(Heights(height, cell), places)


def test_a_slope_has_one_normal():
    x = 0.05 * (np.arange(80) + 0.5)
    places = np.array([[1.0, 1.0], [2.03, 1.51]])
    floor = floor_from(np.tile(0.3 * x, (60, 1)), places)
    low, high = floor.range_at(places, 0.02)
    assert (low <= 0.3 * places[:, 0] + 1e-9).all()
    assert (high >= 0.3 * places[:, 0] - 1e-9).all()
    wanted = np.array([-0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
    np.testing.assert_allclose(floor.normals_at(places, 0.02), [wanted, wanted], atol=1e-9)
    assert floor.even_at(places, 0.02).all()


def test_an_edge_has_none():
    height = np.zeros((60, 80))
    height[:, 40:] = 0.2
    places = np.array([[1.0, 1.0], [1.93, 1.0], [2.0, 1.0], [2.07, 1.0], [3.0, 1.0]])
    floor = floor_from(height, places)
    assert floor.even_at(places, 0.02).tolist() == [True, False, False, False, True]
    low, high = floor.range_at(places, 0.02)
    assert low.tolist() == [0.0, 0.0, 0.0, pytest.approx(0.2), pytest.approx(0.2)]
    assert high.tolist() == [0.0, 0.0, *[pytest.approx(0.2)] * 3]


@pytest.mark.parametrize("height", [0.02, 0.05, 0.3])
def test_nowhere_beside_an_edge_is_a_foot_on_even_ground(height):
    """However far it is from the edge, as long as its ball of 2 cm may touch it."""
    grid = np.zeros((100, 100))
    grid[:, 50:] = height
    x = np.arange(0.92, 1.0801, 0.002)
    places = np.stack([x, np.full(len(x), 1.0)], axis=1)
    even = floor_from(grid, places, 0.02).even_at(places, 0.02)
    # The edge rises between the centres of the cells at both sides of 1 m.
    assert not even[np.abs(x - 1.0) < 0.01 + 0.02].any()
    assert even[np.abs(x - 1.0) > 0.01 + 0.06 + 1e-6].all()


@pytest.mark.parametrize(
    ("kind", "options"),
    [("rough", {"height": 0.05}), ("slope", {"angle": 0.3}), ("stairs", {"height": 0.08})],
)
def test_a_walk_over_it_is_sound(kind, options):
    pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import PhysicsGround, TeamSimulator
    from cavalcade.lattice.ground import make_ground
    from cavalcade.locomotion.control import LegControl

    terrain = generate_terrain(kind, (7.0, 3.0), seed=1, **options)
    free = OccupancyMap(np.zeros(terrain.height.shape, bool), terrain.resolution, terrain.origin)
    models = [robot_model("go1")]
    ground = PhysicsGround.of_terrain(terrain)
    recorder = Recorder(TeamSimulator(models, [(1.0, 1.5, 0.0)], ground))
    control = LegControl(models, make_ground(free, terrain), terrain.origin)
    simulator = recorder.simulator
    control.begin(0.0, simulator.qpos)
    for step in range(4000):
        if step % 25 == 0:
            control.command([(0.4, 0.0, 0.0)], simulator.time)
        recorder.step(
            control.step(simulator.time, simulator.qpos, simulator.qvel, simulator.foot_forces)
        )
    (record,) = recorder.records()
    assert record.base[-1, 0] > 3.5
    heights = Heights(terrain.height, terrain.resolution, terrain.origin)
    found = judge_robots([record], [GO1], floor_of(heights, record.base[:, :2]))
    assert [violation.message for violation in found] == []
