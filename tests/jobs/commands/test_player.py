"""Commands as they are played, with perfect robots and the loop around them."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.execution.command_player import REACHED, CommandPlayer
from cavalcade.execution.policy import Policy, Reconfigurable
from cavalcade.jobs.running import run
from cavalcade.scenario import build_world, parse_scenario


def scenario(commands: list[dict[str, Any]], robots: int = 1, **task: Any) -> Any:
    return parse_scenario(
        {
            "version": 1,
            "name": "walk",
            "world": {"empty": {"size": [12, 8]}, "resolution": 0.1},
            "robots": [{"start": [6.0, 2.0 + 2.0 * k, 0.5]} for k in range(robots)],
            "task": {"commands": commands, **task},
        }
    )


def played(player: CommandPlayer, times: list[float], poses: Any) -> list[list[list[float]]]:
    array = np.array(poses, dtype=float)
    return [player.step(array, t, np.full(len(array), t)).tolist() for t in times]


def test_a_velocity_holds_until_the_next() -> None:
    player = CommandPlayer(
        scenario(
            [
                {"at": 1, "velocity": [0.3, 0.1, -0.2]},
                {"at": 2, "robot": 1, "velocity": [0, 0, 1]},
                {"at": 2, "robot": 1, "velocity": [0.1, 0, 0]},
            ],
            robots=2,
        )
    )
    poses = [[6, 2, 0.5], [6, 4, 0.5]]
    still, first, last = [0.0] * 3, [0.3, 0.1, -0.2], [0.1, 0.0, 0.0]
    # The clock of the fleet may begin anywhere.
    assert played(player, [10.0, 10.95, 11.0, 11.95, 12.0, 13.9], poses) == [
        [still, still],
        [still, still],
        [first, first],
        [first, first],
        [first, last],
        [first, last],
    ]
    assert player.status.state == "commanded"
    played(player, [14.0], poses)
    assert player.status.state == "done"


def test_it_is_not_done_before_all_have_been_where_they_were_sent() -> None:
    player = CommandPlayer(scenario([{"at": 0, "to": [8, 2]}], duration=1))
    played(player, [0.0, 5.0], [[6, 2, 0]])
    assert player.status.state == "commanded"
    assert player.status.goals.tolist() == [[8.0, 2.0]]
    assert played(player, [6.0], [[8.0 - REACHED + 1e-6, 2, 0]]) == [[[0.0] * 3]]
    assert player.status.state == "done"
    # It stays so, wherever the robot is pushed.
    assert played(player, [7.0], [[7, 2, 0]]) == [[[0.0] * 3]]


@settings(max_examples=15, deadline=None)
@given(
    angle=st.floats(-math.pi, math.pi),
    distance=st.floats(0.5, 1.5),
    speed=st.floats(0.1, 0.5),
)
def test_robots_come_to_any_point(angle: float, distance: float, speed: float) -> None:
    """From any side, along a straight line, not faster than they are told to."""
    point = [6.0 + distance * math.cos(angle), 2.0 + distance * math.sin(angle)]
    result = run(scenario([{"at": 0, "to": point, "speed": speed}], duration=0.1))
    assert result.reason == "done"
    end = result.recording.poses[-1, 0, :2]
    assert math.dist(end, point) <= REACHED + 0.02
    along = np.array([math.cos(angle), math.sin(angle)])
    off = result.recording.poses[:, 0, :2] - (6.0, 2.0)
    assert np.abs(off @ (-along[1], along[0])).max() < 0.02
    assert np.hypot(*result.recording.commands[:, 0, :2].T).max() <= speed + 0.11


def test_ideal_robots_do_what_they_are_told() -> None:
    result = run(
        scenario(
            [
                {"at": 0, "velocity": [0.4, 0, 0]},
                {"at": 5, "velocity": [0, 0, 0.5]},
                {"at": 9, "velocity": [0, 0, 0]},
            ],
            robots=2,
        )
    )
    assert (result.reason, result.success) == ("done", True)
    assert result.summary["sim_time_s"] == 11.0
    assert result.summary["method"] == "commands"
    assert result.summary["commanded"] == pytest.approx(
        {"speed_error": 0.0, "yaw_rate_error": 0.0, "drift_m_s": 0.0, "rms_m_s": 0.0}, abs=1e-6
    )
    assert result.summary["makespan_s"] is None


def test_who_runs_into_a_wall_fails() -> None:
    result = run(scenario([{"at": 0, "velocity": [0.5, 0, 0]}], duration=15.0))
    assert not result.success
    assert result.summary["collisions"]["robot_obstacle"] > 0


class Leaper:
    """As much of a fleet as the player needs."""

    def __init__(self) -> None:
        self.leaping = np.zeros(1, dtype=bool)
        self.leap_failed = np.zeros(1, dtype=bool)
        self.told: list[tuple[int, Any]] = []

    def leap(self, robot: int, request: Any) -> None:
        self.told.append((robot, request))
        self.leaping[robot] = True


def leaping_player(*commands: dict[str, Any]) -> tuple[CommandPlayer, Leaper]:
    said = {
        "version": 1,
        "name": "leap",
        "world": {"generate": {"kind": "gap", "size": [6, 2.4], "width": 0.3}},
        "robots": [{"start": [1.0, 1.2, 0.0]}],
        "task": {"commands": list(commands), "duration": 2},
        "execution": {"backend": "mujoco"},
    }
    loaded = parse_scenario(said)
    leaper = Leaper()
    player = CommandPlayer(loaded, build_world(loaded).terrain, cast(Any, leaper))
    return player, leaper


LEAP = {"at": 1, "leap": [4.0, 1.2]}


@pytest.fixture
def leaping() -> tuple[CommandPlayer, Leaper]:
    return leaping_player(LEAP)


def test_a_leap_is_handed_over_once_and_waited_for(leaping: tuple[CommandPlayer, Leaper]) -> None:
    player, leaper = leaping
    played(player, [0.0, 1.0, 1.1], [[2.0, 1.2, 0.1]])
    ((robot, request),) = leaper.told
    assert robot == 0
    assert request.take_off == pytest.approx([2.0, 1.2, 0.0, 0.0])
    assert request.landed == pytest.approx([4.0, 1.2, 0.0, 0.0])
    assert request.edges == pytest.approx([0.85, 1.15], abs=0.03)
    assert player.status.state == "commanded"
    leaper.leaping[0] = False
    played(player, [5.0, 6.4], [[3.5, 1.2, 0.0]])
    assert player.status.state == "commanded"
    played(player, [6.5], [[3.5, 1.2, 0.0]])
    assert player.status.state == "done"


def test_a_failed_leap_is_the_end(leaping: tuple[CommandPlayer, Leaper]) -> None:
    player, leaper = leaping
    played(player, [0.0, 1.0], [[2.0, 1.2, 0.1]])
    leaper.leaping[0], leaper.leap_failed[0] = False, True
    played(player, [1.5], [[2.0, 1.2, 0.1]])
    status = player.status
    assert (status.state, status.involved) == ("stuck", (0,))
    assert status.message == "robot 0 could not leap"


def test_of_leaps_at_once_the_last_counts() -> None:
    player, leaper = leaping_player(LEAP, {"at": 1, "leap": [4.2, 1.2]})
    played(player, [0.0, 1.0], [[2.0, 1.2, 0.0]])
    ((_, request),) = leaper.told
    assert request.landed[0] == pytest.approx(4.2)


def test_a_robot_that_leaps_cannot_be_told_to_leap() -> None:
    player, _ = leaping_player(LEAP, {"at": 1.5, "leap": [4.2, 1.2]})
    played(player, [0.0, 1.0, 1.5], [[2.0, 1.2, 0.0]])
    assert player.status.state == "stuck"


def test_a_leap_that_fails_under_the_next_command_is_the_end_too() -> None:
    player, leaper = leaping_player(LEAP, {"at": 1.5, "velocity": [0, 0, 0]})
    played(player, [0.0, 1.0, 1.5], [[2.0, 1.2, 0.0]])
    leaper.leaping[0], leaper.leap_failed[0] = False, True
    played(player, [1.6], [[2.0, 1.2, 0.0]])
    assert player.status.state == "stuck"


def test_it_takes_no_other_task_while_it_runs() -> None:
    player = CommandPlayer(scenario([{"at": 0, "to": [8, 2]}]))
    assert isinstance(player, Policy)
    assert not isinstance(player, Reconfigurable)
