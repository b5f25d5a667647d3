"""A ramp up and down that met between two samples looked like a jump in place to the checker."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.lattice.motion_limits import motion_limits
from cavalcade.lattice.planner import TimedPath, trajectory_of
from cavalcade.lattice.primitives import make_move
from cavalcade.robots import MODELS, robot_model


@pytest.mark.parametrize("name", sorted(MODELS))
@pytest.mark.parametrize("length", [0.05, 0.11965, 0.3, 2.0])
def test_places_are_the_integral_of_velocities_between_all_samples(name, length):
    model = robot_model(name)
    limits = motion_limits(model)
    moves = np.zeros((2, 6))
    make_move(moves[0], 0.0, 0.7, 0.0, 0.0, 0.0, limits)
    make_move(moves[1], length, 0.0, 0.0, 0.0, limits.speed, limits)
    path = trajectory_of(TimedPath(np.zeros(3), moves, limits, model))
    steps = np.diff(path.time)[:, None]
    assert steps.min() > 0.0
    assert steps.max() <= 0.03 + 1e-9
    # Accelerations are constant between samples, so that the trapezoidal rule is exact.
    moved = 0.5 * steps * (path.velocity[1:] + path.velocity[:-1])
    assert np.diff(path.position, axis=0) == pytest.approx(moved, abs=1e-7)
