"""Recordings of live robots in which poses are missing, or leap where nobody could have gone."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking.breaks import FARTHER, FASTER, LIVE_GAP, between, find_breaks
from cavalcade.checking.check import check, judge
from cavalcade.checking.tracks import Track
from cavalcade.robots import robot_model
from tests.checking.conftest import path

GO1 = robot_model("go1")
FASTEST = max(GO1.max_speed_x, GO1.max_speed_y)
WALL = {"box": {"center": [5.0, 5.0], "size": [0.4, 4.0]}}
CONTACTS = ("robot-robot", "robot-obstacle", "robot-map")
LIVE = {"backend": "ros2", "rate": 20.0}


def standing(x, y, begin, end):
    return path([(begin, x, y, 0.0), (end, x, y, 0.0)])


def after(*parts):
    """One track of parts that leap from one to the next."""
    time = np.concatenate([part.time for part in parts])
    return Track(time, np.concatenate([part.pose for part in parts]))


def leaping(gap, y=5.0, noise=0.0):
    """From one side of the wall to the other in `gap` s."""
    track = after(standing(2.0, y, 0.0, 2.0), standing(8.0, y, 2.0 + gap, 4.0 + gap))
    random = np.random.default_rng(0)
    return Track(track.time, track.pose + random.normal(size=track.pose.shape) * noise)


@pytest.fixture
def judged(make_scenario):
    """The report on tracks of a live team beside a wall."""

    def give(*tracks, execution=LIVE, obstacles=(WALL,)):
        starts = [track.pose[0].tolist() for track in tracks]
        scenario = make_scenario(starts, obstacles, execution=execution)
        return judge(scenario, tracks, {"success": False})

    return give


def kinds(report):
    return [violation.kind for violation in report.violations]


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize(
    ("gap", "text"),
    [(0.05, "the team was elsewhere 0.05 s later"), (4.6, "the team was not seen for 4.60 s")],
)
def test_a_leap_was_swept_through_obstacles(judged, gap, text, noise):
    """Once for the whole team, and nothing else is found in it."""
    report = judged(leaping(gap, noise=noise), leaping(gap, 7.0, noise))
    (only,) = report.violations
    assert (only.kind, only.robots) == ("samples", (0, 1))
    assert text in only.message
    assert only.time == pytest.approx(2.0)
    assert report.figures.min_footprint_gap_m > 0.9
    assert report.figures.duration_s == pytest.approx(4.0 + gap)
    assert report.figures.max_speed_ratio < 5.0


def test_who_leaps_alone_is_named(judged):
    time = leaping(0.05).time
    stays = Track(time, np.tile([2.0, 7.0, 0.0], (len(time), 1)))
    (only,) = judged(leaping(0.05), stays).violations
    assert only.robots == (0,)
    assert only.message.startswith("robot 0 was elsewhere")
    two = judged(leaping(0.05), stays, leaping(0.05, 8.5)).violations
    assert [one.message.split(" were")[0] for one in two] == ["robots 0 and 2"]


@pytest.mark.parametrize("side", [2, 8])
@pytest.mark.parametrize("gap", [0.05, 4.6])
def test_contact_on_either_side_of_a_break_is_found(judged, side, gap):
    wall = {"box": {"center": [side, 5.0], "size": [0.1, 0.1]}}
    report = judged(leaping(gap), obstacles=[wall])
    assert kinds(report).count("robot-obstacle") == 1
    assert report.figures.min_footprint_gap_m == 0.0


def test_contact_in_the_one_sample_after_a_break_is_found(judged):
    last = Track(np.array([2.05]), np.array([[5.0, 5.0, 0.0]]))
    track = after(standing(2.0, 5.0, 0.0, 2.0), last)
    assert kinds(judged(track)) == ["samples", "robot-obstacle"]


def test_robots_that_change_places_in_a_break_do_not_touch(judged):
    there = after(standing(2.0, 2.0, 0.0, 2.0), standing(8.0, 2.0, 4.0, 6.0))
    back = after(standing(8.0, 2.0, 0.0, 2.0), standing(2.0, 2.0, 4.0, 6.0))
    assert kinds(judged(there, back)) == ["samples"]


def test_motion_between_samples_that_are_late_is_swept(judged):
    """Fast but possible motion through a thin wall is contact."""
    thin = {"box": {"center": [2.45, 5.0], "size": [0.02, 4.0]}}
    way = after(standing(2.0, 5.0, 0.0, 2.0), standing(2.9, 5.0, 2.45, 4.0))
    assert kinds(judged(way, obstacles=[thin])) == ["robot-obstacle"]


@pytest.mark.parametrize("gap", [0.05, 4.6])
def test_simulated_motion_is_swept_as_ever(judged, gap):
    found = kinds(judged(leaping(gap), execution={"backend": "ideal", "rate": 20.0}))
    assert "robot-obstacle" in found
    assert "speed" in found


@pytest.mark.parametrize(
    ("lasted", "far", "turn", "count"),
    [
        (0.05, FASTER * FASTEST * 0.05 + FARTHER[0] - 1e-3, 0.0, 0),
        (0.05, FASTER * FASTEST * 0.05 + FARTHER[0] + 1e-3, 0.0, 1),
        (0.05, 0.0, FASTER * GO1.max_yaw_rate * 0.05 + FARTHER[1] - 1e-3, 0),
        (0.05, 0.0, FASTER * GO1.max_yaw_rate * 0.05 + FARTHER[1] + 1e-3, 1),
        (LIVE_GAP, 0.0, 0.0, 0),
        (LIVE_GAP + 0.01, 0.0, 0.0, 1),
        (LIVE_GAP + 0.01, 9.0, 0.0, 1),
    ],
)
def test_what_cannot_have_been_motion(lasted, far, turn, count):
    track = Track(np.array([1.0, 1.0 + lasted]), np.array([[0, 0, 0], [far, 0, turn]], dtype=float))
    breaks = find_breaks([track], [GO1], 20.0)
    assert len(breaks) == count
    assert len(between([track], breaks)) == 1 + count


def test_breaks_that_overlap_leave_no_sample_out_that_all_have():
    one = Track(np.array([0.0, 1.0, 5.0, 5.1]), np.zeros((4, 3)))
    two = Track(np.array([0.0, 1.0, 1.1, 5.0, 5.1]), np.zeros((5, 3)))
    stretches = between([one, two], find_breaks([one, two], [GO1, GO1], 20.0))
    assert [len(part[0].time) for part in stretches if all(len(p.time) for p in part)] == [1, 1, 2]


def test_a_live_folder_without_a_summary_claimed_something(make_folder, scenario_words):
    """Whoever presses Ctrl-C again leaves a whole recording: it claims nothing."""
    track = standing(2.0, 5.0, 0.0, 2.0)
    words = scenario_words([[2.0, 5.0, 0.0]], execution=LIVE)
    folder = make_folder([track], words)
    (folder / "summary.json").unlink()
    assert check(folder).ok
    (folder / "summary.json").write_text("{")
    with pytest.raises(Exception, match="expected JSON"):
        check(folder)


def test_a_simulated_folder_needs_its_summary(make_folder, scenario_words):
    folder = make_folder([standing(2.0, 5.0, 0.0, 2.0)], scenario_words([[2.0, 5.0, 0.0]]))
    (folder / "summary.json").unlink()
    with pytest.raises(Exception, match="cannot be read"):
        check(folder)
