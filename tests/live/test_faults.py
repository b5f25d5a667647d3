"""What goes wrong around `cavalcade ros2 navigate`, on purpose, with robots of other processes.

Robots tell which commands they heard when. Of each fault: all are told to stop within a cycle of
the limit, the cause is named, and nothing moves before somebody resumes.
"""

from __future__ import annotations

import signal
import time

import pytest
from navigation_peers import Peers
from network_cards import Cards

from cavalcade.errors import InputError
from cavalcade.fleet.ros2 import load_rclpy, message_type
from cavalcade.fleet.ros2.messages import fill_header, fill_map
from cavalcade.world import OccupancyMap

NAMES, STARTS = ("robot_0", "robot_1"), (("1.5", "2.5"), ("1.5", "3.5"))
GOALS = (6.5, 3.0, 0.0), (2.5, 3.0, 0.0)
PERIOD, MAX_AGE = 0.05, 0.5
"""A cycle and the oldest pose, s."""
LOOK = 0.25
"""How often rivals are looked for, s."""
SLACK = 0.25
"""For the next pose to come, a command to get there, and a machine that is busy, s."""
RIVAL = 0.123
"""The speed that only the rival commands, m/s."""

try:
    load_rclpy()
except InputError as error:
    pytest.skip(str(error), allow_module_level=True)


class Team:
    """Two robots that go to and fro, their navigation, and what they heard."""

    def __init__(self, start, folder, *words, namespace="", more="") -> None:
        self.robots = [
            start("robot.py", name, "map", *place, *words, namespace=namespace)
            for name, place in zip(NAMES, STARTS, strict=True)
        ]
        self._start, self._words, self._next = start, words, 0
        self.peers = Peers(folder)
        if more:
            text = self.peers.team.read_text()
            self.peers.team.write_text(text.replace("supervision: {", f"supervision: {{{more}, "))
        try:
            self.node = self.peers.run("ros2", "navigate", str(self.peers.team))
            self.send_map(0.1)
            self.until(lambda: self.peers.status.get("lifecycle") == "active")
        except BaseException:
            self.peers.close()
            raise

    def until(self, condition) -> None:
        self.peers.until(condition, self.node)

    def send_map(self, resolution, size=(9.0, 6.0)) -> None:
        grid = message_type("nav_msgs/msg/OccupancyGrid")()
        fill_map(grid, OccupancyMap.empty(size, resolution))
        fill_header(grid.header, self.peers.graph.time, "map")
        self.peers.send_map(grid)

    def go(self) -> None:
        """Have all move, to the other goal where they have arrived."""

        def moving() -> bool:
            if self.peers.state() in ("idle", "arrived"):
                goal, self._next = GOALS[self._next], 1 - self._next
                self.peers.send_goal(goal)
                self.until(lambda: self.peers.state() not in ("idle", "arrived"))
            going = all(robot and any(robot[-1][1]) for robot in self.heard())
            return going and self.peers.status["ok"]

        self.until(moving)

    def heard(self, since=0.0):
        """Commands (time, vx vy yaw rate) of each robot, without those of the rival."""
        return [
            [
                (entry["time"], entry["command"])
                for entry in robot.heard
                if "command" in entry and entry["time"] > since and entry["command"][0] != RIVAL
            ]
            for robot in self.robots
        ]

    def stopped(self, since, cause, limit) -> None:
        """All were told to stop within `limit` s and a cycle, for that cause."""
        self.until(lambda: self.peers.state() == "stopped")
        causes = self.peers.status["cause"]
        named = [line for line in causes if line.startswith(cause)]
        assert named, (cause, causes)
        assert named[0] in self.peers.status["message"]
        self.until(lambda: all(kept and not any(kept[-1][1]) for kept in self.heard(since)))
        took = self.zeros(since) - since
        print(f"{self.peers.status['cause']}: zeros after {took:.3f} s, of {limit:g} s")
        assert took <= limit + PERIOD + SLACK

    def zeros(self, since) -> float:
        """When the last of them was told to stop, after which it was not told to go."""
        found = []
        for kept in self.heard(since):
            last = max((k for k, (_, command) in enumerate(kept) if any(command)), default=-1)
            found.append(kept[last + 1][0])
        return max(found)

    def stands(self, repaired) -> None:
        """Nobody is told to go although all is well again."""
        self.until(lambda: min(map(len, self.heard(repaired))) > 10)
        assert not any(any(command) for kept in self.heard(repaired) for _, command in kept)

    def resume(self) -> None:
        self.until(lambda: self.peers.call("resume").success)
        self.go()


@pytest.fixture
def team(graph, tmp_path):
    made = []

    def make(*words, **options):
        made.append(Team(graph, tmp_path, *words, **options))
        return made[-1]

    yield make
    for one in made:
        one.peers.close()


FAULTS = (
    # What robot 0 does, the cause, after how long it has to be noticed in s
    ({"silent": True}, "stale: robot_0", MAX_AGE),
    ({"delay": 0.8}, "stale: robot_0", MAX_AGE),
    ({"nan": True}, "nan: robot_0", 0.0),
    ({"heading": False}, "nan: robot_0", 0.0),
    ({"frame": "odom"}, "frame: robot_0", 0.0),
    ({"stamp": False}, "stamp: robot_0", 0.0),
    ({"ahead": 5.0}, "stamp: robot_0", 0.0),
    ({"ahead": 0.3}, "stamp: robot_0", 0.0),
    ({"ahead": -5.0}, "stale: robot_0", MAX_AGE),  # as if they had been overtaken
    ({"aside": 1.5}, "jump: robot_0", 0.0),
    ({"aside": -50.0}, "out-of-map: robot_0", 0.0),
)
SOUND = {
    "silent": False, "delay": 0.0, "nan": False, "heading": True, "frame": "map", "stamp": True,
    "ahead": 0.0, "aside": 0.0,
}  # fmt: skip


