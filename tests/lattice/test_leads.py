"""Leads out of and into places without room to turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.lattice.ground import make_ground
from cavalcade.lattice.leads import has_room, lead_free, lead_from
from cavalcade.lattice.planner import MARGINS, NOBODY, SpaceTimePlanner
from cavalcade.lattice.primitives import LENGTH, TURN
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap


def scene_of(model):
    lattice = SpaceTimePlanner(make_ground(OccupancyMap.empty((6.0, 4.0))))
    return lattice.scene(robot_model(model), NOBODY, MARGINS[1])


@pytest.mark.parametrize("model", ["go1", "spirit", "unicycle"])
@pytest.mark.parametrize("gap", [5e-3, 0.01, 0.03])
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("turned", [0.0, math.pi])
def test_leads_end_where_there_is_room(model, gap, way, turned):
    scene = scene_of(model)
    pose = np.array([3.0, scene.limits.half_width + gap, turned])
    assert not has_room(scene, pose)
    moves, there = lead_from(scene, pose, way)
    assert len(moves)
    assert has_room(scene, there)
    begin, end = (pose, there) if way > 0.0 else (there, pose)
    assert lead_free(scene, begin, moves, 0.0)
    x, y, yaw = begin
    for move in moves:
        yaw += move[TURN]
        x, y = x + move[LENGTH] * math.cos(yaw), y + move[LENGTH] * math.sin(yaw)
    assert (x, y, yaw) == pytest.approx(tuple(end), abs=1e-9)


def test_none_where_there_is_room_already_or_no_way():
    scene = scene_of("go1")
    assert len(lead_from(scene, np.array([3.0, 2.0, 0.0]), 1.0)[0]) == 0
    assert len(lead_from(scene, np.array([3.0, 0.1435, 0.0]), 1.0)[0]) == 0
    assert has_room(scene_of("unicycle-sphere"), np.array([3.0, 0.405, 0.0]))
