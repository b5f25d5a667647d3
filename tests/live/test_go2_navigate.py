"""`cavalcade ros2 navigate` with Go2s that are none: goals and orders in, requests of robots out.

Robots tell which requests they heard when. Of each fault: all are told to stop, the cause is
named, and nothing moves before somebody resumes.
"""

from __future__ import annotations

import json
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from navigation_peers import Peers
from network_cards import Cards

from cavalcade.checking import check
from cavalcade.errors import FleetError, InputError
from cavalcade.fleet.ros2 import load_rclpy, message_type, qos
from cavalcade.fleet.ros2.messages import fill_header, fill_pose
from cavalcade.fleet.unitree.sport import Api
from cavalcade.live.go2 import Go2Team
from cavalcade.live.team_file import load_team
from cavalcade.scenario import Scenario, load_scenario
from cavalcade.world import OccupancyMap, save_map

Mocks = Callable[..., tuple[int, Any]]

NAMES = ("robot_0", "robot_1")
STARTS = ((1.0, 1.5, 0.0), (1.0, 2.5, 0.0))
SLACK = 0.35
"""For a cycle, the battery's next look, a request to get there, and a machine that is busy, s."""

try:
    load_rclpy()
except InputError as error:
    pytest.skip(str(error), allow_module_level=True)


class Go2s:
    """Two Go2s, their navigation, and an operator."""

    def __init__(self, peers: Peers, mocks: list[Any], robots: list[str], more: str = "") -> None:
        self.peers, self.mocks = peers, mocks
        save_map(OccupancyMap.empty((6.0, 4.0), 0.1), peers.folder / "ground.yaml")
        self.peers.team.write_text(
            "version: 1\nname: hall\nfleet: unitree\nrobots:\n"
            + "".join(
                f"  - {{name: {n}, model: go2, {r}}}\n" for n, r in zip(NAMES, robots, strict=True)
            )
            + "formation: {shape: line, spacing: 1.0}\n"
            "map: {file: ground.yaml, topic: null}\n"
            "supervision: {deadline: 1.0}\n" + more
        )
        self.node: Any = None
        self.out = peers.folder / "run"

    def navigate(self, *words: str) -> None:
        self.node = self.peers.navigate(*words)

    def until(self, condition: Callable[[], Any]) -> None:
        self.peers.until(condition, self.node)

    def go(self, x: float) -> None:
        """Send the formation to a place, and see it walk."""
        self.peers.send_goal((x, 2.0, 0.0))
        self.until(lambda: self.peers.state() not in ("idle", "arrived"))
        self.walk()

    def walk(self) -> None:
        self.until(lambda: self.onward() and all(map(walks, self.mocks)))

    def onward(self) -> bool:
        """Whether nothing stops them; a machine that stood still for half a second has."""
        if self.peers.state() == "stopped":
            print("again:", self.peers.status["cause"])
            self.peers.call("resume")
        return bool(self.peers.status["ok"])

    def arrive(self, *places: tuple[float, float]) -> None:
        """They do, and really are there: odometry drifts little on a few metres."""
        self.until(lambda: self.onward() and self.peers.state() == "arrived")
        for mock, (x, y) in zip(self.mocks, places, strict=True):
            assert math.dist(mock.states[-1]["pose"][:2], (x, y)) < 0.2

    def stopped(self, since: float, cause: str, limit: float = 0.0) -> None:
        """For that cause, and all who can be reached were told to stop within `limit` s."""
        self.until(lambda: self.peers.state() == "stopped")
        causes = self.peers.status["cause"]
        assert any(line.startswith(cause) for line in causes), causes
        assert cause in self.peers.status["message"]
        self.until(lambda: not any(map(walks, self.mocks)))
        told = max((go[-1] for mock in self.mocks if (go := goes(mock, since))), default=since)
        print(f"{causes}: last told to walk after {told - since:.3f} s, of {limit:g} s")
        assert told - since <= limit + SLACK

    def stands(self, since: float, later: float = 0.0) -> None:
        """Nobody goes although all is well again, nor is told to, from `later` s on."""
        moment = since + later
        self.until(lambda: all(len(mock.asked(Api.MOVE, moment)) > 20 for mock in self.mocks))
        assert not any(goes(mock, moment) for mock in self.mocks)
        later_on = [e["v"] for mock in self.mocks for e in mock.states if e["t"] > since]
        assert max(abs(part) for velocity in later_on for part in velocity) < 0.02

    def resume(self) -> None:
        self.until(lambda: self.peers.call("resume").success)

    def end(self) -> None:
        self.node.send_signal(signal.SIGTERM)
        assert self.node.wait(120) == 0, self.node.output.read_text()

    def left(self) -> Scenario:
        """The scenario of the folder, which is complete and in order."""
        found = {str(file.relative_to(self.out)) for file in self.out.rglob("*") if file.is_file()}
        files = {"summary.json", "scenario.yaml", "recording.mcap", "replay.html", "map.yaml"}
        assert files | {"figures/sequence.png"} <= found
        said = json.loads((self.out / "summary.json").read_text())
        assert said["backend"] == "unitree"
        assert said["reason"] in ("arrived", "stopped")
        # A machine that stood still for half a second has left no samples meanwhile.
        assert {one.kind for one in check(self.out).violations} <= {"samples"}
        return load_scenario(self.out / "scenario.yaml")


