"""Recordings with parts missing."""

from __future__ import annotations

import numpy as np

from cavalcade.checking.check import judge
from cavalcade.checking.tracks import Track, disordered, incomplete, misplaced


def still(time):
    time = np.asarray(time, dtype=float)
    return Track(time, np.tile([5.0, 5.0, 0.0], (len(time), 1)))


EVERY = 0.05 * np.arange(41)


def test_a_whole_recording_passes():
    assert incomplete((still(EVERY), still(EVERY)), 20.0, 2.0) == []


def test_finer_samples_pass():
    assert incomplete((still(0.01 * np.arange(201)),), 20.0, 2.0) == []


def test_a_gap_is_found():
    (violation,) = incomplete((still(np.delete(EVERY, [10, 11])),), 20.0, None)
    assert violation.kind == "samples"
    assert violation.time == EVERY[9]


def test_samples_missing_for_one_robot_only():
    found = incomplete((still(EVERY), still(EVERY[:30])), 20.0, None)
    assert [violation.robots for violation in found] == [(1,)]


def test_a_recording_cut_short_of_what_the_summary_says():
    assert len(incomplete((still(EVERY),), 20.0, 3.0)) == 1


def test_time_that_stands_still_or_runs_back():
    back = EVERY.copy()
    back[7] = back[5]
    twice = EVERY.copy()
    twice[7] = twice[6]
    assert [v.robots for v in disordered((still(back), still(EVERY), still(twice)))] == [(0,), (2,)]


def test_disorder_is_a_verdict_without_figures(make_scenario):
    track = still([0.0, 0.1, 0.1])
    report = judge(make_scenario([[5, 5, 0]]), (track,), {})
    assert not report.ok
    assert report.figures is None


def test_a_start_elsewhere():
    assert misplaced((still(EVERY),), ((5.0, 5.0, 6.2831853),)) == []
    assert len(misplaced((still(EVERY),), ((5.2, 5.0, 0.0),))) == 1
    assert len(misplaced((still(EVERY),), ((5.0, 5.0, 0.3),))) == 1
