from .availability import has_message_type as has_message_type
from .availability import load_rclpy as load_rclpy
from .availability import message_type as message_type
from .fleet import Ros2Fleet as Ros2Fleet
from .graph import Graph as Graph
from .robot import Ros2Robot as Ros2Robot
from .robot import scenario_robots as scenario_robots
