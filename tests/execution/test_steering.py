"""Runs that are paused and changed on their way, and the same runs from what they left."""

from __future__ import annotations

import threading
import time as wall

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.errors import InputError, ScenarioError
from cavalcade.execution import Steering
from cavalcade.scenario import dump_scenario, load_scenario, parse_scenario

TIMES = {"wall_time_s", "planning_time_s", "cycle_ms", "real_time_factor"}

WORDS = {
    "version": 1,
    "name": "steered",
    "world": {
        "empty": {"size": [10, 8]},
        "obstacles": [{"circle": {"center": [5.0, 5.5], "radius": 0.4}}],
    },
    "robots": [{"model": "go1", "start": [1.5, 3.0 + y, 0.0]} for y in (0.0, 1.0)],
    "task": {"formation": {"shape": "column", "spacing": 1.0}, "goals": [[8.0, 4.0, 0.0]]},
    "execution": {"timeout": 200},
}
ROCK = {"box": {"center": [5.0, 3.5], "size": [0.5, 0.5]}}
PLAY = {
    # When, s, and what happens then.
    1.0: {"add": ROCK},
    2.0: {"move": {**ROCK, "to": [5.0, 2.0], "speed": 0.5}},
    3.0: {"goals": [[3.0, 4.5, 0.0], [8.0, 4.5, 0.5]]},
    4.0: {"formation": {"shape": "line", "spacing": 1.0}},
    6.0: {"remove": {"box": {"center": [5.0, 2.0], "size": [0.5, 0.5]}}},
    6.5: {"lose": 1},
    9.0: {"rejoin": 1},
    10.0: {"move": {"circle": {"center": [5.0, 5.5], "radius": 0.4}, "to": [5.0, 7.0], "speed": 1}},
}


def played(words, play, out=None, after=None):
    """The result of a run in which things happen, and whose end is put off once for `after`."""
    steering, left = Steering(speed=None), dict(play)
    waiting = threading.Event()

    def sink(frame):
        for at in [at for at in left if frame.time >= at - 0.051]:
            steering.submit(**left.pop(at))

    def come_after():
        while steering.phase != "ended":
            if steering.phase == "waiting":
                if after and not waiting.is_set():
                    waiting.set()
                    steering.submit(**after)
                else:
                    steering.finish()
            wall.sleep(0.005)

    watcher = threading.Thread(target=come_after)
    watcher.start()
    try:
        scenario = parse_scenario(words)
        result = cv.run(scenario, out, sinks=[sink], steering=steering, figures=False, replay=False)
    finally:
        steering.finish()
        watcher.join()
    assert not left
    return result


def same(one, other):
    assert np.array_equal(one.recording.poses, other.recording.poses)
    assert np.array_equal(one.recording.commands, other.recording.commands)
    assert list(one.recording.notes) == list(other.recording.notes)
    a, b = one.summary.to_dict(), other.summary.to_dict()
    assert {k: v for k, v in a.items() if k not in TIMES} == {
        k: v for k, v in b.items() if k not in TIMES
    }


def test_what_was_played_is_run_again_from_its_file(tmp_path):
    result = played(WORDS, PLAY, tmp_path / "played", after={"goals": [[2.0, 3.0, 1.0]]})
    events = result.scenario.execution.events
    assert [event.kind for event in events][:-1] == [next(iter(event)) for event in PLAY.values()]
    assert events[-1].goals == ((2.0, 3.0, 1.0),)
    assert result.reason == "arrived"
    same(result, cv.run(tmp_path / "played" / "scenario.yaml"))
    dump_scenario(result.scenario, tmp_path / "exported.yaml")
    same(result, cv.run(load_scenario(tmp_path / "exported.yaml")))


def test_events_of_the_file_and_of_the_hand_happen_in_order(tmp_path):
    later = {"at": 7.0, "add": {"circle": {"center": [2.0, 1.0], "radius": 0.3}}}
    words = {**WORDS, "execution": {"timeout": 200, "events": [later]}}
    result = played(words, PLAY, tmp_path / "played")
    times = [event.at for event in result.scenario.execution.events]
    assert times == sorted(times)
    assert len(times) == len(PLAY) + 1
    same(result, cv.run(tmp_path / "played" / "scenario.yaml"))


BLOCK = {"circle": {"center": [5.0, 5.5], "radius": 0.4}}
WALKED = {
    # On the way, then in the way of a robot; a push; one that was there from the start moves.
    0.5: {"add": ROCK},
    1.0: {"push": {"robot": 0, "impulse": [0.0, 12.0]}},
    1.5: {"goals": [[3.2, 3.5, 0.0]]},
    2.0: {"add": {"box": {"center": [2.9, 4.6], "size": [0.2, 1.0]}}},
    2.5: {"move": {**BLOCK, "to": [5.0, 7.0], "speed": 1.0}},
    3.0: {"remove": ROCK},
    3.5: {"lose": 1},
    4.5: {"rejoin": 1},
}


