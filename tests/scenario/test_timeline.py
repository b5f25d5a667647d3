"""Obstacles over time: appear, move, stop, vanish."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import ScenarioError
from cavalcade.scenario import ObstacleSpan, obstacle_spans, parse_scenario

Data = dict[str, Any]


def _circle(x: float, y: float) -> Data:
    return {"circle": {"center": [x, y], "radius": 0.3}}


def _spans(data: Data) -> tuple[ObstacleSpan, ...]:
    return obstacle_spans(parse_scenario(data))


def test_obstacles_of_the_world_are_always_there(data: Data) -> None:
    spans = _spans(data)
    assert len(spans) == 3
    for span, obstacle in zip(spans, parse_scenario(data).world.obstacles, strict=True):
        assert span.fixed
        assert span.obstacle_at(0.0) == span.obstacle_at(1e9) == obstacle


def test_add_and_remove(events: Callable[..., Data]) -> None:
    span = _spans(events({"at": 3, "add": _circle(2, 2)}, {"at": 5, "remove": _circle(2, 2)}))[3]
    assert (span.start, span.end) == (3.0, 5.0)
    assert not span.fixed
    assert span.obstacle_at(2.9) is None
    assert span.obstacle_at(3.0) == span.obstacle
    assert span.obstacle_at(5.0) is None


def test_a_move_without_such_an_obstacle_lets_it_appear(events: Callable[..., Data]) -> None:
    spans = _spans(events({"at": 2, "move": {**_circle(1, 1), "to": [4, 5], "speed": 0.5}}))
    span = spans[3]
    assert (span.start, span.end) == (2.0, math.inf)
    assert span.time == (2.0, 12.0)
    assert span.offset_at(7.0) == pytest.approx((1.5, 2.0))
    assert span.offset_at(99.0) == (3.0, 4.0)
    assert span.velocity_at(7.0) == pytest.approx((0.3, 0.4))
    assert span.velocity_at(12.0) == (0.0, 0.0)
    assert math.hypot(*span.velocity_at(2.0)) == pytest.approx(0.5)


def test_an_obstacle_that_stands_there_is_the_one_that_moves(events: Callable[..., Data]) -> None:
    box = {"box": {"center": [4, 2], "size": [1.0, 0.4], "yaw": 0.3}}
    spans = _spans(events({"at": 1, "move": {**box, "to": [4, 3], "speed": 1.0}}))
    assert len(spans) == 3
    assert spans[0].offset_at(1.5) == pytest.approx((0.0, 0.5))
    moved = spans[0].obstacle_at(9.0)
    assert moved is not None
    assert moved.center == pytest.approx((4.0, 3.0))


def test_a_polygon_moves_by_the_mean_of_its_corners(events: Callable[..., Data]) -> None:
    polygon = {"polygon": {"points": [[0, 0], [3, 0], [0, 3], [0, 0]]}}
    span = _spans(events({"at": 0, "move": {**polygon, "to": [2, 1], "speed": 1.0}}))[3]
    assert span.offset[-1] == pytest.approx((1.0, 0.0))


def test_moves_follow_each_other(events: Callable[..., Data]) -> None:
    there = {**_circle(3, 1), "to": [3, 2], "speed": 1.0}
    span = _spans(
        events(
            {"at": 0, "move": {**_circle(1, 1), "to": [3, 1], "speed": 1.0}},
            {"at": 5, "move": there},
            {"at": 9, "remove": _circle(1, 1)},
        )
    )[3]
    assert span.time == (0.0, 2.0, 5.0, 6.0)
    assert span.offset_at(4.0) == (2.0, 0.0)
    assert span.offset_at(6.0) == (2.0, 1.0)
    assert span.end == 9.0


def test_a_move_can_be_turned_on_the_way(events: Callable[..., Data]) -> None:
    span = _spans(
        events(
            {"at": 0, "move": {**_circle(1, 1), "to": [5, 1], "speed": 1.0}},
            {"at": 2, "move": {**_circle(1, 1), "to": [3, 3], "speed": 1.0}},
        )
    )[3]
    assert span.time == (0.0, 2.0, 4.0)
    assert span.offset == ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0))


def test_removing_what_is_not_there_is_bad_input(events: Callable[..., Data]) -> None:
    twice = [{"at": 1, "add": _circle(2, 2)}, {"at": 2, "remove": _circle(2, 2)}]
    twice.append({"at": 3, "remove": _circle(2, 2)})
    with pytest.raises(ScenarioError, match=r"execution.events\[2\].remove: no such obstacle at 3"):
        _spans(events(*twice))


@given(
    st.lists(
        st.tuples(st.floats(0, 30), st.floats(-5, 5), st.floats(-5, 5), st.floats(0.05, 2)),
        min_size=1,
        max_size=5,
    )
)
@settings(max_examples=60, deadline=None)
def test_a_moving_obstacle_never_jumps_nor_outruns_its_speed(
    moves: list[tuple[float, float, float, float]],
) -> None:
    found = [
        {"at": at, "move": {**_circle(0, 0), "to": [x, y], "speed": speed}}
        for at, x, y, speed in moves
    ]
    data = {
        "version": 1,
        "name": "moves",
        "world": {"empty": {"size": [3, 3]}},
        "robots": [{"start": [1, 1, 0]}],
        "task": {"formation": {"shape": "line"}, "goals": [[1, 1, 0]]},
        "execution": {"events": found},
    }
    # One obstacle, always named by its first place: a move may come while another is under way.
    spans = _spans(data)
    fastest = max(speed for *_, speed in moves)
    for span in spans:
        assert list(span.time) == sorted(span.time)
        for t in [k * 0.37 for k in range(150)]:
            step = math.dist(span.offset_at(t), span.offset_at(t + 0.1))
            assert step <= fastest * 0.1 + 1e-9