def test_faults_of_poses_stop_all_until_somebody_resumes(team):
    team = team()
    robot = team.robots[0]
    for fault, cause, limit in FAULTS:
        team.go()
        team.stopped(robot.tell(**fault), cause, limit)
        if fault != {"aside": 1.5}:  # which is over at once: who resumes says that it is there
            assert not team.peers.call("resume").success
        repaired = robot.tell(**{key: SOUND[key] for key in fault})
        team.stands(repaired)
        team.resume()


def test_a_robot_that_is_frozen_or_killed_or_driven_by_others_stops_all(team, graph):
    team = team()
    frozen = team.robots[0].process
    team.go()
    since = time.time()
    frozen.send_signal(signal.SIGSTOP)
    # Commands wait for it, and it hears them late: the other one tells when zeros came.
    all_robots, team.robots = team.robots, team.robots[1:]
    team.stopped(since, "stale: robot_0", MAX_AGE)
    assert not team.peers.call("resume").success
    frozen.send_signal(signal.SIGCONT)
    team.robots = all_robots
    team.stands(time.time() + 0.2)
    team.resume()

    rival = graph("driver.py", "1000.0", str(RIVAL))
    team.until(lambda: any(e.get("command", [0])[0] == RIVAL for e in team.robots[0].heard))
    met = next(e["time"] for e in team.robots[0].heard if e.get("command", [0])[0] == RIVAL)
    team.stopped(met, "second-commander: robot_0 (", LOOK)
    # Publishers are known a moment before the names of their nodes.
    team.until(lambda: "/driver publishes on" in str(team.peers.status["robots"]["robot_0"]))
    assert not team.peers.call("resume").success
    rival.process.terminate()
    rival.process.wait()
    team.stands(time.time())
    team.resume()

    since = time.time()
    team.robots[0].end()
    team.robots = team.robots[1:]
    team.stopped(since, "stale: robot_0", MAX_AGE)
    assert not team.peers.call("resume").success
    x, y, _ = team.peers.status["robots"]["robot_0"]["pose"]
    team.robots = [graph("robot.py", "robot_0", "map", str(x), str(y)), *team.robots]
    team.until(lambda: team.heard()[0])
    team.stands(time.time())
    team.resume()


def test_a_robot_that_does_not_move_is_named_within_three_seconds(team):
    team = team(more="unresponsive: stop")
    team.go()
    team.stopped(team.robots[1].tell(deaf=True), "unresponsive: robot_1", 3.0)
    team.stands(team.robots[1].tell(deaf=False))
    team.resume()


def test_a_map_of_another_resolution_stops_nobody_and_one_without_a_robot_all(team):
    team = team()
    team.go()
    for resolution in (0.05, 0.2, 0.1):
        before = team.peers.status["time"]
        team.send_map(resolution)
        team.until(lambda before=before: team.peers.status["time"] > before + 2.0)
        assert team.peers.status["ok"], team.peers.status
        team.go()
    since = time.time()
    team.send_map(0.1, (0.5, 0.5))
    team.stopped(since, "out-of-map", 0.0)
    assert not team.peers.call("resume").success
    team.send_map(0.1)
    team.stands(time.time())
    team.resume()


def test_a_clock_that_jumps_or_stands_stops_all(team, graph):
    clock = graph("clock.py")
    team = team("--sim-time")
    for fault, cause, limit in (
        ({"by": -5.0}, "clock-back", 0.0),
        ({"by": -0.3}, "clock-back", 0.0),
        ({"runs": False}, "clock-still", MAX_AGE),
        ({"by": 5.0}, "clock-forward", 0.0),
    ):
        team.go()
        team.stopped(clock.tell(**fault), cause, limit)
        if "runs" in fault:
            assert not team.peers.call("resume").success
        team.stands(clock.tell(runs=True))
        team.resume()


def test_robots_of_a_killed_node_stop_by_themselves(team):
    team = team()
    team.go()
    killed = time.time()
    team.node.kill()
    team.peers.until(lambda: all("stands" in robot.heard[-1] for robot in team.robots))
    stood = max(robot.heard[-1]["time"] for robot in team.robots)
    print(f"killed node: {stood - killed:.3f} s")
    assert stood - killed <= 0.5 + SLACK


def test_a_network_that_is_cut_stops_robots_at_both_ends(team, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    monkeypatch.setenv("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")  # no memory that both ends share
    with Cards(1) as cards:
        team = team(namespace=cards.namespaces[0])
        team.go()
        cut, began = time.time(), time.monotonic()
        cards.pull(0)
        team.until(lambda: team.peers.state() == "stopped")
        causes = team.peers.status["cause"]
        assert all(line.startswith("stale: robot_") for line in causes), causes
        team.until(lambda: not team.peers.moving())
        kept = [entry for commands in team.peers.commands.values() for entry in commands]
        went = max(moment for moment, command in kept if any(command)) - began
        print(f"network cut, last command to go: {went:.3f} s")
        assert went <= MAX_AGE + PERIOD + SLACK
        # What the node says is not heard there: each robot stops by itself.
        team.until(lambda: all("stands" in robot.heard[-1] for robot in team.robots))
        stood = max(robot.heard[-1]["time"] for robot in team.robots)
        print(f"network cut, robots: {stood - cut:.3f} s")
        assert stood - cut <= 0.5 + SLACK
        assert not team.peers.call("resume").success
        cards.plug(0)
        team.stands(time.time())
        team.resume()
