"""A clock written with rclpy alone: clock.py. It is set by lines of JSON on its standard input.

{"by": -5.0} sets it back by 5 s; {"runs": false} lets it show the same time from then on.
"""

import json
import sys
import threading
import time

import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

rclpy.init()
node = rclpy.create_node("clock")
publisher = node.create_publisher(Clock, "/clock", qos_profile_sensor_data)
state = {"now": 1000.0, "runs": True, "last": time.monotonic()}
lock = threading.Lock()


def tick() -> None:
    with lock:
        now = time.monotonic()
        if state["runs"]:
            state["now"] += now - state["last"]
        state["last"] = now
        shown = Time(nanoseconds=int(1e9 * state["now"])).to_msg()
    publisher.publish(Clock(clock=shown))


def listen() -> None:
    for line in sys.stdin:
        change = json.loads(line)
        with lock:
            state["now"] += change.get("by", 0.0)
            state["runs"] = change.get("runs", state["runs"])
            print(json.dumps({"time": time.time(), "told": change}), flush=True)


threading.Thread(target=listen, daemon=True).start()
node.create_timer(0.01, tick)
rclpy.spin(node)
