"""Operate a team that `cavalcade ros2 navigate` drives, from a program of your own.

    python operate.py goal 12.6 3.9 0.0              # the formation's centre: m, m, rad
    python operate.py goal 3.0 2.0 0.0 robot_0       # one robot
    python operate.py stop                           # also reset_stop, resume, pause, cancel
    python operate.py watch                          # until the team has arrived or was stopped

It needs rclpy alone, from a distribution or from wheels, and nothing of Cavalcade.
"""

import json
import math
import sys

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

SERVICES = ("stop", "reset_stop", "resume", "pause", "cancel")


def send_goal(node: Node, x: float, y: float, yaw: float, robot: str = "team") -> bool:
    """Publish a goal once the navigator listens; frame `map`."""
    publisher = node.create_publisher(PoseStamped, f"/{robot}/goal_pose", 1)
    while not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.1)
    goal = PoseStamped()
    goal.header.frame_id = "map"
    goal.pose.position.x, goal.pose.position.y = x, y
    goal.pose.orientation.z, goal.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    publisher.publish(goal)
    publisher.wait_for_all_acked()
    return True


def call(node: Node, name: str) -> bool:
    """Call a service and print its answer."""
    client = node.create_client(Trigger, f"/team/{name}")
    client.wait_for_service()
    answer = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, answer)
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
    while states[-1:] not in (["arrived"], ["stopped"]):
        rclpy.spin_once(node)
    return states[-1] == "arrived"


def main(words: list[str]) -> int:
    rclpy.init()
    node = rclpy.create_node("operator")
    try:
        match words:
            case ["goal", x, y, yaw, *robot]:
                done = send_goal(node, float(x), float(y), float(yaw), *robot)
            case ["watch"]:
                done = watch(node)
            case [name] if name in SERVICES:
                done = call(node, name)
            case _:
                print(__doc__)
                return 2
    except (KeyboardInterrupt, ExternalShutdownException):
        done = False
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0 if done else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
