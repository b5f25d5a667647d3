"""An operator of its own, without our code: publishes goals and waits until the team has arrived.

python goal.py '{"/team/goals": [[x, y, yaw], ...], "/robot_0/goal_pose": [[x, y, yaw]]}' SECONDS

Waits for a navigation that is ready, sends each topic's poses there once (nav_msgs/Path for
several, geometry_msgs/PoseStamped on topics that end in goal_pose), and prints the last status
as a JSON line. SECONDS are those of the clock that the status has.
"""

import json
import math
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String


def stamped(pose):
    message = PoseStamped()
    message.header.frame_id = "map"
    message.pose.position.x, message.pose.position.y = pose[:2]
    message.pose.orientation.z = math.sin(pose[2] / 2)
    message.pose.orientation.w = math.cos(pose[2] / 2)
    return message


def main():
    wanted, limit = json.loads(sys.argv[1]), float(sys.argv[2])
    rclpy.init()
    node = rclpy.create_node("goal_operator")
    latched = QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )
    heard = []
    node.create_subscription(
        String, "/team/status", lambda m: heard.append(json.loads(m.data)), latched
    )
    publishers = {
        topic: node.create_publisher(PoseStamped if topic.endswith("pose") else Path, topic, 10)
        for topic in wanted
    }

    def until(condition, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.05)
            if heard and condition(heard[-1]):
                return True
        return False

    ready = until(
        lambda status: (
            status["state"] in ("idle", "arrived")
            and all(p.get_subscription_count() for p in publishers.values())
        ),
        300.0,
    )
    causes, states = [], []
    began = heard[-1]["time"] if heard else 0.0
    if ready:
        for topic, poses in wanted.items():
            message = stamped(poses[0])
            if not topic.endswith("pose"):
                message = Path(poses=[stamped(pose) for pose in poses])
                message.header.frame_id = "map"
            publishers[topic].publish(message)

        def over(status):
            if not states or states[-1] != status["state"]:
                states.append(status["state"])
            if status["cause"] and status["cause"] not in causes:
                causes.append(status["cause"])
            late = status["time"] - began > limit
            return status["arrived"] or late or status["state"] == "stopped"

        # It may say for a moment yet that it has arrived where it was.
        until(lambda status: not status["arrived"], 5.0)
        until(over, 20.0 * limit)
    last = heard[-1] if heard else {}
    told = {key: last.get(key) for key in ("state", "arrived", "cause", "message", "pace")}
    took = last["time"] - began if last else None
    print(json.dumps({**told, "time_s": took, "causes": causes, "states": states}), flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
