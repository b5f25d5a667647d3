"""Velocities told from poses."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.formation.estimation import VelocityTracker
from cavalcade.robots import robot_model
from cavalcade.robots.motion import advance, limits_of

GO1 = robot_model("go1")
COMMANDS = np.array([[0.4, 0.05, 0.6], [-0.3, 0.0, -1.0]])


def test_robots_that_obey_have_the_predicted_velocity():
    tracker = VelocityTracker(GO1)
    states = np.array([[1.0, 2.0, 3.1, 0, 0, 0], [4.0, 1.0, -3.1, 0, 0, 0]])
    for cycle in range(40):
        _, found = tracker.update(states[:, :3].copy(), cycle * 0.05)
        np.testing.assert_allclose(found, states[:, 3:], atol=0.01)
        tracker.commanded(COMMANDS)
        for k, command in enumerate(COMMANDS):
            state = tuple(states[k])
            for _ in range(5):
                state = advance(state, tuple(command), 0.01, limits_of(GO1))
            states[k] = state


def test_noise_on_the_poses_does_not_become_speed():
    rng = np.random.default_rng(3)
    tracker = VelocityTracker(GO1)
    tracker.commanded(np.zeros((1, 3)))
    for cycle in range(50):
        _, found = tracker.update(
            np.array([[1.0, 1.0, 0.0]]) + rng.normal(0, 0.003, 3), cycle * 0.05
        )
        assert np.abs(found).max() < 0.02
        tracker.commanded(np.zeros((1, 3)))


def test_a_robot_that_jerks_is_measured():
    tracker = VelocityTracker(GO1)
    for x, yaw in ((0.0, 3.12), (0.05, 3.17)):
        _, found = tracker.update(np.array([[x, 0.0, yaw]]), x)
        tracker.commanded(np.zeros((1, 3)))
    np.testing.assert_allclose(found, [[1.0, 0.0, 1.0]], atol=1e-9)


@pytest.mark.parametrize("speed", [0.15, 0.3, 0.45])
def test_a_robot_that_does_not_stop_when_told_is_noticed(speed):
    """Late or lost commands: it rolls on at a speed that no prediction confirms."""
    tracker = VelocityTracker(GO1)
    tracker.update(np.zeros((1, 3)), 0.0)
    tracker.commanded(np.array([[speed, 0.0, 0.0]]))
    x = 0.0
    for cycle in range(1, 30):
        x += speed * 0.05
        _, found = tracker.update(np.array([[x, 0.0, 0.0]]), cycle * 0.05)
        tracker.commanded(np.array([[speed if cycle < 10 else 0.0, 0.0, 0.0]]))
    assert found[0, 0] == pytest.approx(speed, abs=0.1)


@pytest.mark.parametrize("later", [0.0, -1.0, 3.0])
def test_after_a_gap_in_time_the_team_counts_as_standing(later):
    tracker = VelocityTracker(GO1)
    tracker.update(np.zeros((1, 3)), 1.0)
    tracker.commanded(np.zeros((1, 3)))
    assert (tracker.update(np.ones((1, 3)), 1.0 + later)[1] == 0.0).all()
