"""The estimate of the team's state when its next commands arrive."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.formation.estimation import Imperfections, StateEstimator
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
PERIOD = 0.05
STARTS = np.array([[0.0, 0.0, 0.3], [2.0, 1.0, -2.0]])


def wander(cycle: int) -> np.ndarray:
    """Commands of a team that turns, stops and starts."""
    phase = 0.13 * cycle + np.array([0.0, 1.0])
    pace = 0.5 * (math.sin(0.05 * cycle) > -0.3)
    return np.column_stack([pace * np.cos(phase), 0.1 * np.sin(phase), 0.8 * np.sin(0.7 * phase)])


def drive(expected: Imperfections, seed: int, cycles: int = 160) -> tuple[np.ndarray, np.ndarray]:
    """Estimates for the moments at which commands arrive, and the true poses then."""
    fleet = IdealFleet(
        (GO1, GO1),
        STARTS,
        noise=LocalisationNoise(expected.position, expected.heading),
        delay=CommandDelay(expected.delay, expected.jitter, expected.drop),
        seed=seed,
    )
    estimator = StateEstimator(GO1, PERIOD, expected)
    ahead = round(expected.delay / PERIOD)
    estimates, truth = [], []
    for cycle in range(cycles):
        seen = fleet.observe()
        estimates.append(estimator.update(seen.poses, seen.time, seen.stamps)[0])
        truth.append(fleet.true_poses())
        commands = wander(cycle)
        fleet.send(commands)
        estimator.commanded(commands)
        fleet.advance(PERIOD)
    return np.array(estimates)[: cycles - ahead], np.array(truth)[ahead:]


def errors(estimates: np.ndarray, truth: np.ndarray) -> np.ndarray:
    return np.hypot(*(estimates - truth)[..., :2].transpose(2, 0, 1))


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.2, 0.3])
def test_with_delay_alone_the_estimate_is_the_future(delay: float) -> None:
    away = errors(*drive(Imperfections(delay=delay), seed=0))
    assert away.max() < 2e-3


@pytest.mark.parametrize("delay", [0.0, 0.2])
def test_noise_is_averaged_out(delay: float) -> None:
    expected = Imperfections(position=0.02, heading=math.radians(1.0), delay=delay)
    away = errors(*drive(expected, seed=3, cycles=400))
    assert np.sqrt(np.mean(away**2)) < 0.6 * 0.02 * math.sqrt(2.0)
    assert np.mean(away < expected.error(PERIOD, 0.0)) > 0.98


def test_lost_messages_cost_little() -> None:
    away = errors(*drive(Imperfections(delay=0.2, drop=0.1), seed=1, cycles=400))
    assert np.median(away) < 0.02
    assert away.max() < 0.12


def test_a_robot_that_was_carried_away_is_found_again() -> None:
    estimator = StateEstimator(GO1, PERIOD, Imperfections(position=0.02))
    estimator.update(STARTS, 0.0)
    estimator.commanded(np.zeros((2, 3)))
    elsewhere = STARTS + [5.0, 0.0, 0.0]
    poses, velocities = estimator.update(elsewhere, PERIOD)
    assert np.allclose(poses, elsewhere)
    assert np.allclose(velocities, 0.0)


def test_a_pose_that_was_not_reported_anew_corrects_nothing() -> None:
    for stamps in (None, np.zeros(2)):
        estimator = StateEstimator(GO1, PERIOD, Imperfections(position=0.02))
        time = 0.0
        for _ in range(5):
            poses, _ = estimator.update(STARTS, time, stamps)
            estimator.commanded(np.tile([0.5, 0.0, 0.0], (2, 1)))
            time += PERIOD
        assert np.hypot(*(poses - STARTS)[0, :2]) > 0.015  # 0.2 s of speeding up at 1 m/s²


def test_a_turn_over_the_cut_is_small() -> None:
    estimator = StateEstimator(GO1, PERIOD, Imperfections(heading=0.02))
    start = np.array([[0.0, 0.0, math.pi - 1e-3]])
    estimator.update(start, 0.0)
    estimator.commanded(np.zeros((1, 3)))
    poses, velocities = estimator.update(start * [[1.0, 1.0, -1.0]], PERIOD)
    assert abs(poses[0, 2] - start[0, 2]) < 3e-3
    assert abs(velocities[0, 2]) < 0.05


def test_after_a_pause_it_starts_anew() -> None:
    estimator = StateEstimator(GO1, PERIOD, Imperfections(delay=0.2))
    estimator.update(STARTS, 0.0)
    estimator.commanded(np.tile([0.5, 0.0, 0.0], (2, 1)))
    poses, velocities = estimator.update(STARTS, 3.0)
    assert np.array_equal(poses, STARTS)
    assert not velocities.any()


@settings(max_examples=50, deadline=None)
@given(
    position=st.floats(1e-4, 1.0),
    delay=st.floats(0.0, 1.0),
    jitter=st.floats(0.0, 0.2),
    drop=st.floats(0.0, 1.0),
)
def test_what_is_expected_is_finite(
    position: float, delay: float, jitter: float, drop: float
) -> None:
    expected = Imperfections(position, 0.0, delay, jitter, drop)
    assert 0.0 < expected.error(PERIOD, 0.0) <= 3.0 * position
    assert expected.held(PERIOD) >= 1
    estimator = StateEstimator(GO1, PERIOD, expected)
    for cycle in range(3):
        poses, velocities = estimator.update(STARTS, cycle * PERIOD)
        estimator.commanded(np.full((2, 3), 0.3))
    assert np.isfinite(poses).all()
    assert np.isfinite(velocities).all()


@pytest.mark.parametrize("key", ["position", "heading", "delay", "jitter", "drop"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_nonsense_is_refused(key: str, value: float) -> None:
    with pytest.raises(InputError, match=key):
        Imperfections(**{key: value})
    with pytest.raises(InputError, match="drop"):
        Imperfections(drop=1.5)


def test_a_robot_that_does_not_budge_is_believed_in_the_end() -> None:
    """Without stamps an unchanged pose may be an old one, but not for ever."""
    estimator = StateEstimator(GO1, PERIOD, Imperfections(delay=0.1))
    for cycle in range(100):
        poses, _ = estimator.update(STARTS, cycle * PERIOD)
        estimator.commanded(np.tile([0.5, 0.0, 0.0], (2, 1)))
    assert np.hypot(*(poses - STARTS)[:, :2].T).max() < 0.1


def test_with_very_noisy_headings_nobody_was_carried_away() -> None:
    expected = Imperfections(position=0.02, heading=0.3)
    off = np.diff(drive(expected, seed=5, cycles=400)[0], axis=0)
    assert np.abs(off[100:, :, :2]).max() < 0.05  # no jump back to a raw report


def test_what_is_given_out_is_not_the_estimate_itself() -> None:
    estimator = StateEstimator(GO1, PERIOD, Imperfections(position=0.02))
    other = StateEstimator(GO1, PERIOD, Imperfections(position=0.02))
    for cycle in range(20):
        seen = STARTS + 0.01 * cycle
        poses, velocities = estimator.update(seen, cycle * PERIOD)
        expected = other.update(seen, cycle * PERIOD)
        assert np.array_equal(poses, expected[0])
        assert np.array_equal(velocities, expected[1])
        poses[:] = velocities[:] = 7.0
