"""Figures of commanded velocities, against motion that is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cavalcade.metrics.command_tracking import body_velocities, stretches, summarise_commands
from cavalcade.recording.frames import Recording


def recording(commands: Any, velocity: Any, period: float = 0.05) -> Recording:
    """One robot that moves with a constant velocity in its own frame, whatever it is told."""
    said = np.array(commands, dtype=float)[:, None]
    time = period * np.arange(len(said))
    vx, vy, rate = velocity
    yaw = 0.3 + rate * time
    if rate:
        # An arc: the exact integral of a velocity that turns with the body.
        x = (vx * np.sin(yaw) + vy * np.cos(yaw)) / rate
        y = (vy * np.sin(yaw) - vx * np.cos(yaw)) / rate
    else:
        x = time * (np.cos(0.3) * vx - np.sin(0.3) * vy)
        y = time * (np.sin(0.3) * vx + np.cos(0.3) * vy)
    poses = np.column_stack([x, y, yaw])[:, None]
    return Recording(time, poses, poses, said, (), (), ())


def test_velocities_of_the_body() -> None:
    moved = recording(np.zeros((50, 3)), (0.4, -0.1, 0.8))
    found = body_velocities(moved.time, moved.poses[:, 0])
    # Chords are shorter than arcs.
    assert found == pytest.approx(np.tile([0.4, -0.1, 0.8], (49, 1)), rel=1e-3)


def test_errors_are_those_of_the_means() -> None:
    found = summarise_commands(recording([[0.5, 0, 0]] * 101, (0.48, 0.01, 0.0)))
    assert found == pytest.approx(
        {"speed_error": 0.04, "yaw_rate_error": None, "drift_m_s": 0.01, "rms_m_s": 0.02}
    )
    found = summarise_commands(recording([[0, 0, 1.0]] * 101, (0.0, 0.0, 0.9)))
    assert found["yaw_rate_error"] == pytest.approx(0.1)
    assert found["speed_error"] is None


def test_the_first_seconds_of_a_command_do_not_count() -> None:
    said = [[0.2, 0, 0]] * 30 + [[0.4, 0, 0]] * 71
    ((command, velocities),) = stretches(recording(said, (0.4, 0.0, 0.0)))
    assert command.tolist() == [0.4, 0.0, 0.0]
    # 3.5 s from the change to the last cycle, less two.
    assert len(velocities) == 30


def test_a_push_counts_as_a_new_command() -> None:
    moved = recording([[0.4, 0, 0]] * 141, (0.4, 0.0, 0.0))
    (_, first), (_, last) = stretches(moved, [(3.52, 0), (1.0, 1)])
    # 2 s of each are left out.
    assert (len(first), len(last)) == (31, 29)


def test_commands_that_change_all_the_time_have_no_figures() -> None:
    said = [[0.01 * k, 0, 0] for k in range(100)]
    assert set(summarise_commands(recording(said, (0.1, 0, 0))).values()) == {None}
