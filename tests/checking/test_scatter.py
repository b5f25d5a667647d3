"""Poses that were measured: contacts and speeds that their scatter explains are none."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking.check import judge
from cavalcade.checking.scatter import SURE, WINDOW, measured
from cavalcade.checking.tracks import Track
from tests.checking.conftest import path

WAY = [(0.0, 2.0, 5.0, 0.0), (1.0, 2.0, 5.0, 0.0), (9.0, 6.0, 5.0, 0.0), (12.0, 6.0, 5.0, 0.0)]


def scattered(track, sigma, seed=0, turn=None):
    random = np.random.default_rng(seed)
    spread = (sigma, sigma, sigma if turn is None else turn)
    return Track(track.time, track.pose + random.normal(size=track.pose.shape) * spread)


def beside(gap):
    """The way of a robot on the left, whose footprint leaves a gap in m."""
    return [(t, x, y + 0.28 + gap, yaw) for t, x, y, yaw in WAY]


@pytest.fixture
def judged(make_scenario):
    """What is found of live robots, by kind."""

    def give(*tracks, success=True, starts=None, goals=((6.0, 5.0, 0.0),)):
        starts = [track.pose[0].tolist() for track in tracks] if starts is None else starts
        task = {
            "formation": {"shape": "column", "spacing": 1.0},
            "goals": [list(goal) for goal in goals],
        }
        execution = {"backend": "ros2", "rate": 20.0}
        scenario = make_scenario(starts, task=task, execution=execution)
        end = float(tracks[0].time[-1])
        report = judge(scenario, tracks, {"success": success, "sim_time_s": end})
        return {violation.kind for violation in report.violations}

    return give


@pytest.mark.parametrize("sigma", [0.002, 0.005, 0.02, 0.05])
@pytest.mark.parametrize("rate", [10.0, 20.0, 100.0])
def test_the_scatter_is_found_and_what_is_left_is_smaller_than_said(sigma, rate):
    errors = []
    for seed in range(5):
        true = path(WAY, 1.0 / rate)
        found = measured(scattered(true, sigma, seed))
        assert found.place == pytest.approx(sigma, rel=0.25)
        assert found.turn == pytest.approx(sigma, rel=0.25)
        inner = slice(found.samples, -found.samples)
        errors.append(np.abs(found.track.pose - true.pose)[inner, 1])
        ends = np.abs(found.track.pose - true.pose)[[0, -1]]
        assert (ends < 2.0 * found.sure).all()
    # Across the way, where nothing is lost to changes of speed.
    assert (np.concatenate(errors) < found.sure).mean() > 0.999


def test_exact_poses_stay_as_they_are():
    track = path(WAY)
    assert measured(track).track is track
    assert measured(track).sure == 0.0


@pytest.mark.parametrize("samples", [1, 2, 3, 5])
def test_tracks_that_are_too_short_for_a_line_are_taken_as_they_are(samples):
    time = 0.05 * np.arange(samples)
    track = Track(time, np.random.default_rng(0).normal(size=(samples, 3)))
    assert measured(track).track is track


def test_even_motion_is_kept_whatever_the_stamps():
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(0.02, 0.08, 200))
    track = Track(time, np.column_stack((0.5 * time, -0.2 * time, 0.1 * time)))
    noisy = scattered(track, 0.02)
    smooth = measured(noisy).track.pose
    away = measured(Track(time, noisy.pose + [1.0, 2.0, 3.0])).track.pose
    assert np.allclose(away - smooth, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("seed", range(8))
def test_robots_that_pass_within_the_scatter_of_their_poses_do_not_touch(judged, seed):
    tracks = [
        scattered(path(way), 0.02, 10 * seed + k) for k, way in enumerate((WAY, beside(0.03)))
    ]
    assert judged(*tracks, success=False) == set()


@pytest.mark.parametrize("seed", range(8))
def test_robots_that_overlap_by_more_than_the_scatter_touch(judged, seed):
    tracks = [
        scattered(path(way), 0.02, 10 * seed + k) for k, way in enumerate((WAY, beside(-0.14)))
    ]
    assert judged(*tracks, success=False) == {"robot-robot"}


def test_exact_poses_of_live_robots_are_judged_to_the_millimetre(judged):
    touching = [path(way) for way in (WAY, beside(-0.001))]
    assert judged(*touching, success=False) == {"robot-robot"}
    assert judged(*[path(way) for way in (WAY, beside(0.001))], success=False) == set()


@pytest.mark.parametrize("seed", range(8))
def test_who_stands_has_arrived_although_its_poses_jump(judged, seed):
    assert judged(scattered(path(WAY), 0.02, seed)) == set()


@pytest.mark.parametrize("seed", range(8))
def test_who_still_drives_or_is_elsewhere_has_not_arrived(judged, seed):
    driving = scattered(path(WAY[:3]), 0.02, seed)
    assert judged(driving, goals=[(6.0, 5.0, 0.0)]) == {"arrival"}
    standing = scattered(path(WAY), 0.02, seed)
    assert judged(standing, goals=[(6.4, 5.0, 0.0)]) == {"arrival"}


@pytest.mark.parametrize("seed", range(8))
def test_starts_are_as_sure_as_poses(judged, seed):
    track = scattered(path(WAY), 0.02, seed)
    x, y, yaw = WAY[0][1:]
    assert judged(track, starts=[(x + 0.04, y - 0.04, yaw + 0.04)]) == set()
    assert judged(track, starts=[(x + 0.25, y, yaw)]) == {"start"}


def test_what_is_sure_shrinks_with_the_samples_of_a_line():
    found = {}
    for rate in (20.0, 100.0):
        one = measured(scattered(path(WAY, 1.0 / rate), 0.02))
        found[rate] = one.sure
        assert one.samples == 1 + round(WINDOW * rate)
        assert one.sure == pytest.approx(SURE * 0.02 / np.sqrt(one.samples), rel=0.2)
    assert found[100.0] < 0.6 * found[20.0]
