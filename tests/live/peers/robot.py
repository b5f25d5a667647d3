"""A robot written with rclpy alone: robot.py NAME [FRAME]. Says each command that it hears."""

import json
import math
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.qos import qos_profile_sensor_data

name, frame = sys.argv[1], (sys.argv[2] if len(sys.argv) > 2 else "map")
rclpy.init()
node = rclpy.create_node(f"driver_{name}")
state = {"x": 1.0, "y": 2.0, "yaw": 0.5, "command": (0.0, 0.0, 0.0)}
publisher = node.create_publisher(PoseStamped, f"/{name}/pose", qos_profile_sensor_data)


def hear(message: Twist) -> None:
    state["command"] = (message.linear.x, message.linear.y, message.angular.z)
    print(json.dumps({"time": time.time(), "command": state["command"]}), flush=True)


def step() -> None:
    vx, vy, rate = state["command"]
    c, s = math.cos(state["yaw"]), math.sin(state["yaw"])
    state["x"] += 0.02 * (c * vx - s * vy)
    state["y"] += 0.02 * (s * vx + c * vy)
    state["yaw"] += 0.02 * rate
    message = PoseStamped()
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y = state["x"], state["y"]
    message.pose.orientation.z = math.sin(0.5 * state["yaw"])
    message.pose.orientation.w = math.cos(0.5 * state["yaw"])
    publisher.publish(message)


node.create_subscription(Twist, f"/{name}/cmd_vel", hear, 10)
node.create_timer(0.02, step)
rclpy.spin(node)
