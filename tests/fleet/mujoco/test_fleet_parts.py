"""What the fleet in physics is made of: poses from states, measured states, peaks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco._postures import (
    angles_of,
    find_falls,
    planar_poses,
    planar_velocities,
)
from cavalcade.fleet.mujoco._step import keep_peaks
from cavalcade.fleet.mujoco.sensing import Sensing, SensingErrors, turned

ANGLES = arrays(float, (5, 3), elements=st.floats(-1.5, 1.5))


def quaternions(rotation: Rotation) -> np.ndarray:
    return rotation.as_quat()[:, (3, 0, 1, 2)]


def states(angles: Any, heights: Any = 0.3) -> np.ndarray:
    """`(N, 19)` with these yaws, pitches and rolls."""
    rotation = Rotation.from_euler("ZYX", np.asarray(angles, dtype=float))
    qpos = np.zeros((len(rotation), 19))
    qpos[:, 2] = heights
    qpos[:, 3:7] = quaternions(rotation)
    return qpos


@settings(max_examples=50, deadline=None)
@given(ANGLES)
def test_angles_are_those_of_yaw_pitch_roll(angles: np.ndarray) -> None:
    found = [angles_of(*turn)[::-1] for turn in states(angles)[:, 3:7]]
    assert np.array(found) == pytest.approx(angles, abs=1e-6)
    assert planar_poses(states(angles))[:, 2] == pytest.approx(angles[:, 0], abs=1e-6)


@settings(max_examples=50, deadline=None)
@given(ANGLES, arrays(float, (5, 3), elements=st.floats(-3.0, 3.0)))
def test_the_yaw_rate_is_about_the_vertical(angles: np.ndarray, rates: np.ndarray) -> None:
    qvel = np.zeros((5, 18))
    qvel[:, :2] = (0.3, -0.2)
    qvel[:, 3:6] = rates
    expected = Rotation.from_euler("ZYX", angles).apply(rates)[:, 2]
    found = planar_velocities(states(angles), qvel)
    assert found[:, 2] == pytest.approx(expected, abs=1e-9)
    assert np.all(found[:, :2] == (0.3, -0.2))


@settings(max_examples=50, deadline=None)
@given(ANGLES, arrays(float, (5, 3), elements=st.floats(-1.0, 1.0)))
def test_turning_is_in_the_body_s_frame(angles: np.ndarray, vectors: np.ndarray) -> None:
    rotation = Rotation.from_euler("ZYX", angles)
    expected = quaternions(rotation * Rotation.from_rotvec(vectors))
    found = turned(quaternions(rotation), vectors)
    assert np.abs((found * expected).sum(axis=1)) == pytest.approx(np.ones(5), abs=1e-12)


@pytest.mark.parametrize(
    ("angles", "height", "cause"),
    [
        ((2.0, 0.9, -0.9), 0.30, 0),
        ((0.0, 1.1, 0.0), 0.30, 1),
        ((0.0, 0.0, -1.1), 0.30, 1),
        ((0.0, 0.0, np.pi), 0.30, 1),
        ((0.0, 0.0, 0.0), 0.13, 0),
        ((0.0, 0.0, 0.0), 0.11, 2),
    ],
)
def test_what_a_fall_is(angles: tuple[float, ...], height: float, cause: int) -> None:
    """A trunk that may sink to 0.12 m, on ground of 1 m."""
    qpos = states([angles], 1.0 + height)
    assert find_falls(qpos, np.array([1.0]), np.array([0.12]), 1.0).tolist() == [cause]


@settings(max_examples=50, deadline=None)
@given(arrays(float, (7, 2, 12), elements=st.floats(-30.0, 30.0)))
def test_peaks_are_the_torques_of_largest_magnitude(torques: np.ndarray) -> None:
    peaks = np.zeros((2, 12))
    for one in torques:
        keep_peaks(one, peaks)
    for robot in range(2):
        for joint in range(12):
            series = torques[:, robot, joint]
            assert abs(peaks[robot, joint]) == np.abs(series).max()
            assert peaks[robot, joint] in (*series, 0.0)


def a_state(k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    qpos = states([(0.1, 0.2, 0.3), (1.0, 0.0, 0.0)])
    qpos[:, 0] = k
    return qpos, np.full((2, 18), float(k)), np.full((2, 4), float(k))


def test_a_delay_is_a_whole_number_of_steps() -> None:
    sensing = Sensing(SensingErrors(delay=0.006), 0.002)
    seen = [sensing.measured(a_state(k))[0][0, 0] for k in range(8)]
    assert seen == [0, 0, 0, 0, 1, 2, 3, 4]


def test_noise_has_the_asked_spread_and_keeps_rotations_rotations() -> None:
    errors = SensingErrors(0.01, 0.02, 0.03, 0.04, 0.05, 0.06)
    sensing = Sensing(errors, 0.002, seed=5)
    truth = a_state(0)
    measured = [sensing.measured(truth) for _ in range(2000)]
    qpos = np.array([one[0] for one in measured])
    off = np.array([one[1] for one in measured]) - truth[1]
    assert np.linalg.norm(qpos[..., 3:7], axis=-1) == pytest.approx(np.ones((2000, 2)))
    assert (qpos - truth[0])[..., :3].std() == pytest.approx(0.01, rel=0.05)
    assert (qpos - truth[0])[..., 7:].std() == pytest.approx(0.05, rel=0.05)
    assert off[..., :3].std() == pytest.approx(0.02, rel=0.05)
    assert off[..., 3:6].std() == pytest.approx(0.04, rel=0.05)
    assert off[..., 6:].std() == pytest.approx(0.06, rel=0.05)
    true = Rotation.from_quat(truth[0][0, (4, 5, 6, 3)])
    vectors = (true.inv() * Rotation.from_quat(qpos[:, 0][:, (4, 5, 6, 3)])).as_rotvec()
    assert vectors.std(axis=0) == pytest.approx([0.03] * 3, rel=0.08)
    assert all(one[2] is truth[2] for one in measured)


@pytest.mark.parametrize("key", ["position", "rate", "delay"])
@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf])
def test_errors_are_numbers_from_zero_on(key: str, value: float) -> None:
    with pytest.raises(InputError, match=key):
        SensingErrors(**{key: value})
