"""Planted collisions of every kind, each found; and near misses, each let pass."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.checking import check

BOX = {"box": {"center": [5, 5], "size": [0.4, 0.4]}}
DISC = {"circle": {"center": [5, 5], "radius": 0.2}}
PILLAR = {"box": {"center": [5, 5], "size": [0.02, 0.02], "yaw": 0.3}}
ANGLE = {"polygon": {"points": [[4, 4], [6, 4], [6, 6], [5.8, 6], [5.8, 4.2], [4, 4.2]]}}
L, W = 0.65, 0.28


def kinds(report):
    return [violation.kind for violation in report.violations]


def contacts(report):
    return [
        v for v in report.violations if v.kind in ("robot-robot", "robot-obstacle", "robot-map")
    ]


@pytest.mark.parametrize("obstacle", [BOX, DISC, PILLAR])
def test_driving_through_an_obstacle_is_one_contact_at_the_right_time(verdict, obstacle):
    reach = {"box": 0.2, "circle": 0.2}[next(iter(obstacle))] if obstacle is not PILLAR else 0.01
    report = verdict([[(0, 3, 5, 0), (8, 7, 5, 0)]], [obstacle])
    (contact,) = contacts(report)
    assert contact.kind == "robot-obstacle"
    assert contact.robots == (0,)
    assert contact.obstacle == "world.obstacles[0]"
    assert contact.time == pytest.approx((2.0 - L / 2 - reach) / 0.5, abs=0.02)
    assert report.figures.min_footprint_gap_m == 0.0
    assert not report.ok


@pytest.mark.parametrize("obstacle", [BOX, DISC])
@pytest.mark.parametrize("gap", [0.001, 0.02])
def test_passing_close_is_no_contact_and_the_gap_is_measured(verdict, obstacle, gap):
    y = 5 + 0.2 + W / 2 + gap
    report = verdict([[(0, 3, y, 0), (8, 7, y, 0)]], [obstacle])
    assert contacts(report) == []
    assert report.figures.min_footprint_gap_m == pytest.approx(gap, abs=1e-4)


def test_contact_between_two_samples_only_is_found(verdict):
    # 20 m/s: the whole passage lies between two samples that are both far away.
    report = verdict([[(0.0, 4.0, 5, 0), (0.1, 6.0, 5, 0)]], [PILLAR], dt=0.1)
    (contact,) = contacts(report)
    assert 0.0 < contact.time < 0.1


def test_a_corner_that_sweeps_a_pillar_between_two_samples_is_found(verdict):
    # Turning on the spot by 2.6 rad: only in between does the long side point at the pillar.
    start, end = -1.3, 1.3
    turning = [(0.0, 5 - 0.3, 5, start), (0.05, 5 - 0.3, 5, end)]
    report = verdict([turning], [PILLAR])
    assert kinds(report).count("robot-obstacle") == 1
    for yaw in (start, end):
        assert not contacts(verdict([[(0, 4.7, 5, yaw), (0.05, 4.7, 5, yaw)]], [PILLAR]))


@pytest.mark.parametrize(("before", "after"), [(3.1, -3.1), (-3.1, 3.1)])
def test_the_yaw_turns_the_short_way(make_folder, scenario_words, knot_path, before, after):
    # By 0.08 rad beside the pillar; the long way round the nose would hit it.
    track = knot_path([(0, 5, 4.7, before), (0.05, 5, 4.7, after)])
    folder = make_folder([track], scenario_words([[5, 4.7, before]], [PILLAR]))
    assert contacts(check(folder)) == []


def test_a_non_convex_obstacle_has_room_in_its_bay(verdict):
    assert contacts(verdict([[(0, 5.0, 5.0, 0), (1, 5.2, 5.0, 0)]], [ANGLE])) == []
    assert len(contacts(verdict([[(0, 5.0, 5.0, 0), (2, 6.0, 5.0, 0)]], [ANGLE]))) == 1


def test_a_robot_inside_an_obstacle_from_the_start(verdict):
    big = {"box": {"center": [5, 5], "size": [4, 4]}}
    (contact,) = contacts(verdict([[(0, 5, 5, 0), (1, 5, 5, 0)]], [big]))
    assert contact.time == 0.0


def test_an_obstacle_inside_the_footprint(verdict):
    speck = {"circle": {"center": [5, 5], "radius": 0.001}}
    (contact,) = contacts(verdict([[(0, 5, 5, 0), (1, 5, 5, 0)]], [speck]))
    assert contact.time == 0.0


@pytest.mark.parametrize(
    ("x", "y", "yaw", "touches"),
    [
        (0.326, 5, 0, False),
        (0.324, 5, 0, True),
        (9.676, 5, 0, True),
        (5, 0.141, 0, False),
        (5, 0.139, 0, True),
        (5, 9.7, math.pi / 2, True),
        (-3, 5, 0, True),
    ],
)
def test_the_border_is_a_wall(verdict, x, y, yaw, touches):
    report = verdict([[(0, x, y, yaw), (0.5, x, y, yaw)]])
    found = contacts(report)
    assert bool(found) == touches
    assert all(v.kind == "robot-map" and v.obstacle == "border" for v in found)


def test_two_robots_that_meet_between_samples(verdict):
    # They change sides within one sample interval.
    one = [(0, 4, 5, 0), (0.05, 6, 5, 0)]
    two = [(0, 6, 5, 0), (0.05, 4, 5, 0)]
    (contact,) = contacts(verdict([one, two]))
    assert contact.kind == "robot-robot"
    assert contact.robots == (0, 1)
    assert contact.time == pytest.approx(0.05 * (2 - L) / 4, abs=1e-4)


def test_nose_to_tail_at_the_papers_limit_overlaps(verdict):
    # 0.60 m between centres keeps the paper's pair distance, not the bodies apart.
    report = verdict([[(0, 4, 5, 0), (1, 4, 5, 0)], [(0, 4.6, 5, 0), (1, 4.6, 5, 0)]])
    assert kinds(report) == ["robot-robot"]


def test_two_robots_abreast_keep_their_gap(verdict):
    report = verdict([[(0, 4, 5, 0), (1, 4, 5, 0)], [(0, 4, 5 + W + 0.01, 0), (1, 4, 5.29, 0)]])
    assert contacts(report) == []
    assert report.figures.min_footprint_gap_m == pytest.approx(0.01, abs=1e-4)


def test_two_visits_are_two_contacts(verdict):
    there_and_back = [(0, 3, 5, 0), (4, 5, 5, 0), (8, 3, 5, 0), (12, 5, 5, 0)]
    assert len(contacts(verdict([there_and_back], [BOX]))) == 2


def test_an_obstacle_that_appears_counts_from_then_on(verdict):
    standing = [(0, 5, 5, 0), (4, 5, 5, 0)]
    (contact,) = contacts(verdict([standing], events=[{"at": 2.03, "add": DISC}]))
    assert contact.time == pytest.approx(2.03)
    assert contact.obstacle == "event at 2.03 s"
    assert contacts(verdict([standing], events=[{"at": 9.0, "add": DISC}])) == []


def test_an_obstacle_that_was_removed_no_longer_counts(verdict):
    late = [(0, 3, 5, 0), (2, 3, 5, 0), (6, 5, 5, 0)]
    assert contacts(verdict([late], [BOX], [{"at": 1.0, "remove": BOX}])) == []
    assert len(contacts(verdict([late], [BOX], [{"at": 5.9, "remove": BOX}]))) == 1


def test_an_obstacle_that_moves_into_a_standing_robot(verdict):
    standing = [(0, 5, 5, 0), (10, 5, 5, 0)]
    ball = {"circle": {"center": [2, 5], "radius": 0.2}}
    move = {"at": 1.0, "move": {**ball, "to": [8, 5], "speed": 1.0}}
    (contact,) = contacts(verdict([standing], events=[move]))
    assert contact.time == pytest.approx(1.0 + 3 - 0.2 - L / 2, abs=0.01)


def test_a_moving_obstacle_that_is_faster_than_the_samples(verdict):
    standing = [(0, 5, 5, 0), (1, 5, 5, 0)]
    ball = {"circle": {"center": [1, 5], "radius": 0.05}}
    move = {"at": 0.50, "move": {**ball, "to": [9, 5], "speed": 100.0}}
    (contact,) = contacts(verdict([standing], events=[move], dt=0.25))
    assert contact.time == pytest.approx(0.5 + (4 - 0.05 - L / 2) / 100, abs=1e-3)


def test_a_shipped_obstacle_that_moves_leaves_its_place(verdict):
    late = [(0, 3, 5, 0), (4, 3, 5, 0), (8, 5, 5, 0)]
    move = {"at": 0.0, "move": {**BOX, "to": [5, 8], "speed": 1.0}}
    assert contacts(verdict([late], [BOX], [move])) == []


def test_far_from_everything_the_gap_is_capped(verdict):
    report = verdict([[(0, 5, 5, 0), (1, 5, 5, 0)]])
    assert report.figures.min_footprint_gap_m == 1.0
    assert report.ok


def test_the_verdict_does_not_depend_on_where_the_world_lies(verdict):
    rng = np.random.default_rng(4)
    for _ in range(10):
        x, y, yaw = rng.uniform([3, 3, -3], [7, 7, 3]).tolist()
        disc = {"circle": {"center": rng.uniform(3, 7, 2).tolist(), "radius": 0.3}}
        plain = verdict([[(0, x, y, yaw), (1, x, y, yaw)]], [disc])
        cx, cy = disc["circle"]["center"]
        mirrored = {"circle": {"center": [10 - cx, cy], "radius": 0.3}}
        turned = verdict(
            [[(0, 10 - x, y, math.pi - yaw), (1, 10 - x, y, math.pi - yaw)]], [mirrored]
        )
        assert kinds(plain) == kinds(turned)
        gap = plain.figures.min_footprint_gap_m
        assert turned.figures.min_footprint_gap_m == pytest.approx(gap, abs=1e-4)
