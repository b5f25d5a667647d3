"""`cavalcade ros2 navigate` among other processes: simulated robots, an operator, rivals."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time as wall

import pytest
from navigation_peers import TEAM, Peers

from cavalcade.checking import check
from cavalcade.cli import main
from cavalcade.errors import InputError
from cavalcade.fleet.ros2 import load_rclpy, message_type, qos
from cavalcade.fleet.ros2.messages import fill_header, fill_map
from cavalcade.world import Box, OccupancyMap

GOAL, BACK = (6.5, 3.0, 0.0), (2.0, 3.0, 0.0)

try:
    load_rclpy()
except InputError as error:
    pytest.skip(str(error), allow_module_level=True)


@pytest.fixture
def peers(tmp_path, monkeypatch, request):
    domain = 1 + hash((os.getpid(), request.node.nodeid)) % 100
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    found = Peers(tmp_path)
    try:
        found.simulate()
        yield found
    finally:
        found.close()


def arrived_at(peers, goal):
    x, y, _ = goal
    places = [pose for pose, _ in peers.poses.values()]
    middle = [sum(part) / len(places) for part in zip(*places, strict=True)]
    return peers.state() == "arrived" and math.dist(middle[:2], (x, y)) < 0.15


def test_goals_shapes_stops_and_bad_input_by_topics_and_services(peers):
    navigate = peers.navigate()
    # What cannot be used is refused with a reason, and nothing happens.
    for send, reason in (
        (lambda: peers.send_goal(GOAL, "odom"), "in frame 'odom'; expected 'map'"),
        (lambda: peers.send_goal(GOAL, ""), "without a frame"),
        (lambda: peers.send_goal((math.nan, 1.0, 0.0)), "not finite"),
        (lambda: peers.send_goals([]), "at least one pose"),
        (lambda: peers.send_formation("shape: sqare"), "did you mean square"),
        (lambda: peers.send_formation("{shape: ["), "formation"),
        (lambda: peers.send_formation("line"), "expected a mapping"),
        (lambda: peers.send_goal(GOAL, "odom", "robot_0"), "/robot_0/goal_pose: in frame 'odom'"),
    ):
        send()
        peers.until(lambda reason=reason: reason in peers.status["refused"], navigate)
    assert peers.state() == "idle"
    assert peers.call("resume").success
    # A goal; on the way the e-stop.
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    peers.until(lambda: min(peers.plans.values(), default=0) > 1, navigate)
    answer = peers.call("stop")
    asked = wall.monotonic()
    assert answer.success
    peers.until(lambda: peers.state() == "stopped" and peers.standing(), navigate)
    assert not peers.call("resume").success
    peers.until(lambda: peers.quiet_since(asked + 0.1), navigate)
    assert "reset_stop, then resume" in peers.status["message"]
    assert peers.diagnostics["cavalcade hall"][0] == b"\x02"
    assert peers.call("reset_stop").success
    assert peers.call("resume").success
    peers.until(peers.moving, navigate)
    peers.call("pause")
    peers.until(lambda: peers.state() == "paused" and peers.standing(), navigate)
    peers.call("resume")
    peers.until(lambda: arrived_at(peers, GOAL), navigate)
    # A column by way of two waypoints.
    peers.send_formation("{shape: column, spacing: 1.0}")
    peers.send_goals([(4.0, 3.0, math.pi), BACK])
    peers.until(lambda: arrived_at(peers, BACK), navigate)
    # A goal of one robot: the other one stays.
    stays = peers.poses["robot_1"][0]
    peers.send_goal((5.0, 1.5, 0.0), robot="robot_0")
    peers.until(lambda: peers.state() == "arrived" and peers.status["mode"] == "individual")
    assert math.dist(peers.poses["robot_0"][0][:2], (5.0, 1.5)) < 0.2
    assert math.dist(peers.poses["robot_1"][0][:2], stays[:2]) < 0.2
    # Maps of another resolution, in another frame, and nonsense.
    grid = message_type("nav_msgs/msg/OccupancyGrid")()
    fill_map(grid, OccupancyMap.empty((9.0, 6.0), 0.1).with_shapes([Box((4.0, 3.0), (0.4, 0.4))]))
    fill_header(grid.header, peers.graph.time, "odom")
    peers.send_map(grid)
    peers.until(lambda: "/map: in frame 'odom'" in peers.status["refused"], navigate)
    grid.header.frame_id = "map"
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    peers.send_map(grid)
    peers.until(lambda: arrived_at(peers, GOAL), navigate)
    grid.data = grid.data[:-1]
    peers.send_map(grid)
    peers.until(lambda: "values for" in peers.status["refused"], navigate)
    # SIGTERM on the way ends with zeros and 0.
    peers.send_goal(BACK)
    peers.until(peers.moving, navigate)
    navigate.send_signal(signal.SIGTERM)
    assert navigate.wait(30) == 0
    assert not peers.moving()
    peers.until(lambda: peers.status["lifecycle"] == "finalized")


def test_a_second_ctrl_c_left_a_folder_that_could_not_be_checked(peers, tmp_path):
    folder = tmp_path / "session"
    navigate = peers.navigate("--out", str(folder))
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    navigate.send_signal(signal.SIGINT)
    rest = f"cavalcade show {folder} makes the rest"
    told = f"writing figures and replay to {folder}; Ctrl-C leaves the recording only ({rest})"
    peers.until(lambda: told in navigate.output.read_text(), navigate)
    navigate.send_signal(signal.SIGINT)
    assert navigate.wait(30) == 130
    assert f"{folder} has the recording only; {rest}" in navigate.output.read_text()
    assert not (folder / "summary.json").exists()
    assert check(folder).violations == ()
    assert main(["show", str(folder), "--quiet"]) == 0
    assert (folder / "replay.html").exists()


def test_killed_node_leaves_standing_robots(peers):
    navigate = peers.navigate()
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    peers.until(lambda: not peers.standing())
    navigate.kill()
    killed = wall.monotonic()
    peers.until(peers.standing)
    assert wall.monotonic() - killed < 5.0


def test_second_node_on_the_same_robots_stops_both(peers):
    first = peers.navigate()
    peers.send_goal(GOAL)
    peers.until(peers.moving, first)
    second = peers.run("ros2", "navigate", str(peers.team))
    peers.until(lambda: "second-commander" in str(peers.status["cause"]), second)
    peers.until(peers.standing)
    second.send_signal(signal.SIGINT)
    assert second.wait(30) == 0
    peers.until(lambda: peers.call("resume").success, first)
    peers.until(lambda: arrived_at(peers, GOAL), first)


def test_lifecycle_manager_brings_the_node_up_and_down(peers):
    navigate = peers.navigate("--wait")
    state = message_type("lifecycle_msgs/srv/ChangeState")
    change = "lifecycle_msgs/srv/ChangeState"

    def go(number):
        request = state.Request()
        request.transition.id = number
        return peers.call("navigator/change_state", change, request).success

    peers.send_goal(GOAL)
    peers.until(lambda: "activate it first" in peers.status["refused"], navigate)
    configure, cleanup, activate, deactivate = 1, 2, 3, 4
    assert go(configure)
    assert go(activate)
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    assert go(deactivate)
    peers.until(lambda: peers.status["lifecycle"] == "inactive" and peers.standing(), navigate)
    assert go(activate)
    peers.send_goal(GOAL)
    peers.until(peers.moving, navigate)
    assert go(deactivate)
    assert go(cleanup)
    navigate.send_signal(signal.SIGINT)
    assert navigate.wait(30) == 0


def test_activation_waits_for_a_map_that_is_published_late(peers, tmp_path):
    file = tmp_path / "team.yaml"
    file.write_text(TEAM + "map: {topic: /late_map}\n")
    kind = "nav_msgs/msg/OccupancyGrid"
    maps = peers.graph.publisher(kind, "/late_map", qos.latched())
    grid = message_type(kind)()
    fill_map(grid, OccupancyMap.empty((9.0, 6.0), 0.1))

    def publish(frame):
        fill_header(grid.header, peers.graph.time, frame)
        maps.publish(grid)

    def listeners():
        return maps.get_subscription_count()

    navigate = peers.navigate("--wait", team=file)
    peers.until(lambda: listeners() == 1, navigate)
    state = message_type("lifecycle_msgs/srv/ChangeState")
    change = peers.graph.node.create_client(state, "/team/navigator/change_state")

    def ask(number):
        request = state.Request()
        request.transition.id = number
        return change.call_async(request)

    peers.until(change.service_is_ready, navigate)
    configured = ask(1)
    peers.until(configured.done, navigate)
    assert configured.result().success
    # It waits; one that cannot be used is none.
    activated = ask(3)
    peers.until(lambda: listeners() == 2, navigate)
    publish("odom")
    peers.until(lambda: "/late_map: in frame 'odom'" in navigate.output.read_text(), navigate)
    assert not activated.done()
    publish("map")
    peers.until(activated.done, navigate)
    assert activated.result().success
    peers.send_goal((3.0, 3.0, 0.0))
    peers.until(peers.moving, navigate)
    # Whoever ends it while it waits needs no patience, and nobody moves.
    navigate.send_signal(signal.SIGTERM)
    assert navigate.wait(30) == 0
    peers.graph.node.destroy_publisher(maps)
    waiting = peers.run("ros2", "navigate", str(file))
    peers.until(lambda: peers.graph.node.count_subscribers("/late_map") == 2, waiting)
    told = wall.monotonic()
    waiting.send_signal(signal.SIGTERM)
    waiting.wait(30)
    assert wall.monotonic() - told < 10.0
    assert "Traceback" not in waiting.output.read_text()


def test_dry_run_commands_nobody(peers):
    navigate = peers.navigate("--dry-run", team=peers.scenario)
    peers.send_goal(GOAL)
    peers.until(lambda: min(peers.plans.values(), default=0) > 1, navigate)
    began = wall.monotonic()
    peers.until(lambda: peers.quiet_since(began), navigate)
    assert peers.status["dry_run"]


def test_team_file_with_odometry_a_map_by_topic_and_a_speed_limit(peers, tmp_path):
    pose = "pose: {type: Odometry, topic: odom}"
    file = tmp_path / "team.yaml"
    file.write_text(
        f"version: 1\nrobots: [{{name: robot_0, {pose}}}, {{name: robot_1, {pose}}}]\n"
        "formation: {shape: line, spacing: 1.0}\nlimits: {max_speed: 0.25}\n"
        "supervision: {deadline: 1.0}\n"
    )
    navigate = peers.navigate(team=file)
    peers.send_goal((3.0, 3.0, 0.0))
    peers.until(lambda: arrived_at(peers, (3.0, 3.0, 0.0)), navigate)
    speeds = [math.hypot(*c[:2]) for kept in peers.commands.values() for _, c in kept]
    assert 0.2 < max(speeds) < 0.25 + 1e-6


def test_bad_input_and_robots_that_are_not_there_end_with_2(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    file = tmp_path / "team.yaml"
    file.write_text("version: 1\nrobots:\n  - {name: anna, pose: {type: Pose}}\n")
    done = subprocess.run(
        [sys.executable, "-m", "cavalcade", "ros2", "navigate", str(file)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert "robots[0].pose.type: unknown value 'Pose'" in done.stderr
    assert "Traceback" not in done.stderr
