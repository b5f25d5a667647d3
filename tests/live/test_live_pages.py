"""The documentation of live teams does what it says, on a graph of its own."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from navigation_peers import Peers
from ros2_lines import carry_out

from cavalcade.errors import InputError
from cavalcade.fleet.ros2 import load_rclpy, qos
from cavalcade.live import status as status_module

ROOT = Path(__file__).resolve().parents[2]
LESSON = ROOT / "docs" / "tutorial" / "live.md"
CONFIG = Path(status_module.__file__).parent / "config"
EXAMPLES = ROOT / "examples" / "live"

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
    monkeypatch.chdir(tmp_path)
    found = Peers(tmp_path)
    try:
        yield found
    finally:
        found.close()


def lines_of(page):
    """The commands of a page that are run, as words."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    text = "".join(one for one in blocks if not one.startswith("# Not run by the tests"))
    return [shlex.split(line, comments=True) for line in text.replace("\\\n", " ").splitlines()]


def operate_until(peers, condition, node):
    """Wait until it holds, and resume a team that a busy machine has stopped."""

    def holds():
        causes = peers.status["cause"]
        if causes and all(cause.startswith(("deadline", "stale")) for cause in causes):
            peers.call("resume")
        return condition()

    peers.until(holds, node, 240.0)


def test_the_lesson_does_what_it_says(peers):
    lines, text = iter(lines_of(LESSON)), LESSON.read_text("utf-8")

    def go(start):
        """Carry the next line out, which begins so."""
        words = next(lines)
        assert words[: len(start.split())] == start.split()
        if words[0] == "cavalcade":
            return peers.run(*words[1:])
        return carry_out(peers.graph, words)

    def until(state, process):
        operate_until(peers, lambda: peers.state() == state, process)

    simulation = go("cavalcade ros2 simulate")
    peers.until(lambda: len(peers.poses) == 2, simulation)
    node = go("cavalcade ros2 navigate")
    peers.until(lambda: peers.status.get("lifecycle") == "active", node, 300.0)
    go("ros2 topic pub")
    until("arrived", node)
    assert json.loads(go("ros2 topic echo"))["arrived"]
    # The e-stop on the way back.
    go("ros2 topic pub")
    operate_until(peers, peers.moving, node)
    assert go("ros2 service call /team/stop").success
    until("stopped", node)
    refused = peers.call("resume")
    assert not refused.success
    assert refused.message.endswith("e-stop. When it is over, call reset_stop, then resume")
    assert "`stopped: e-stop. When it is over, call reset_stop, then resume`" in text
    assert go("ros2 service call /team/reset_stop").success
    assert go("ros2 service call /team/resume").success
    operate_until(peers, peers.moving, node)
    # The simulation ends and begins anew.
    simulation.send_signal(signal.SIGINT)
    simulation.wait(20)
    peers.until(lambda: peers.state() == "stopped", node)
    assert peers.status["cause"][0].startswith(("clock-still", "deadline"))
    peers.poses.clear()
    simulation = peers.run("ros2", "simulate", "square-clutter")
    peers.until(lambda: len(peers.poses) == 2, simulation)
    peers.until(lambda: peers.call("resume").success, node)
    operate_until(peers, peers.moving, node)
    # Waypoints, a shape, and a goal of one robot.
    go("ros2 topic pub")
    peers.until(lambda: len(peers.status["goals"]) == 2, node)
    go("ros2 topic pub")
    go("ros2 topic pub")
    peers.until(lambda: peers.status["mode"] == "individual", node)
    assert not peers.status["refused"]
    until("arrived", node)
    assert next(lines, None) is None
    node.send_signal(signal.SIGINT)
    assert node.wait(60) == 0
    for said in ("all of robot_0, robot_1, robot_2, robot_3 were heard", "active", "arrived"):
        assert f"square-clutter: {said}\n" in node.output.read_text()
        assert f"square-clutter: {said}" in text
    for name in ("replay.html", "summary.json", "recording.mcap"):
        assert (peers.folder / "runs/live" / name).stat().st_size > 0


def test_the_example_operates_a_team(peers):
    def operate(*words):
        command = [sys.executable, str(EXAMPLES / "operate.py"), *words]
        return subprocess.run(command, capture_output=True, text=True, timeout=120)

    simulation = peers.run("ros2", "simulate", str(EXAMPLES / "hall.yaml"))
    peers.until(lambda: len(peers.poses) == 2, simulation)
    # How busy the machine is must not matter.
    team = yaml.safe_load((EXAMPLES / "team.yaml").read_text("utf-8"))
    team["supervision"] |= {"deadline": 3.0, "max_age": 5.0}
    file = peers.folder / "team.yaml"
    file.write_text(yaml.safe_dump(team), encoding="utf-8")
    node = peers.run("ros2", "navigate", str(file))
    peers.until(lambda: peers.status.get("lifecycle") == "active", node, 300.0)
    assert operate("goal", "7.6", "3.0", "0").returncode == 0
    peers.until(peers.moving, node)
    assert operate("stop").returncode == 0
    watched = operate("watch")
    assert watched.returncode == 1
    assert "e-stop" in watched.stdout
    assert operate("resume").returncode == 1
    assert operate("reset_stop").returncode == 0
    assert operate("resume").returncode == 0
    assert operate("watch").returncode == 0
    # On the way there is a shape and a second waypoint.
    assert operate("formation", "{shape: column, spacing: 1.0}").returncode == 0
    assert operate("goals", "5.0,3.0,0", "3.0,3.0,0").returncode == 0
    peers.until(lambda: len(peers.status["goals"]) == 2, node)
    assert not peers.status["refused"]
    assert operate("goal", "2.0", "1.0", "0", "robot_3").returncode == 0
    peers.until(lambda: peers.status["mode"] == "individual", node)
    lost = operate("goal", "2.0", "1.0", "0", "robot_9")
    assert lost.returncode == 1
    assert lost.stderr == "/team/navigator does not listen to /robot_9/goal_pose\n"


