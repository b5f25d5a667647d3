"""A driver written with rclpy alone: driver.py SECONDS VX. Drives robot_0, then is silent.

Says the poses and the clock of robot_0 and, once, what it knows of the map and of a scan.
"""

import json
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, LaserScan

seconds, speed = float(sys.argv[1]), float(sys.argv[2])
rclpy.init()
node = rclpy.create_node("driver")
publisher = node.create_publisher(Twist, "/robot_0/cmd_vel", 10)
begun: list[float] = []
said: set[str] = set()


def say(**what: object) -> None:
    print(json.dumps(what), flush=True)


def once(kind: str, **what: object) -> None:
    if kind not in said:
        said.add(kind)
        say(kind=kind, **what)


def pose(message: PoseStamped) -> None:
    begun.append(time.monotonic())
    stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    driving = time.monotonic() - begun[0] < seconds
    x, y = message.pose.position.x, message.pose.position.y
    say(kind="pose", stamp=stamp, frame=message.header.frame_id, x=x, y=y, driving=driving)


def drive() -> None:
    if begun and time.monotonic() - begun[0] < seconds:
        command = Twist()
        command.linear.x = speed
        publisher.publish(command)


sensor = qos_profile_sensor_data
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(PoseStamped, "/robot_0/pose", pose, sensor)
node.create_subscription(Clock, "/clock", lambda m: once("clock", sec=m.clock.sec), sensor)
node.create_subscription(
    OccupancyGrid, "/map", lambda m: once("map", cells=len(m.data), width=m.info.width), latched
)
node.create_subscription(
    LaserScan,
    "/robot_0/scan",
    lambda m: once("scan", rays=len(m.ranges), least=min(m.ranges)),
    sensor,
)
node.create_subscription(
    JointState, "/robot_0/joint_states", lambda m: once("joints", names=list(m.name)), 10
)
node.create_timer(0.05, drive)
rclpy.spin(node)
