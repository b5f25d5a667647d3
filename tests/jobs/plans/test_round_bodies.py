"""Distances of round robots are those of discs."""

from __future__ import annotations

import numpy as np
import pytest

import cavalcade as cv

DISC = cv.robot_model("single-integrator")


def gap_of(make_scenario, straight_team, **options):
    return cv.plan(make_scenario(model=DISC.name, **options), coordinator=straight_team((0.0,)))


def test_beside_a_corner_and_a_circle(make_scenario, straight_team):
    way = [((1.0, 3.0, 0.0), (7.0, 3.0, 0.0))]
    box = {"box": {"center": [4.0, 4.0], "size": [0.5, 0.5], "yaw": np.pi / 4}}
    circle = {"circle": {"center": [4.0, 2.4], "radius": 0.3}}
    for obstacle, away in ((box, 1.0 - np.sqrt(0.125)), (circle, 0.3)):
        world = {"empty": {"size": [8, 6]}, "obstacles": [obstacle]}
        summary = gap_of(make_scenario, straight_team, robots=way, world=world).summary
        assert summary["min_obstacle_distance_m"] == pytest.approx(away, abs=1e-3)
        expected = away - 0.5 * DISC.length
        assert summary["min_footprint_gap_m"] == pytest.approx(expected, abs=1e-3)


def test_beside_the_border_and_each_other(make_scenario, straight_team):
    ways = [((1.0, 0.4, 0.7), (7.0, 0.4, 0.7)), ((1.0, 0.7, 0.2), (7.0, 0.7, 0.2))]
    summary = gap_of(make_scenario, straight_team, robots=ways).summary
    assert summary["min_robot_distance_m"] == pytest.approx(0.3, abs=1e-6)
    assert summary["min_footprint_gap_m"] == pytest.approx(0.3 - DISC.length, abs=1e-6)
    near = [((1.0, 0.25, 0.7), (7.0, 0.25, 0.7))]
    summary = gap_of(make_scenario, straight_team, robots=near).summary
    assert summary["min_footprint_gap_m"] == pytest.approx(0.25 - 0.5 * DISC.length, abs=1e-6)


def test_discs_that_touch_collide(make_scenario, straight_team):
    ways = [((1.0, 3.0, 0.0), (7.0, 3.0, 0.0)), ((4.0, 3.19, 0.0), (4.2, 3.19, 0.0))]
    result = gap_of(make_scenario, straight_team, robots=ways)
    assert result.reason == "collision"
    ways[1] = ((4.0, 3.21, 0.0), (4.2, 3.21, 0.0))
    assert gap_of(make_scenario, straight_team, robots=ways).solved
