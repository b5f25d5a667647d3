"""Robots touch each other and the world, never themselves."""

from __future__ import annotations

import pytest

from cavalcade.fleet.mujoco.ground_spec import WORLD_AFFINITY, WORLD_TYPE
from cavalcade.fleet.mujoco.robot_spec import robot_bits


def touch(one, other):
    """MuJoCo's rule."""
    return bool(one[0] & other[1]) or bool(other[0] & one[1])


@pytest.mark.parametrize("robots", [1, 2, 30, 31, 100, 436])
def test_every_pair_but_a_robot_and_itself(robots):
    world = (WORLD_TYPE, WORLD_AFFINITY)
    bits = robot_bits(robots)
    assert len(bits) == robots
    assert not touch(world, world)
    for k, mine in enumerate(bits):
        assert all(0 <= code < 2**31 for code in mine)
        assert touch(world, mine)
        assert not touch(mine, mine)
        assert all(touch(mine, its) for its in bits[:k])
