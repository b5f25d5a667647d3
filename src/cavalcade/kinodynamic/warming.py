"""Kernels are compiled or loaded before the clock of a plan starts, once in a process."""

from __future__ import annotations

import numpy as np

from cavalcade.eikonal import surface_distance
from cavalcade.kinodynamic._rrt_connect import search
from cavalcade.kinodynamic.obstruction import find_path
from cavalcade.kinodynamic.parameters import make_body, make_space
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground
from cavalcade.robots import robot_model


def warm_up() -> None:
    """Use every kernel of `plan_body` once, unless this process has done so already."""
    if search.signatures:
        return
    ground, model = trench(), robot_model("spirit")
    start, goal = (1.0, 1.0, 0.0), (3.5, 1.0, 0.0)
    plan_body(ground, model, start, goal, BodySettings(iterations=300))
    published = BodySettings(iterations=300, variant="published", discs=np.zeros((1, 3)))
    plan_body(ground, model, start, goal, published)
    # Round a wall, so that paths on the grid are looked for.
    start, goal = (0.5, 2.0, 0.0), (3.5, 2.0, 0.0)
    ground.solid[25:, 52:55] = True
    ground = ground._replace(clearance=surface_distance(ground.solid, ground.cell))
    plan_body(ground, model, start, goal, BodySettings(iterations=300, improve=50))
    find_path(make_space(ground, make_body(model, margin=0.01)), start, goal)


def trench() -> Ground:
    """Level ground, 4.5 x 3 m, with a trench across that asks for a leap."""
    rows, cols, cell = 60, 90, 0.05
    y, x = (np.arange(rows) + 0.5) * cell, (np.arange(cols) + 0.5) * cell
    near_y, near_x = np.minimum(y, rows * cell - y), np.minimum(x, cols * cell - x)
    near = np.minimum(near_y[:, None], near_x[None])
    solid = np.zeros((rows, cols), dtype=bool)
    height, level = np.zeros((rows, cols)), np.zeros((rows, cols))
    ground = Ground(cell, solid, near, False, height, level, level, level, np.ones((rows, cols)))
    ground.height[:, 40:46] = -1.0
    ground.traversability[:, 39:47] = 0.0
    ground.solid[0, 0] = True
    return ground
