"""Kernels are compiled or loaded before the clock of a plan starts, once in a process."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from cavalcade.kinodynamic.obstruction import find_path
from cavalcade.kinodynamic.parameters import make_body, make_space
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap
from cavalcade.world.shapes import Shape
from cavalcade.world.terrain import generate_terrain


@cache
def warm_up() -> None:
    """Use every kernel of `plan_body` once, unless this process has done so already."""
    ground, model = trench(), robot_model("spirit")
    start, goal = (1.0, 1.0, 0.0), (3.5, 1.0, 0.0)
    plan_body(ground, model, start, goal, BodySettings(iterations=300))
    published = BodySettings(iterations=300, variant="published", discs=np.zeros((1, 3)))
    plan_body(ground, model, start, goal, published)
    # Round a wall, so that paths on the grid are looked for; without a trench, strings are pulled.
    wall = Box((2.7, 2.1), (0.15, 1.8))
    start, goal = (0.5, 2.0, 0.0), (3.5, 2.0, 0.0)
    level = make_ground(OccupancyMap.empty((4.5, 3.0)).with_shapes([wall]))
    for ground in (level, trench([wall])):
        plan_body(ground, model, start, goal, BodySettings(iterations=300, improve=50))
    find_path(make_space(ground, make_body(model, margin=0.01)), start, goal)


def trench(solids: Sequence[Shape] = ()) -> Ground:
    """Level ground, 4.5 x 3 m, with a trench across that asks for a leap, and solids on it."""
    terrain = generate_terrain("gap", (4.5, 3.0), width=0.3)
    return make_ground(OccupancyMap.empty(terrain.size).with_shapes(solids), terrain)
