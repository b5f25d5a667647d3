"""Stepping aside for dynamic obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.eikonal import surface_distance
from cavalcade.formation._clearance import Surroundings
from cavalcade.formation.dynamic_avoidance import DynamicAvoidance
from cavalcade.geometry import rotation
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

SIZE, CELL, TOP = (12.0, 8.0), 0.05, 0.5
OPEN = OccupancyMap.empty(SIZE, CELL)
MOVER = (2.0, 4.0, 0.0, 0.25, 0.25)  # a square of 0.5 m
EAST = (0.4, 0.0)
NEEDED = 0.25 + 0.55  # half its width and the room a body needs


def evaded(poses, wanted=None, mover=MOVER, speed=EAST, map=OPEN, active=None):
    """What becomes of the wanted velocities `(N, 3)`."""
    poses = np.array(poses, dtype=float).reshape(-1, 3)
    wanted = np.zeros_like(poses) if wanted is None else np.array(wanted, dtype=float)
    wanted = wanted.reshape(-1, 3)
    active = np.arange(len(poses)) if active is None else np.array(active)
    movers, speeds = np.array(mover).reshape(-1, 5), np.array(speed).reshape(-1, 2)
    distances = surface_distance(map.occupied, CELL)
    around = Surroundings(distances, CELL, movers[:, :3].copy(), movers[:, 3:].copy(), speeds)
    still = np.zeros_like(poses)
    DynamicAvoidance(robot_model("go1"), TOP).apply(wanted, poses, still, active, around, 0.30)
    return wanted


class TestInTheStrip:
    @pytest.mark.parametrize(("y", "side"), [(4.3, 1.0), (3.7, -1.0), (4.79, 1.0), (3.21, -1.0)])
    def test_it_is_left_at_full_speed_on_the_nearer_side(self, y, side):
        found = evaded((3.5, y, 0.0), (0.3, 0.1, 0.0))
        np.testing.assert_allclose(found[0, :2], (0.0, side * TOP), atol=1e-9)

    @pytest.mark.parametrize("y", [4.3, 3.7])
    def test_on_the_free_side_if_the_nearer_is_barred(self, y):
        side = 1.0 if y > 4.0 else -1.0
        map = OPEN.with_shapes([Box((4.0, 4.0 + side * 0.8), (6.0, 0.4))])
        assert evaded((3.5, y, 0.0), map=map)[0, 1] * -side > 0.9 * TOP

    def test_between_two_walls_on_the_nearer_all_the_same(self):
        map = OPEN.with_shapes([Box((4.0, 5.0), (6.0, 0.4)), Box((4.0, 3.0), (6.0, 0.4))])
        assert evaded((3.5, 4.1, 0.0), map=map)[0, 1] > 0.9 * TOP
        assert evaded((3.5, 3.9, 0.0), map=map)[0, 1] < -0.9 * TOP

    @settings(max_examples=60, deadline=None)
    @given(st.floats(-3.1, 3.1))
    def test_the_body_turns_its_longer_axis_that_way(self, yaw):
        """Forwards or backwards; whichever is less of a turn."""
        rate = evaded((3.5, 4.3, yaw))[0, 2]
        turn = math.remainder(math.pi / 2 - yaw, math.pi)
        if abs(abs(turn) - math.pi / 2) > 1e-6:
            assert rate == pytest.approx(np.clip(3.0 * turn, -1.2, 1.2), abs=1e-6)
        assert abs(rate) <= 1.2

    def test_a_longer_body_across_has_a_wider_strip(self):
        beside = (3.5, 5.0, 0.0)
        along = (2.0, 4.0, 0.0, 1.0, 0.1)
        across = (2.0, 4.0, math.pi / 2, 1.0, 0.1)
        assert (evaded(beside, mover=along) == 0.0).all()
        assert evaded(beside, mover=across)[0, 1] == TOP


class TestOutside:
    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_beside_the_strip_one_that_would_enter_waits(self, side):
        pose = (3.5, 4.0 + side * (NEEDED + 0.1), 0.0)
        found = evaded(pose, (0.3, -side * 0.2, 0.5))
        np.testing.assert_allclose(found[0], (0.3, 0.0, 0.5), atol=1e-9)

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_one_that_goes_along_or_away_goes_on(self, side):
        pose = (3.5, 4.0 + side * (NEEDED + 0.1), 0.0)
        for wanted in ((0.3, side * 0.2, 0.5), (0.3, 0.0, 0.0), (-0.3, 0.0, 0.1)):
            np.testing.assert_array_equal(evaded(pose, wanted)[0], wanted)

    @pytest.mark.parametrize(
        "pose",
        [
            (3.5, 4.0 + NEEDED + 0.31, 0.0),  # well beside
            (1.2, 4.0, 0.0),  # behind
            (2.0 + 0.65 + 0.4 * 5.0 + 0.01, 4.0, 0.0),  # more than 5 s ahead
        ],
    )
    def test_those_it_does_not_meet_go_on(self, pose):
        wanted = (0.1, -0.2, 0.3) if pose[1] > 4.0 else (-0.3, 0.1, 0.2)
        np.testing.assert_array_equal(evaded(pose, wanted)[0], wanted)

    def test_the_faster_it_is_the_farther_it_is_seen(self):
        ahead = (5.5, 4.1, 0.0)
        assert (evaded(ahead, speed=(0.4, 0.0)) == 0.0).all()
        assert evaded(ahead, speed=(0.8, 0.0))[0, 1] == TOP


def test_what_stands_still_is_left_to_the_map_and_the_filter():
    wanted = (0.3, 0.1, 0.2)
    np.testing.assert_array_equal(evaded((2.8, 4.0, 0.0), wanted, speed=(0.0, 0.0))[0], wanted)


def test_one_that_takes_no_part_is_told_nothing():
    found = evaded([(3.5, 4.1, 0.0), (3.5, 3.9, 0.0)], np.zeros((2, 3)), active=[1])
    assert (found[0] == 0.0).all()
    assert found[1, 1] == -TOP


def test_of_several_each_is_heeded():
    movers = [MOVER, (10.0, 6.0, 0.0, 0.25, 0.25)]
    poses = [(3.5, 4.1, 0.0), (8.5, 5.9, 0.0), (6.0, 2.0, 0.0)]
    found = evaded(poses, mover=movers, speed=[EAST, (-0.4, 0.0)])
    assert found[0, 1] == TOP
    assert found[1, 1] == -TOP
    assert (found[2] == 0.0).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_mirrored_situation_has_the_mirrored_answer(tools, seed):
    rng = np.random.default_rng(seed)
    map = OPEN.with_shapes([Box(tuple(rng.uniform((2.0, 2.0), (8.0, 6.0))), (1.0, 0.4))])
    poses = np.column_stack([rng.uniform((1.0, 2.0), (8.0, 6.0), (6, 2)), rng.uniform(-3, 3, 6)])
    wanted = rng.uniform(-0.4, 0.4, (6, 3))
    mover = np.array([*rng.uniform((2.0, 3.0), (5.0, 5.0)), rng.uniform(-3, 3), 0.5, 0.2])
    speed = rng.uniform(-0.6, 0.6, 2)
    flip, shift = np.array([1.0, -1.0, -1.0]), np.array([0.0, SIZE[1], 0.0])
    here = evaded(poses, wanted, mover, speed, map)
    there = evaded(
        poses * flip + shift,
        wanted * flip,
        np.append(mover[:3] * flip + shift, mover[3:]),
        speed * flip[:2],
        tools.mirrored(map),
    )
    np.testing.assert_allclose(there, here * flip, atol=1e-6)


@settings(max_examples=40, deadline=None)
@given(st.floats(-3.1, 3.1), st.integers(0, 2**32 - 1))
def test_so_has_the_turned_one(angle, seed):
    rng = np.random.default_rng(seed)
    centre, turn = np.array([6.0, 4.0]), rotation(angle)
    offsets, yaw = rng.uniform(-1.5, 1.5, (6, 2)), rng.uniform(-3, 3, 6)
    wanted = rng.uniform(-0.4, 0.4, (6, 3))
    mover, speed = np.array([-0.8, 0.3]), np.array([0.35, 0.2])

    def answer(matrix, by):
        poses = np.column_stack([offsets @ matrix.T + centre, yaw + by])
        turned = np.column_stack([wanted[:, :2] @ matrix.T, wanted[:, 2]])
        box = (*(matrix @ mover + centre), 0.2 + by, 0.4, 0.2)
        return evaded(poses, turned, box, matrix @ speed)

    here, there = answer(np.eye(2), 0.0), answer(turn, angle)
    np.testing.assert_allclose(there[:, :2], here[:, :2] @ turn.T, atol=1e-6)
    np.testing.assert_allclose(there[:, 2], here[:, 2], atol=1e-6)
