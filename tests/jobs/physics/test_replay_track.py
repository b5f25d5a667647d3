from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cavalcade.errors import RecordingError
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack


def track(samples=6, robots=2, **changes):
    rng = np.random.default_rng(3)
    shape = (samples, robots)
    parts = {
        "time": 0.02 * np.arange(samples),
        "base": rng.normal(size=(*shape, 7)),
        "joints": rng.normal(size=(*shape, 12)),
        "joint_rates": rng.normal(size=(*shape, 12)),
        "torques": rng.normal(size=(*shape, 12)),
        "foot_forces": rng.normal(size=(*shape, 4, 3)),
    }
    return PhysicsTrack(**{**parts, **changes})


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("base", (6, 2, 6)),
        ("base", (6, 14)),
        ("joints", (6, 2, 11)),
        ("joint_rates", (5, 2, 12)),
        ("torques", (6, 3, 12)),
        ("foot_forces", (6, 2, 12)),
        ("foot_forces", (6, 2, 4)),
    ],
)
def test_wrong_shapes_are_named(name, shape):
    with pytest.raises(RecordingError, match=name) as caught:
        track(**{name: np.zeros(shape)})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("time", [[0.0, 0.0, 1, 2, 3, 4], [0, 1, 2, 3, 4, np.nan], [[0.0] * 6]])
def test_times_increase(time):
    with pytest.raises(RecordingError, match="time"):
        track(time=np.array(time, dtype=float))


def test_what_is_not_finite_is_refused():
    joints = np.zeros((6, 2, 12))
    joints[3, 1, 7] = np.inf
    with pytest.raises(RecordingError, match="joints: expected finite"):
        track(joints=joints)


@pytest.mark.parametrize(
    "events",
    [{"contacts": (ContactEvent(0.1, 2, "thigh", "ground"),)}, {"falls": (FallEvent(0.1, -1),)}],
)
def test_events_are_of_robots_that_are_there(events):
    with pytest.raises(RecordingError, match="there is no robot"):
        track(**events)


def test_size_and_duration():
    made = track(samples=11, robots=3)
    assert made.size == 3
    assert made.duration == pytest.approx(0.2)


@pytest.mark.parametrize("samples", [1, 2, 7, 9, 10])
@pytest.mark.parametrize("stride", [1, 2, 3, 4])
def test_thinning_keeps_impulses_and_peaks(samples, stride):
    whole = track(samples=samples, robots=2)
    thin = whole.thinned(stride)
    if samples < 2:
        assert thin is whole
        return
    np.testing.assert_array_equal(thin.time, whole.time[::stride])
    np.testing.assert_array_equal(thin.base, whole.base[::stride])
    before = 0
    for k, index in enumerate(range(0, samples, stride)):
        # Each sample tells of the time since the one before.
        inside = slice(before, index + 1)
        np.testing.assert_allclose(thin.foot_forces[k], whole.foot_forces[inside].mean(axis=0))
        peak = np.abs(whole.torques[inside]).max(axis=0)
        np.testing.assert_allclose(np.abs(thin.torques[k]), peak)
        before = index + 1


def test_thinning_keeps_events():
    contact = ContactEvent(0.03, 1, "calf", "robot 0")
    assert track(contacts=(contact,)).thinned(3).contacts == (contact,)
    assert dataclasses.replace(track(), falls=(FallEvent(0.1, 0),)).thinned(2).falls