def goes(mock: Any, since: float) -> list[float]:
    """When it was told to move."""
    return [
        e["t"] for e in mock.requests if e["t"] > since and e["api"] == Api.MOVE and any(e["v"])
    ]


def walks(mock: Any) -> bool:
    return bool(mock.states) and math.hypot(*mock.states[-1]["v"][:2]) > 0.05


def posture(mock: Any) -> str:
    return str(mock.states[-1]["is"]) if mock.states else ""


@pytest.fixture
def peers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[Peers]:
    """An operator, who comes before any card does: Fast DDS remembers cards when they are gone."""
    number = 1 + hash((os.getpid(), request.node.nodeid)) % 99
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    found = Peers(tmp_path)
    yield found
    found.close()


@pytest.fixture
def team(peers: Peers, mocks: Mocks) -> Iterator[tuple[Go2s, Cards]]:
    """Each behind a card of its own, with odometry that began somewhere else."""
    with Cards(2) as cards:
        dogs = [
            mocks("--seed", str(k), "--drift", "0.01", "--start", *map(str, start),
                  namespace=name, interface=cards.theirs)[1]
            for k, (name, start) in enumerate(zip(cards.namespaces, STARTS, strict=True))
        ]  # fmt: skip
        robots = [
            f"interface: {card}, start: {list(start)}"
            for card, start in zip(cards.ours, STARTS, strict=True)
        ]
        yield Go2s(peers, dogs, robots), cards


def test_goals_e_stops_and_faults_of_two_go2s_on_cards_of_their_own(
    team: tuple[Go2s, Cards],
) -> None:
    dogs, cards = team
    peers, (first, second) = dogs.peers, dogs.mocks
    dogs.navigate("--out", str(dogs.out))
    assert [posture(mock) for mock in dogs.mocks] == ["ready", "ready"]
    dogs.go(2.0)
    dogs.arrive((2.0, 1.5), (2.0, 2.5))
    # Goals of their own.
    peers.send_goal((2.3, 1.2, 0.0), robot="robot_0")
    peers.send_goal((1.4, 2.8, 0.0), robot="robot_1")
    dogs.until(lambda: peers.status["mode"] == "individual")
    dogs.until(lambda: peers.status["robots"]["robot_1"]["goal"] is not None)
    dogs.arrive((2.3, 1.2), (1.4, 2.8))
    # The e-stop damps them.
    dogs.go(5.0)
    pressed = time.time()
    assert peers.call("stop").success
    dogs.stopped(pressed, "e-stop")
    dogs.until(lambda: all(posture(mock) == "damping" for mock in dogs.mocks))
    assert all(mock.asked(Api.DAMP, pressed)[0] - pressed <= SLACK for mock in dogs.mocks)
    assert not peers.call("resume").success
    # Whoever presses it while they stand up damps them again.
    assert peers.call("reset_stop").success
    dogs.until(lambda: all(mock.asked(Api.STAND_UP, pressed) for mock in dogs.mocks))
    pressed = time.time()
    assert peers.call("stop").success
    dogs.until(lambda: "was damped while the team stood up" in peers.status["refused"])
    dogs.until(lambda: all(mock.asked(Api.DAMP, pressed) for mock in dogs.mocks))
    dogs.until(lambda: all(posture(mock) == "damping" for mock in dogs.mocks))
    # Also where the order to stand up is waiting while it is pressed.
    assert peers.call("reset_stop").success
    assert peers.call("stop").success
    assert peers.call("reset_stop").success
    lifted = time.time()
    dogs.until(lambda: all(posture(mock) == "ready" for mock in dogs.mocks))
    dogs.stands(lifted)
    dogs.resume()
    dogs.walk()
    # A cable.
    pulled = time.time()
    cards.pull(1)
    dogs.stopped(pulled, "link-down: robot_1", 0.5)
    assert not second.asked(Api.MOVE, pulled + SLACK)
    assert cards.ours[1] in peers.status["message"]
    assert not peers.call("resume").success
    plugged = time.time()
    cards.plug(1)
    # What the system could not send meanwhile comes now, at once and with the zeros behind it.
    dogs.stands(plugged, SLACK)
    dogs.resume()
    dogs.walk()
    # A request that is refused: one of 25 is answered, twice a second.
    refused = time.time()
    first.command("refuse 1008 3205")
    dogs.stopped(refused, "api-error: robot_0 (Move: code 3205", 0.5)
    assert not peers.call("resume").success
    first.command("refuse 1008 0")
    dogs.stands(time.time())
    dogs.resume()
    dogs.walk()
    # A battery, which is looked at twice a second.
    low = time.time()
    second.command("battery 12")
    dogs.stopped(low, "battery-low: robot_1 (12 %, 20 % are asked for)", 0.6)
    assert not peers.call("resume").success
    assert peers.call("stop").success
    dogs.until(lambda: all(posture(mock) == "damping" for mock in dogs.mocks))
    assert peers.call("reset_stop").success
    dogs.until(lambda: "must not stand up: battery-low: robot_1 (" in peers.status["refused"])
    assert all(posture(mock) == "damping" for mock in dogs.mocks)
    second.command("battery 80")
    dogs.until(
        lambda: (
            peers.call("reset_stop").success
            and all(posture(mock) == "ready" for mock in dogs.mocks)
        )
    )
    dogs.resume()
    dogs.walk()
    dogs.end()
    assert all(mock.calls[-1] == Api.STOP_MOVE for mock in dogs.mocks)
    said = dogs.left().execution.unitree
    assert [robot.interface for robot in said.robots] == cards.ours
    assert not said.lie_down