def test_what_walked_is_walked_again_from_its_file(tmp_path):
    pytest.importorskip("mujoco")
    words = {**WORDS, "execution": {"timeout": 8, "backend": "mujoco"}}
    result = played(words, WALKED, tmp_path / "played")
    again = cv.run(tmp_path / "played" / "scenario.yaml")
    same(result, again)
    one, other = result.recording.physics, again.recording.physics
    for name in ("base", "joints", "torques", "foot_forces"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    assert one.contacts == other.contacts


def test_a_run_that_nobody_touches_is_like_any_other():
    result = played(WORDS, {})
    same(result, cv.run(parse_scenario(WORDS)))


@pytest.fixture
def steered():
    """A run in a thread of its own, paused at first, and its frames."""
    steering, frames, result = Steering(speed=None, paused=True), [], []
    scenario = parse_scenario(WORDS)
    thread = threading.Thread(
        target=lambda: result.append(cv.run(scenario, sinks=[frames.append], steering=steering))
    )
    thread.start()
    try:
        until(lambda: steering.phase == "paused")
        yield steering, frames, result
    finally:
        steering.finish()
        thread.join()


def until(condition):
    end = wall.monotonic() + 60.0
    while not condition():
        assert wall.monotonic() < end
        wall.sleep(0.002)


def test_it_steps_goes_on_pauses_and_ends_by_hand(steered):
    steering, frames, result = steered
    assert frames == []
    steering.step()
    until(lambda: steering.phase == "paused" and len(frames) == 1)
    steering.step(5)
    until(lambda: steering.phase == "paused" and len(frames) == 6)
    assert steering.time == pytest.approx(0.3)
    steering.resume()
    until(lambda: len(frames) > 20)
    steering.pause()
    until(lambda: steering.phase == "paused")
    count = len(frames)
    assert steering.time == pytest.approx(0.05 * count)
    steering.finish()
    until(lambda: steering.phase == "ended")
    until(lambda: result)
    assert result[0].reason == "stopped"
    assert len(frames) == count + 1
    assert not frames[-1].commands.any()
    with pytest.raises(InputError, match="over"):
        steering.submit(lose=0)


def test_at_the_end_it_waits_for_what_gives_the_team_something_to_do(steered):
    steering, frames, result = steered
    steering.resume()
    until(lambda: steering.phase == "waiting")
    assert steering.reason == "arrived"
    count = len(frames)
    steering.submit(add=ROCK)  # nothing to do for the team
    wall.sleep(0.05)
    assert steering.phase == "waiting"
    assert steering.pending == 1
    steering.submit(goals=[[7.5, 4.0, 0.0]])
    until(lambda: len(frames) > count + 5)
    until(lambda: steering.phase == "waiting")
    steering.finish()
    until(lambda: result)
    assert result[0].reason == "arrived"
    assert [event.kind for event in result[0].scenario.execution.events] == ["add", "goals"]


def test_what_is_refused_is_refused_at_once_as_in_a_file(steered):
    steering, frames, _result = steered
    for event, words in (
        ({"lose": 7}, "there is no robot 7"),
        ({"goals": []}, "at least 1"),
        ({"goals": [[float("nan"), 0.0, 0.0]]}, "number"),
        ({"formation": {"shape": "sqare"}}, "did you mean square"),
        ({"remove": ROCK}, "no such obstacle"),
        ({"rejoin": 0}, "is not lost"),
        ({"teleport": 1}, "unknown key"),
        ({"lose": 0, "rejoin": 1}, "exactly one"),
        ({}, "exactly one"),
    ):
        with pytest.raises(ScenarioError, match=words):
            steering.submit(**event)
    steering.submit(lose=0)
    with pytest.raises(ScenarioError, match="lost already"):
        steering.submit(lose=0)
    assert len(steering.scenario.execution.events) == 0
    steering.step()
    until(lambda: len(frames) == 1)
    assert [event.lose for event in steering.scenario.execution.events] == [0]


@pytest.mark.parametrize("speed", [0.0, -1.0, 0.05, 11.0, float("nan"), "fast"])
def test_paces_out_of_range_are_refused(speed):
    with pytest.raises(InputError, match="speed"):
        Steering(speed)


def test_one_steering_is_for_one_simulated_run():
    steering = Steering(speed=None)
    with pytest.raises(InputError, match="not begun"):
        steering.submit(lose=0)
    steering.finish()
    cv.run(parse_scenario(WORDS), steering=steering)
    with pytest.raises(InputError, match="one run"):
        cv.run(parse_scenario(WORDS), steering=steering)


def test_a_change_that_cannot_happen_any_more_is_told(caplog):
    circle = WORDS["world"]["obstacles"][0]
    away = {"move": {**circle, "to": [5.0, 7.0], "speed": 1.0}}
    here = {"circle": {"center": [5.0, 5.65], "radius": 0.4}}  # at 0.3 s, and at no other time
    steering, left = Steering(speed=None), {0.1: away, 0.3: {"remove": here}}

    def sink(frame):
        for at in [at for at in left if frame.time >= at - 1e-6]:
            steering.submit(**left.pop(at))
        if frame.time > 1.0:
            steering.finish()

    result = cv.run(parse_scenario(WORDS), sinks=[sink], steering=steering)
    assert [event.kind for event in result.scenario.execution.events] == ["move"]
    (told,) = steering.refused
    assert "no such obstacle" in told
    assert told in caplog.text
