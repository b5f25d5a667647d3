"""A robot written with rclpy alone: robot.py NAME [FRAME] [X Y] [--sim-time].

Says each command that it hears, and when it stops because it hears none. It misbehaves as lines of
JSON on its standard input tell it, such as {"frame": "odom"}; which is possible is `state`.
"""

import json
import math
import sys
import threading
import time
from collections import deque

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data

PERIOD, SILENCE = 0.02, 0.5
words = [word for word in sys.argv[1:] if word != "--sim-time"]
name, frame = words[0], (words[1] if len(words) > 1 else "map")
x, y = map(float, words[2:4]) if len(words) > 2 else (1.0, 2.0)
rclpy.init()
sim_time = Parameter("use_sim_time", value="--sim-time" in sys.argv)
node = rclpy.create_node(f"driver_{name}", parameter_overrides=[sim_time])
body = {"x": x, "y": y, "yaw": 0.5 if len(words) < 3 else 0.0, "heard": 0.0}
command = [0.0, 0.0, 0.0]
state = {
    "frame": frame,
    "delay": 0.0,  # poses come so late, s
    "ahead": 0.0,  # their stamps are ahead of the clock, s
    "stamp": True,
    "nan": False,
    "heading": True,  # or a quaternion of zeros
    "aside": 0.0,  # they are so far from the robot, m
    "silent": False,
    "deaf": False,  # it hears commands, but stands
}
late: deque[tuple[float, PoseStamped]] = deque()
publisher = node.create_publisher(PoseStamped, f"/{name}/pose", qos_profile_sensor_data)


def say(**what: object) -> None:
    print(json.dumps({"time": time.time(), **what}), flush=True)


def hear(message: Twist) -> None:
    command[:] = message.linear.x, message.linear.y, message.angular.z
    body["heard"] = time.monotonic()
    say(command=command)


def step() -> None:
    if any(command) and time.monotonic() - body["heard"] > SILENCE:
        command[:] = 0.0, 0.0, 0.0
        say(stands="heard nothing")
    vx, vy, rate = (0.0, 0.0, 0.0) if state["deaf"] else command
    c, s = math.cos(body["yaw"]), math.sin(body["yaw"])
    body["x"] += PERIOD * (c * vx - s * vy)
    body["y"] += PERIOD * (s * vx + c * vy)
    body["yaw"] += PERIOD * rate
    late.append((time.monotonic() + state["delay"], report()))
    while late and late[0][0] <= time.monotonic():
        told = late.popleft()[1]
        if not state["silent"]:
            publisher.publish(told)


def report() -> PoseStamped:
    message = PoseStamped()
    if state["stamp"]:
        now = node.get_clock().now() + Duration(seconds=state["ahead"])
        message.header.stamp = now.to_msg()
    message.header.frame_id = state["frame"]
    message.pose.position.x = math.nan if state["nan"] else body["x"] + state["aside"]
    message.pose.position.y = body["y"]
    message.pose.orientation.z = math.sin(0.5 * body["yaw"]) if state["heading"] else 0.0
    message.pose.orientation.w = math.cos(0.5 * body["yaw"]) if state["heading"] else 0.0
    return message


def listen() -> None:
    for line in sys.stdin:
        change = json.loads(line)
        assert change.keys() <= state.keys()
        state.update(change)
        say(told=change)


threading.Thread(target=listen, daemon=True).start()
node.create_subscription(Twist, f"/{name}/cmd_vel", hear, 10)
node.create_timer(PERIOD, step, clock=Clock(clock_type=ClockType.STEADY_TIME))
rclpy.spin(node)
