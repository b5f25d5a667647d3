"""Plans as they were driven in physics: heights, flights and footholds are the measured ones."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK
from cavalcade.jobs.driven import measured_footholds, measured_trajectory
from cavalcade.recording.physics_track import FallEvent, PhysicsTrack
from cavalcade.robots import robot_model

from .link_frames import rotations

GO1 = robot_model("go1").description
STAND = GO1.stand_height


def a_leap(flight: tuple[float, float] = (2.0, 2.4), every: float = 0.02) -> PhysicsTrack:
    """Stands, crouches, pushes for 0.2 s, flies 0.8 m ahead, lands for 0.2 s, stands."""
    time = np.round(np.arange(0.0, 4.0, every), 9)
    off, on = flight
    x = np.interp(time, [off - 0.2, off, on, on + 0.2], [0.0, 0.1, 0.7, 0.8])
    z = np.interp(
        time,
        [1.0, 1.5, off - 0.2, off, (off + on) / 2, on, on + 0.2],
        [STAND, 0.2, 0.2, 0.3, 0.45, 0.3, STAND],
    )
    base = np.zeros((len(time), 1, 7))
    base[:, 0, 0], base[:, 0, 2], base[:, 0, 3] = x, z, 1.0
    forces = np.zeros((len(time), 1, 4, 3))
    forces[..., 2] = 30.0
    # A sample tells of the time since the one before.
    forces[(time > off + 1e-6) & (time < on + 1e-6)] = 0.0
    joints = np.tile(GO1.standing, (len(time), 1, 1))
    nothing = np.zeros_like(joints)
    return PhysicsTrack(time, base, joints, nothing, nothing, forces)


@pytest.mark.parametrize("flight", [(2.0, 2.04), (2.0, 2.4), (2.5, 3.0)])
def test_a_leap_was_shown_as_walking(flight):
    off, on = flight
    path = measured_trajectory(a_leap(flight), 0, 4.0)
    spans = {}
    for phase in (TAKE_OFF, FLIGHT, LANDING):
        rows = np.flatnonzero(path.phase == phase)
        assert (np.diff(rows) == 1).all()
        spans[phase] = (path.time[rows[0]], path.time[rows[-1] + 1])
    assert spans[TAKE_OFF] == pytest.approx((off - 0.2, off))
    assert spans[FLIGHT] == pytest.approx((off, on))
    assert spans[LANDING] == pytest.approx((on, on + 0.2))
    assert path.position[:, 2].max() == pytest.approx(0.45, abs=0.01)
    assert (path.phase[path.time < off - 0.21] == WALK).all()


def test_a_foot_that_stumbles_is_no_flight():
    track = a_leap()
    forces = track.foot_forces.copy()
    forces[:, 0, 0, 2] = 30.0
    assert not dataclasses.replace(track, foot_forces=forces).flying.any()
    forces = np.full_like(forces, 30.0)
    forces[50] = 0.0
    assert not dataclasses.replace(track, foot_forces=forces).flying.any()
    forces[51] = 0.0
    track = dataclasses.replace(track, foot_forces=forces)
    assert np.flatnonzero(track.flying).tolist() == [50, 51]
    assert not dataclasses.replace(track, falls=(FallEvent(0.5, 0),)).flying.any()


@pytest.mark.parametrize("end", [0.0, 1.0, 9.0])
def test_a_trajectory_ends_with_its_plan(end):
    path = measured_trajectory(a_leap(), 0, end)
    assert path.duration == pytest.approx(min(end, 3.98))
    assert len(path.phase) == len(path.velocity) == len(path.time)


def test_feet_that_stood_left_footholds():
    track = a_leap()
    base = track.base.copy()
    base[..., 3], base[..., 6] = np.cos(0.4), np.sin(0.4)
    track = dataclasses.replace(track, base=base)
    feet = measured_footholds(track, 0, GO1)
    assert (np.diff(feet[:, 0]) >= 0.0).all()
    assert sorted(feet[:, 2]) == [0, 0, 1, 1, 2, 2, 3, 3]
    for leg in range(4):
        before, after = feet[feet[:, 2] == leg]
        assert before[:2] == pytest.approx((0.0, 2.0))
        assert after[:2] == pytest.approx((2.4, 3.98))
        for foot, when in ((before, 1.0), (after, 3.2)):
            k = int(np.argmin(np.abs(track.time - when)))
            place = GO1.foot_places(track.joints[k, 0])[leg]
            wanted = base[k, 0, :3] + rotations(base[k, 0, 3:]) @ place
            assert foot[3:] == pytest.approx(wanted - (0.0, 0.0, GO1.foot_radius), abs=0.03)
