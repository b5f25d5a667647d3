from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

import cavalcade as cv
from cavalcade.drawing.figures import make_figures
from cavalcade.drawing.physics.legs import draw_gait, draw_legs
from cavalcade.drawing.physics.signals import (
    busiest_window,
    descriptions_of,
    loaded_spans,
    peaks,
    planar_speed,
    spread,
)
from cavalcade.errors import RecordingError
from cavalcade.recording.frames import Recording
from cavalcade.recording.physics_track import ContactEvent, FallEvent


@pytest.fixture
def walked(trot):
    """Two robots: one walks 0.4 m/s from 2 s to 6 s of 8 s, one stands."""
    scenario = cv.parse_scenario(
        {
            "version": 1,
            "name": "to and fro",
            "world": {"empty": {"size": [6, 5]}},
            "robots": [
                {"model": "go1", "start": [1, 1, 0], "goal": [2.6, 1, 0]},
                {"model": "go1", "start": [1, 3, 0], "goal": [1, 3, 0]},
            ],
            "task": {"goals": "individual"},
        }
    )
    when = np.linspace(0.0, 8.0, 401)
    poses = np.zeros((401, 2, 3))
    poses[:, 0, 0] = 1.0 + np.clip(0.4 * (when - 2.0), 0.0, 1.6)
    poses[:, 1] = (1.0, 3.0, 0.0)
    poses[:, 0, 1] = 1.0
    return scenario, trot(when, poses)


def figures_of(scenario, track, folder):
    """Those of a recording of nothing but the track."""
    none = np.zeros((0, track.size, 3))
    recording = Recording(np.zeros(0), none, none, none, (), (), (), track)
    return make_figures(scenario, cv.build_world(scenario), folder, recording=recording)


def test_figures_are_drawn(walked, tmp_path):
    scenario, track = walked
    commands = np.zeros((80, 2, 3))
    commands[20:60, 0, 0] = 0.4
    robots = descriptions_of(scenario, track)
    said = (0.1 * np.arange(80), commands)
    made = [
        draw_legs("legs", track, robots, said, tmp_path / "legs.png"),
        draw_gait("gait", track, robots, tmp_path / "gait.png"),
    ]
    # Who only stands has a quarter of its weight on each foot, which is drawn in half its colour.
    amber = [(230, 159, 0), (241, 206, 113)]
    for file, standing in zip(made, amber, strict=True):
        with Image.open(file) as picture:
            assert picture.width > 1800
            seen = np.asarray(picture.convert("RGB"))
        for color in ((0, 114, 178), standing):
            assert (np.abs(seen.astype(int) - color).max(axis=2) < 14).sum() > 200
    assert sorted(tmp_path.rglob("*.tmp")) == []


def test_contacts_and_falls_add_red(walked, tmp_path):
    scenario, track = walked
    hit = dataclasses.replace(
        track, contacts=(ContactEvent(3.0, 0, "thigh", "obstacle"),), falls=(FallEvent(5.0, 1),)
    )

    def red(which, name):
        file = figures_of(scenario, which, tmp_path / name)[0]
        with Image.open(file) as picture:
            seen = np.asarray(picture.convert("RGB")).astype(int)
        return (np.abs(seen - (246, 213, 217)).max(axis=2) < 4).sum()

    files = figures_of(scenario, track, tmp_path)
    assert [file.name for file in files] == ["legs.png", "gait.png"]
    assert red(hit, "b") > red(track, "a") + 5000


def test_a_single_sample_has_no_figures(walked, tmp_path):
    scenario, track = walked
    first = {
        name: getattr(track, name)[:1]
        for name in ("time", "base", "joints", "joint_rates", "torques", "foot_forces")
    }
    short = dataclasses.replace(track, **first)
    assert figures_of(scenario, short, tmp_path) == []


def test_the_track_is_that_of_the_scenario(walked, tmp_path):
    scenario, track = walked
    one = scenario.model_copy(update={"robots": scenario.robots[:1]})
    with pytest.raises(RecordingError, match="samples of 1 robots"):
        figures_of(one, track, tmp_path)


def test_speed_is_that_over_ground(walked):
    _, track = walked
    speed = planar_speed(track)
    middle = (track.time > 2.5) & (track.time < 5.5)
    np.testing.assert_allclose(speed[middle, 0], 0.4, atol=1e-6)
    assert np.abs(speed[:, 1]).max() < 1e-9


def test_speed_of_a_moved_and_turned_run_is_the_same(walked):
    _, track = walked
    base = track.base.copy()
    c, s = np.cos(0.7), np.sin(0.7)
    base[..., 0] = c * track.base[..., 0] - s * track.base[..., 1] + 3.0
    base[..., 1] = s * track.base[..., 0] + c * track.base[..., 1] - 2.0
    np.testing.assert_allclose(
        planar_speed(dataclasses.replace(track, base=base)), planar_speed(track), atol=1e-9
    )


@pytest.mark.parametrize("count", [1, 2, 7, 400, 1000])
def test_peaks_lose_no_peak(count):
    values = np.random.default_rng(count).random((count, 3))
    times, highest = peaks(np.arange(count, dtype=float), values, columns=100)
    assert len(times) == len(highest) <= 100
    np.testing.assert_array_equal(highest.max(axis=0), values.max(axis=0))


@pytest.mark.parametrize("count", [2, 30, 2000])
def test_the_spread_holds_all_values(count):
    time = 0.02 * np.arange(count)
    values = np.random.default_rng(count).random((count, 2))
    _, (low, mean, high) = spread(time, values, columns=50)
    np.testing.assert_array_equal(low.min(axis=0), values.min(axis=0))
    np.testing.assert_array_equal(high.max(axis=0), values.max(axis=0))
    assert ((low <= mean) & (mean <= high)).all()


def test_loaded_spans_are_the_time_before_their_samples():
    time = 0.02 * np.arange(8)
    force = np.array([0.0, 0.0, 30.0, 40.0, 0.0, 0.0, 5.0, 9.0])
    assert loaded_spans(time, force) == [
        (pytest.approx(0.02), pytest.approx(0.06)),
        (pytest.approx(0.10), pytest.approx(0.14)),
    ]
    assert loaded_spans(time, np.zeros(8)) == []
    assert loaded_spans(time, np.full(8, 9.0)) == [(0.0, pytest.approx(0.14))]


def test_the_window_is_where_feet_move(walked):
    _, track = walked
    start, end = busiest_window(track, 3.0)
    assert end - start == pytest.approx(3.0)
    assert start >= 1.9
    assert end <= 6.1


def test_a_flight_is_shown_first(walked):
    _, track = walked
    forces = track.foot_forces.copy()
    forces[(track.time > 7.0) & (track.time < 7.2), 1] = 0.0
    start, end = busiest_window(dataclasses.replace(track, foot_forces=forces), 1.0)
    assert start < 7.02 < end


def test_a_short_run_is_shown_whole(walked):
    _, track = walked
    assert busiest_window(track, 60.0) == (0.0, pytest.approx(8.0))
