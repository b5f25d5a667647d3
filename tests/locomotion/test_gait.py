from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.geometry.trajectory import FLIGHT, WALK, Trajectory
from cavalcade.locomotion import FRONT_LEFT, FRONT_RIGHT, REAR_LEFT, REAR_RIGHT, stances
from cavalcade.robots.catalogue import GO1, SPIRIT


def standing(found: np.ndarray, time: float) -> set[int]:
    """Legs whose feet stand in the open interval around that time."""
    return {int(leg) for down, up, leg in found if down < time < up}


def moments(found: np.ndarray, end: float) -> np.ndarray:
    """Times between all changes."""
    edges = np.unique(np.concatenate([found[:, 0], found[:, 1], [0.0, end]]))
    return 0.5 * (edges[:-1] + edges[1:])[np.diff(edges) > 1e-9]


@pytest.mark.parametrize("legs", [SPIRIT, GO1], ids=["spirit", "go1"])
def test_a_walk_is_a_trot_of_the_robots_period(walk, legs):
    found = stances(walk(length=6.0), legs)
    for leg in range(4):
        mine = found[found[:, 2] == leg][1:-1]
        np.testing.assert_allclose(mine[:, 1] - mine[:, 0], 0.5 * legs.gait_period, atol=1e-9)
        np.testing.assert_allclose(np.diff(mine[:, 0]), legs.gait_period, atol=1e-9)


def test_diagonal_pairs_step_together(walk):
    found = stances(walk(length=6.0), SPIRIT)
    for one, other in ((FRONT_LEFT, REAR_RIGHT), (FRONT_RIGHT, REAR_LEFT)):
        np.testing.assert_array_equal(
            found[found[:, 2] == one][:, :2], found[found[:, 2] == other][:, :2]
        )
    for time in moments(found, 8.0):
        assert standing(found, time) in ({0, 3}, {1, 2}, {0, 1, 2, 3})


def test_all_feet_stand_while_the_body_rests(walk):
    found = stances(walk(wait=2.0, rest=1.5), SPIRIT)
    end = 2.0 + 4.0 + 1.5
    for time in moments(found, end):
        if time < 2.0 or time > 6.0:
            assert standing(found, time) == {0, 1, 2, 3}
    assert len(standing(found, 4.01)) == 2


def test_a_body_that_never_moves_stands_on_four_feet(walk):
    path = Trajectory(
        np.zeros(1),
        np.array([[1.0, 1.0, 0.3]]),
        np.zeros((1, 3)),
        np.zeros(1),
        np.zeros(1, np.int8),
    )
    assert stances(path, SPIRIT).tolist() == [[0.0, 0.0, float(leg)] for leg in range(4)]


def test_turning_on_the_spot_takes_steps():
    time = np.arange(0.0, 1.6, 0.03)
    still = np.zeros((len(time), 3))
    path = Trajectory(time, still + 0.3, still, 1.2 * time, np.zeros(len(time), np.int8))
    assert len(stances(path, SPIRIT)) > 12


def test_a_rest_shorter_than_a_period_is_no_rest(walk):
    first, second = walk(length=1.5), walk(length=1.5)
    pause = 0.5 * SPIRIT.gait_period
    path = Trajectory(
        np.concatenate([first.time, first.time[-1] + pause + second.time]),
        np.concatenate([first.position, second.position + (1.5, 0.0, 0.0)]),
        np.concatenate([first.velocity, second.velocity]),
        np.concatenate([first.yaw, second.yaw]),
        np.concatenate([first.phase, second.phase]),
    )
    found = stances(path, SPIRIT)
    for time in moments(found, path.duration):
        if 0.3 < time < path.duration - 0.3:
            assert len(standing(found, time)) == 2


def test_no_foot_stands_in_flight_and_all_before_and_after(leap):
    path = leap()
    found = stances(path, SPIRIT)
    for time in moments(found, path.duration):
        phase = path.phase[int(np.searchsorted(path.time, time)) - 1]
        if phase == FLIGHT:
            assert standing(found, time) == set()
        elif phase != WALK:
            assert standing(found, time) == {0, 1, 2, 3}
        else:
            assert len(standing(found, time)) >= 2


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    before=st.floats(0.02, 3.0),
    after=st.floats(0.02, 3.0),
    speed=st.floats(0.2, 1.8),
)
def test_feet_take_turns_however_long_the_walks_are(leap, before, after, speed):
    path = leap(before, after, speed)
    found = stances(path, GO1)
    assert (found[:, 0] >= 0.0).all()
    assert found[:, 1].max() == pytest.approx(path.duration)
    assert (found[:, 1] >= found[:, 0]).all()
    assert (np.lexsort((found[:, 2], found[:, 0])) == np.arange(len(found))).all()
    for leg in range(4):
        mine = found[found[:, 2] == leg]
        assert (mine[1:, 0] > mine[:-1, 1]).all()
        assert mine[-1, 1] == pytest.approx(path.duration)
    for time in moments(found, path.duration):
        phase = path.phase[int(np.searchsorted(path.time, time)) - 1]
        assert (len(standing(found, time)) == 0) == (phase == FLIGHT)
