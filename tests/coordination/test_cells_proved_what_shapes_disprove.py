"""Proofs hold for obstacles as they are; where they are known as cells alone, answers say so."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.coordination import PlanSettings, TeamProblem, plan_team
from cavalcade.lattice.collision import grid_of, pose_free
from cavalcade.lattice.ground import make_ground
from cavalcade.lattice.motion_limits import footprint
from cavalcade.robots import robot_model
from cavalcade.world import Box, Circle, OccupancyMap, Polygon
from cavalcade.world.gaps import body_at, nearest_obstacle

CELLS = (0.02, 0.025, 0.05, 0.1, 0.2, 0.25, 0.5)
ROOM = (6.0, 4.0)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("gap", [0.001, 0.0018, 0.005, 0.02, 0.05])
@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_starts_near_a_box_are_free_at_any_cell_size(make_team_of_words, cell, gap, yaw):
    # Beside a box, whose corner the cell holds, too.
    c, s = math.cos(yaw), math.sin(yaw)
    away = 0.2 + 0.14 + gap
    boxes = {"box": {"center": [2.01 + away * s, 1.68 - away * c], "size": [1.0, 0.4], "yaw": yaw}}
    robots = [("go1", (2.01, 1.68, yaw), (4.0, 2.0, 0.0))]
    problem = make_team_of_words(ROOM, robots, obstacles=[boxes], resolution=cell)
    plan = plan_team(problem)
    assert plan.solved, plan.detail


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("width", [0.27, 0.279, 0.29, 0.3, 0.32])
def test_doors_are_as_wide_as_their_walls_say(make_team_of_words, cell, width):
    edge = (2.0 - width / 2.0) / 2.0
    walls = [((3.013, edge), (0.1, 2.0 * edge)), ((3.013, 4.0 - edge), (0.1, 2.0 * edge))]
    problem = make_team_of_words(
        ROOM, [("go1", (1.0, 2.0, 0.0), (5.0, 2.0, 0.0))], walls, resolution=cell
    )
    few = PlanSettings(iterations=60_000 if width > 0.28 else 2_000)
    plan = plan_team(problem, settings=few)
    assert plan.solved == (width > 0.28), plan.detail


def test_where_only_cells_are_known_the_answer_says_so():
    box = Box((2.01, 1.32), (1.0, 0.4))
    start, goal = (2.0, 1.68, 0.0), (4.0, 2.0, 0.0)
    room = OccupancyMap.empty(ROOM)
    plan = plan_team(TeamProblem.on_map(room.with_shapes([box]), ["go1"], [start], [goal]))
    assert plan.reason == "infeasible"
    assert "occupied cell of the map (0.05 m wide)" in plan.detail
    known = TeamProblem.on_map(room, ["go1"], [start], [goal], shapes=[box])
    assert plan_team(known).solved


_SHAPES = st.lists(
    st.one_of(
        st.builds(
            Box,
            st.tuples(st.floats(0.5, 3.5), st.floats(0.5, 3.5)),
            st.tuples(st.floats(0.05, 2.0), st.floats(0.05, 2.0)),
            st.floats(-3, 3),
        ),
        st.builds(Circle, st.tuples(st.floats(0, 4), st.floats(0, 4)), st.floats(0.05, 1.0)),
        st.builds(
            lambda x, y, s: Polygon(
                tuple((x + s * a, y + s * b) for a, b in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2)))
            ),
            st.floats(0, 3),
            st.floats(0, 3),
            st.floats(0.1, 1.0),
        ),
    ),
    min_size=1,
    max_size=4,
)


@given(
    _SHAPES,
    st.sampled_from(CELLS),
    st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 4.0), st.floats(-4, 4)),
    st.sampled_from(["go1", "unicycle-sphere"]),
)
@settings(max_examples=300, deadline=None)
def test_poses_are_free_where_the_shapes_leave_them_free(shapes, cell, pose, name):
    """Against the exact gap; both ways, for every size of cell."""
    room, model = OccupancyMap.empty((4.0, 4.0), cell), robot_model(name)
    grid = grid_of(make_ground(room, None, shapes))
    gap, _ = nearest_obstacle(body_at(model, pose), room, shapes)
    free = pose_free(grid, footprint(model), *pose, 0.0)
    if gap > 1e-6:
        assert free
    elif nearest_obstacle(body_at(_smaller(model), pose), room, shapes)[0] == 0.0:
        assert not free


def _smaller(model):
    return replace(model, length=model.length - 1e-6, width=model.width - 1e-6)


@given(_SHAPES, st.sampled_from(CELLS), st.floats(-1, 1))
@settings(max_examples=60, deadline=None)
def test_clearance_is_that_of_the_shapes(shapes, cell, yaw):
    room = OccupancyMap(np.zeros((round(4 / cell),) * 2, dtype=bool), cell, (0.1, -0.2, yaw))
    ground = make_ground(room, None, shapes)
    rows, cols = ground.clearance.shape
    rng = np.random.default_rng(0)
    for row, col in zip(rng.integers(0, rows, 20), rng.integers(0, cols, 20), strict=True):
        point = room.centers([[row, col]])
        border = min(row + 0.5, col + 0.5, rows - row - 0.5, cols - col - 0.5) * cell
        exact = min(border, *(float(shape.distance(point)[0]) for shape in shapes))
        found = float(ground.clearance[row, col])
        if ground.outlines.part[row, col] >= 0:
            assert found <= 0.7072 * cell  # inside, it is the distance to the outline
        else:
            assert found == pytest.approx(min(exact, 2.0), abs=1e-6) or found > 2.0 - 1e-9
