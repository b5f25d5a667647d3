"""Go2s that are none, each behind a network card of its own as real ones are, all in domain 0."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from network_cards import Cards

import cavalcade as cv
from cavalcade.errors import FleetError
from cavalcade.fleet.unitree import Go2Fleet, Go2Link
from cavalcade.fleet.unitree.sdk import Network, load_sdk, take, write
from cavalcade.fleet.unitree.sport import Api

STOP_WITHIN = 0.6
"""From the last word of a fleet until its robots have heard a stop, s."""


@pytest.fixture
def cards() -> Iterator[Cards]:
    with Cards(2) as made:
        yield made


@pytest.fixture
def team(cards: Cards, mocks: Callable[..., Any]) -> list[Any]:
    places = zip(cards.namespaces, range(2), strict=True)
    return [
        mocks("--seed", str(k), "--drift", "0.01", namespace=name, interface=cards.theirs)[1]
        for name, k in places
    ]


def fleet_of(cards: Cards) -> Go2Fleet:
    links = [Go2Link(interface=card) for card in cards.ours]
    return Go2Fleet(links, starts=[(1.0, 1.5, 0.0), (1.0, 2.5, 0.0)])


SCENARIO = """
version: 1
name: two-go2
world: {empty: {size: [6.0, 4.0]}}
robots:
  - {model: go2, start: [1.0, 1.5, 0.0]%s}
  - {model: go2, start: [1.0, 2.5, 0.0]%s}
task: %s
execution:
  timeout: 60
  backend: unitree
  unitree: {robots: [{interface: %s}, {interface: %s}]}
"""
FORMATION = ("", "", "{formation: {shape: line, spacing: 1.0}, goals: [[3.5, 2.0, 0.0]]}")
GOALS = (", goal: [3.5, 2.5, 0.0]", ", goal: [3.5, 1.5, 0.0]", "{goals: individual}")


@pytest.mark.slow
@pytest.mark.parametrize("task", [FORMATION, GOALS], ids=["formation", "goals"])
def test_two_go2s_on_cards_of_their_own_arrive(
    cards: Cards, team: list[Any], tmp_path: Path, task: tuple[str, str, str]
) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text(SCENARIO % (*task, *cards.ours))
    result = cv.run(file, tmp_path / "out", figures=False, replay=False)
    assert result.reason == "arrived", result.summary.detail
    assert not any(result.summary.to_dict()["collisions"].values())
    for mock in team:
        assert mock.calls[-1] == Api.STOP_MOVE
        assert [api for api in mock.calls if api != Api.STOP_MOVE][:3] == [
            Api.STAND_UP,
            Api.BALANCE_STAND,
            Api.MOVE,
        ]


@pytest.mark.slow
def test_a_cable_that_is_pulled_stops_the_team_and_is_named(
    cards: Cards, team: list[Any], tmp_path: Path
) -> None:
    """The run ends; the robot that cannot be reached any more walks no longer than they all do."""
    file = tmp_path / "scenario.yaml"
    file.write_text(SCENARIO % (*FORMATION, *cards.ours))
    pulled: list[float] = []

    def pull(_: Any) -> None:
        if not pulled and min(mock.states[-1]["v"][0] for mock in team) > 0.2:
            cards.pull(1)
            pulled.append(time.time())

    result = cv.run(file, sinks=[pull])
    assert result.reason == "stopped"
    assert "link-down: robot 1" in result.summary.to_dict()["detail"]
    reached, cut = team
    assert not cut.asked(Api.MOVE, pulled[0] + 0.1)
    # Half a second without a word from robot 1, and a cycle.
    moves = [e for e in reached.requests if e["t"] > pulled[0] + STOP_WITHIN + 0.1]
    assert not any(any(e["v"]) for e in moves)
    for mock in team:
        assert np.abs(mock.states[-1]["v"]).max() < 0.01


def test_a_cable_that_is_plugged_in_again_is_no_fault_any_more(
    cards: Cards, team: list[Any], until: Callable[[Callable[[], Any]], Any]
) -> None:
    fleet = fleet_of(cards)
    try:
        fleet.start(60.0)

        def kinds() -> list[tuple[int | None, str]]:
            fleet.send(np.zeros((2, 3)))
            fleet.advance(0.05)
            return [(fault.robot, fault.kind) for fault in fleet.observe().faults]

        assert kinds() == []
        cards.pull(0)
        until(lambda: (0, "link-down") in kinds())
        assert not any(robot == 1 for robot, _ in kinds())
        cards.plug(0)
        until(lambda: not kinds())
    finally:
        fleet.close()


def test_a_robots_older_dds_survives_our_requests_and_answers_them(
    cards: Cards, mocks: Callable[..., Any], until: Callable[[Callable[[], Any]], Any]
) -> None:
    """Requests of the vendor's types as they are end it with a segmentation fault."""
    if importlib.util.find_spec("unitree_interface") is None:
        pytest.skip("the vendor's C++ library is not there (pip install far-unitree-sdk)")
    peer = Path(__file__).parent / "peers" / "go2_service.py"
    within = ["ip", "netns", "exec", cards.namespaces[0]]
    service = subprocess.Popen([*within, sys.executable, "-P", str(peer), cards.theirs])
    try:
        network, types = Network(0, cards.ours[0]), load_sdk()
        requests = network.writer("rt/api/motion_switcher/request", types.request_type)
        answers = network.reader("rt/api/motion_switcher/response", types.response_type, 10)
        numbers = count(1)

        def answered() -> bool:
            assert service.poll() is None, "the service has crashed"
            write(requests, types.request(next(numbers), 1001, "{}", no_reply=False))
            time.sleep(0.05)
            return any(answer.header.status.code == 0 for answer in take(answers, 10))

        until(answered)
    finally:
        service.kill()
        service.wait()


def test_the_card_of_a_robot_that_is_not_there_is_named(cards: Cards, team: list[Any]) -> None:
    cards.pull(1)
    fleet = fleet_of(cards)
    try:
        with pytest.raises(FleetError, match=rf"^robot 1: .*domain 0 on {cards.ours[1]}: is it on"):
            fleet.start(8.0)
    finally:
        fleet.close()
    assert not team[0].requests  # nobody stands up alone
