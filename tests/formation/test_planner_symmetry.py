"""Commands depend on the situation, not on the frame it is told in, nor on its handedness."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.formation import VARIANTS, Formation, FormationPlanner, Imperfections
from cavalcade.geometry import transform_points
from cavalcade.world import Box, Circle, OccupancyMap

SIZE, CELL = (8.0, 5.0), 0.05
SHAPES = [Circle((4.1, 2.2), 0.3), Box((5.5, 3.9), (0.6, 0.3), 0.4), Circle((2.9, 4.1), 0.2)]
ROOM = OccupancyMap.empty(SIZE, CELL).with_shapes(SHAPES)
FORMATION = Formation.square(1.0)
GOAL = np.array([6.37, 2.41, 0.5])


def start(seed):
    rng = np.random.default_rng(seed)
    poses = np.column_stack([FORMATION.placed((1.503, 2.517, 0.0)), np.zeros(4)])
    return poses + rng.uniform(-0.1, 0.1, (4, 3))


def commands(map, goal, poses, variant, cycles=1):
    """The commands of some cycles in which the team stays where it is."""
    planner = FormationPlanner(map, FORMATION, variant=variant, seed=3)
    planner.set_goal(goal)
    return np.array([planner.step(poses, k * 0.05) for k in range(cycles)]), planner.status


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("origin", [(3.0, -7.0, 0.0), (-2.0, 1.0, 0.7), (0.5, 0.5, -2.9)])
def test_where_the_map_lies_makes_no_difference(variant, origin):
    poses = start(1)
    moved_map = OccupancyMap(ROOM.grid, CELL, origin)
    moved = np.column_stack([transform_points(origin, poses[:, :2]), poses[:, 2] + origin[2]])
    goal = np.array([*transform_points(origin, GOAL[None, :2])[0], GOAL[2] + origin[2]])
    here, status = commands(ROOM, GOAL, poses, variant, 3)
    there, other = commands(moved_map, goal, moved, variant, 3)
    np.testing.assert_allclose(there, here, atol=1e-6)
    np.testing.assert_array_equal(other.roles, status.roles)
    assert other.leader == status.leader
    np.testing.assert_allclose(other.goals, transform_points(origin, status.goals), atol=1e-6)
    for a, b in zip(other.paths, status.paths, strict=True):
        np.testing.assert_allclose(a, transform_points(origin, b), atol=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.12])
def test_nor_where_poses_are_noisy_and_commands_late(delay):
    origin = (-2.0, 1.0, 0.7)
    here = FormationPlanner(ROOM, FORMATION, expected=Imperfections(0.02, 0.02, delay))
    there = FormationPlanner(
        OccupancyMap(ROOM.grid, CELL, origin), FORMATION, expected=Imperfections(0.02, 0.02, delay)
    )
    here.set_goal(GOAL)
    there.set_goal([*transform_points(origin, GOAL[None, :2])[0], GOAL[2] + origin[2]])
    for k in range(12):
        poses = start(1) + (0.012 * k, 0.002 * k, 0.01 * k)
        moved = np.column_stack([transform_points(origin, poses[:, :2]), poses[:, 2] + origin[2]])
        np.testing.assert_allclose(
            there.step(moved, k * 0.05), here.step(poses, k * 0.05), atol=1e-6
        )


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(sorted(VARIANTS)), st.integers(0, 2**32 - 1))
def test_the_mirrored_world_has_mirrored_commands(tools, variant, seed):
    poses = start(seed)
    flip = np.array([1.0, -1.0, -1.0])
    shift = np.array([0.0, SIZE[1], 0.0])
    here, status = commands(ROOM, GOAL, poses, variant, 2)
    there, other = commands(
        tools.mirrored(ROOM), GOAL * flip + shift, poses * flip + shift, variant, 2
    )
    np.testing.assert_allclose(there, here * flip, atol=1e-5)
    assert other.leader == status.leader
    np.testing.assert_allclose(other.goals, status.goals * (1, -1) + (0, SIZE[1]), atol=1e-5)


@pytest.mark.parametrize("variant", ["cavalcade", "published"])
def test_the_same_seed_gives_the_same_drive(tools, variant):
    drives = []
    for _ in range(2):
        planner = FormationPlanner(ROOM, FORMATION, variant=variant, seed=5)
        planner.set_goal(GOAL)
        drives.append(tools.drive(planner, start(2), 10.0))
    np.testing.assert_array_equal(drives[0].commands, drives[1].commands)
    np.testing.assert_array_equal(drives[0].poses, drives[1].poses)


def test_the_clocks_zero_makes_no_difference():
    poses = start(4)
    early, late = (FormationPlanner(ROOM, FORMATION) for _ in range(2))
    for planner in (early, late):
        planner.set_goal(GOAL)
    for k in range(4):
        a, b = early.step(poses, k * 0.05), late.step(poses, 1.7e9 + k * 0.05)
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_turning_a_robot_round_once_makes_no_difference():
    poses = start(6)
    turned = poses + np.array([0.0, 0.0, 2.0 * np.pi])
    np.testing.assert_allclose(
        commands(ROOM, GOAL, turned, "cavalcade")[0],
        commands(ROOM, GOAL, poses, "cavalcade")[0],
        atol=1e-6,
    )