@pytest.mark.parametrize(
    "words",
    [
        "dance", "", "goal 1 2", "goal 1 2 north", "goals", "goals 1,2", "goals 1,2,0 3,4,a",
        "formation", "stop now",
    ],
)  # fmt: skip
def test_words_that_the_example_does_not_know(words):
    command = [sys.executable, str(EXAMPLES / "operate.py"), *words.split()]
    said = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert said.returncode == 2
    assert "python operate.py goal" in said.stdout
    assert said.stderr == ""


@pytest.mark.parametrize("words", ["goals 1,2,0", "stop", "watch"])
def test_the_example_waited_for_ever_where_nobody_navigates(peers, words):
    command = [sys.executable, str(EXAMPLES / "operate.py"), *words.split()]
    said = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert said.returncode == 1
    domain = os.environ["ROS_DOMAIN_ID"]
    assert said.stderr.startswith(f"no /team/navigator was heard in domain {domain}: ")
    assert said.stderr.count("\n") == 1
    # Ctrl-C had a traceback.
    waiting = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    peers.until(lambda: "operator" in other_nodes(peers))
    waiting.send_signal(signal.SIGINT)
    assert waiting.communicate(timeout=30)[1] == ""
    assert waiting.returncode == 130


def other_nodes(peers):
    """Names of nodes on the graph, without the test's own."""
    names = peers.graph.node.get_node_names()
    names.remove(peers.graph.node.get_name())
    return names


def shown_topics():
    """What the configurations show and send, with the types that their displays take."""
    kinds = {
        "rviz_default_plugins/Map": "nav_msgs/msg/OccupancyGrid",
        "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
        "rviz_default_plugins/Path": "nav_msgs/msg/Path",
        "rviz_default_plugins/RobotModel": "std_msgs/msg/String",
    }
    rviz = yaml.safe_load((CONFIG / "team.rviz").read_text())["Visualization Manager"]
    shown, sent = set(), set()
    for display in rviz["Displays"]:
        if topic := display.get("Topic", display.get("Description Topic")):
            kept = topic["Durability Policy"].upper().replace(" ", "_")
            shown.add((topic["Value"], kinds[display["Class"]], kept))
    for tool in rviz["Tools"]:
        if "Topic" in tool:
            sent.add((tool["Topic"]["Value"], "geometry_msgs/msg/PoseStamped"))
    assert rviz["Global Options"]["Fixed Frame"] == "map"
    panels = json.loads((CONFIG / "team.foxglove.json").read_text())["configById"]
    scene = panels["3D!team"]
    foxglove = {topic for topic in scene["topics"] if topic != "/tf"}
    foxglove.add(panels["RawMessages!status"]["topicPath"].removesuffix(".data"))
    foxglove.add(panels["DiagnosticSummary!all"]["topicToRender"])
    sent.add((scene["publish"]["poseTopic"], "geometry_msgs/msg/PoseStamped"))
    services = {one["serviceName"] for key, one in panels.items() if key.startswith("CallService")}
    return shown, sent, foxglove, services


def test_what_rviz_and_foxglove_show_is_there(peers):
    """Every topic with its type and quality, for the robots that the lesson simulates."""
    simulation = peers.run("ros2", "simulate", "square-clutter")
    peers.until(lambda: len(peers.poses) == 2, simulation)
    node = peers.run("ros2", "navigate", "square-clutter")
    peers.until(lambda: peers.status.get("lifecycle") == "active", node, 300.0)
    graph = peers.graph.node
    shown, sent, foxglove, services = shown_topics()
    assert len(shown) == 10
    assert len(sent) == 5
    for topic, kind, durability in shown:
        ends = [e for e in graph.get_publishers_info_by_topic(topic) if e.node_name != "operator"]
        assert [end.topic_type for end in ends] == [kind], topic
        assert ends[0].qos_profile.durability.name == durability == qos.latched().durability.name
    for topic, kind in sent:
        ends = graph.get_subscriptions_info_by_topic(topic)
        assert [end.topic_type for end in ends] == [kind], topic
    for topic in foxglove:
        assert graph.count_publishers(topic), topic
    known = dict(graph.get_service_names_and_types())
    for name in services:
        assert known[name] == ["std_srvs/srv/Trigger"], name
