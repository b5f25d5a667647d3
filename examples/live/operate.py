"""Operate a team that `cavalcade ros2 navigate` drives, from a program of your own.

    python operate.py goal 12.6 3.9 0.0              # the formation's centre: m, m, rad
    python operate.py goal 3.0 2.0 0.0 robot_0       # one robot
    python operate.py goals 3.0,5.4,0 12.0,4.5,0     # the formation's centre, one after the other
    python operate.py formation '{shape: column, spacing: 1.0}'
    python operate.py stop                           # also reset_stop, resume, pause, cancel
    python operate.py watch                          # until the team has arrived or was stopped

It needs rclpy alone, from a distribution or from wheels, and nothing of Cavalcade. It ends with 0
if that was done, 1 if it was refused or nobody was there, 2 for other words, 130 after Ctrl-C.
"""

import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String
from std_srvs.srv import Trigger

SERVICES = ("stop", "reset_stop", "resume", "pause", "cancel")
PATIENCE = 5.0
"""For a navigation node that is not there, s."""


def wait(node: Node, holds: Callable[[], bool], lacking: str = "") -> None:
    """Hear messages until something holds.

    Raises:
        TimeoutError: The navigation node is not there; or it is, but does not come to that for a
            while. The latter is told as what is `lacking`, and without that nobody minds.
    """
    begun = heard = time.monotonic()
    while not holds():
        # A short one each time, for Ctrl-C is noticed in between.
        rclpy.spin_once(node, timeout_sec=0.1)
        now = time.monotonic()
        if ("navigator", "/team") in node.get_node_names_and_namespaces():
            heard = now
        if now - heard > PATIENCE:
            raise TimeoutError(
                f"no /team/navigator was heard in domain {node.context.get_domain_id()}: is "
                "`cavalcade ros2 navigate` running, with the same ROS_DOMAIN_ID?"
            )
        if lacking and now - begun > 2.0 * PATIENCE:
            raise TimeoutError(lacking)


def publish(node: Node, topic: str, message: Any) -> bool:
    """Publish once the navigator listens, and see that it has arrived there."""
    publisher = node.create_publisher(type(message), topic, 1)

    def listens() -> bool:
        ends = node.get_subscriptions_info_by_topic(topic)
        ours = any((end.node_namespace, end.node_name) == ("/team", "navigator") for end in ends)
        return ours and publisher.get_subscription_count() > 0

    wait(node, listens, f"/team/navigator does not listen to {topic}")
    publisher.publish(message)
    if not publisher.wait_for_all_acked(Duration(seconds=PATIENCE)):
        raise TimeoutError(f"nobody confirmed what was sent to {topic}")
    return True


def pose_of(x: float, y: float, yaw: float) -> PoseStamped:
    """A pose in frame `map`; m, m, rad."""
    goal = PoseStamped()
    goal.header.frame_id = "map"
    goal.pose.position.x, goal.pose.position.y = x, y
    goal.pose.orientation.z, goal.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return goal


def path_of(places: Sequence[str]) -> Path:
    """Waypoints that are said as `x,y,yaw`."""
    path = Path()
    path.header.frame_id = "map"
    for place in places:
        x, y, yaw = map(float, place.split(","))
        path.poses.append(pose_of(x, y, yaw))
    return path


def call(node: Node, name: str) -> bool:
    """Call a service and print its answer."""
    client = node.create_client(Trigger, f"/team/{name}")
    wait(node, client.service_is_ready, f"/team/navigator has no service /team/{name}")
    answer = client.call_async(Trigger.Request())
    wait(node, answer.done)
    print(answer.result().message)
    return answer.result().success


def watch(node: Node) -> bool:
    """Print the team's states until it has arrived or was stopped; whether it arrived."""
    states: list[str] = []

    def hear(message: String) -> None:
        status = json.loads(message.data)
        if [status["state"]] != states[-1:]:
            states.append(status["state"])
            print(status["message"] or status["state"], flush=True)

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(String, "/team/status", hear, latched)
    wait(node, lambda: states[-1:] in (["arrived"], ["stopped"]))
    return states[-1] == "arrived"


def understand(words: list[str]) -> Callable[[Node], bool] | None:
    """What to do with a node; None if it is not clear."""
    try:
        match words:
            case ["goal", x, y, yaw]:
                goal = pose_of(float(x), float(y), float(yaw))
                return lambda node: publish(node, "/team/goal_pose", goal)
            case ["goal", x, y, yaw, robot]:
                goal = pose_of(float(x), float(y), float(yaw))
                return lambda node: publish(node, f"/{robot}/goal_pose", goal)
            case ["goals", *places] if places:
                path = path_of(places)
                return lambda node: publish(node, "/team/goals", path)
            case ["formation", shape]:
                return lambda node: publish(node, "/team/formation", String(data=shape))
            case ["watch"]:
                return watch
            case [name] if name in SERVICES:
                return lambda node: call(node, name)
    except ValueError:  # of what is no number, or not three of them
        pass
    return None


def main(words: list[str]) -> int:
    act = understand(words)
    if act is None:
        print(__doc__)
        return 2
    try:
        # Ctrl-C is Python's, so that it ends what is going on, whatever that is.
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node("operator")
        return 0 if act(node) else 1
    except TimeoutError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