class Camera(threading.Thread):
    """Says where robots really are, as motion capture does, and misbehaves."""

    def __init__(self, peers: Peers, mocks: list[Any]) -> None:
        super().__init__(name="camera")
        self._graph = peers.graph
        self._logs = [mock.log.open() for mock in mocks]
        kind = "geometry_msgs/msg/PoseStamped"
        self._publishers = [
            peers.graph.publisher(kind, f"/{name}/pose", qos.sensor_data()) for name in NAMES
        ]
        self._end = threading.Event()
        self.frame, self.ahead, self.silent = "map", 0.0, False

    def run(self) -> None:
        poses, begun = [list(start) for start in STARTS], [""] * len(STARTS)
        while not self._end.wait(0.03):
            for k, log in enumerate(self._logs):
                *lines, begun[k] = (begun[k] + log.read()).split("\n")
                for entry in map(json.loads, lines):
                    poses[k] = entry.get("pose", poses[k])
                message = message_type("geometry_msgs/msg/PoseStamped")()
                ahead, frame = (self.ahead, self.frame) if k == 0 else (0.0, "map")
                fill_header(message.header, self._graph.time + ahead, frame)
                fill_pose(message.pose, poses[k])
                if k or not self.silent:
                    self._publishers[k].publish(message)

    def close(self) -> None:
        self._end.set()
        self.join()
        for log in self._logs:
            log.close()


@pytest.fixture
def seen(peers: Peers, mocks: Mocks) -> Iterator[tuple[Go2s, Camera]]:
    """Robots in domains of their own whose odometry is of no use, and a camera."""
    made = [mocks("--drift", "0.3", "--start", *map(str, start)) for start in STARTS]
    robots = [f"domain: {number}, interface: lo, battery_min: 5" for number, _ in made]
    found = Go2s(peers, [mock for _, mock in made], robots, "lie_down: true\n")
    camera = Camera(peers, found.mocks)
    yield found, camera
    if camera.ident is not None:
        camera.close()


def test_go2s_located_by_others_and_a_dry_run(seen: tuple[Go2s, Camera]) -> None:
    dogs, camera = seen
    peers = dogs.peers
    blind = Go2Team(load_team(peers.team))
    with pytest.raises(FleetError, match=r"robot_1: nothing was heard on /robot_1/pose \(PoseSt"):
        blind.connect(1.0)
    blind.close()
    camera.start()
    # The first day: everything but the commands, and so nobody stands up.
    dogs.navigate("--dry-run")
    peers.send_goal((3.0, 2.0, 0.0))
    dogs.until(lambda: min(peers.plans.values(), default=0) > 1)
    assert peers.call("stop").success
    assert peers.call("reset_stop").success
    dogs.resume()
    dogs.end()
    assert not any(mock.requests for mock in dogs.mocks)
    dogs.navigate("--out", str(dogs.out))
    dogs.go(3.0)
    for fault, cause, limit in (
        ({"frame": "odom"}, "frame: robot_0 (poses on /robot_0/pose are in 'odom'", 0.0),
        ({"ahead": 300.0}, "stamp: robot_0 (stamped", 0.0),
        ({"silent": True}, "stale: robot_0", 0.5),
    ):
        since = time.time()
        vars(camera).update(fault)
        dogs.stopped(since, cause, limit)
        assert not peers.call("resume").success
        vars(camera).update(frame="map", ahead=0.0, silent=False)
        dogs.stands(time.time())
        dogs.resume()
        dogs.walk()
    dogs.arrive((3.0, 1.5), (3.0, 2.5))
    dogs.end()
    assert all(posture(mock) == "lying" for mock in dogs.mocks)
    said = dogs.left().execution.unitree
    assert [robot.interface for robot in said.robots] == ["lo", "lo"]
    assert len({robot.domain for robot in said.robots}) == 2
    assert [robot.battery_min for robot in said.robots] == [5.0, 5.0]
    assert said.lie_down
