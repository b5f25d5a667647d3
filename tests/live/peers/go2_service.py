"""A service in the vendor's own C++ library, with the Cyclone DDS 0.10.2 of a robot: CARD."""

import sys
import time

import unitree_interface as vendor

robot = vendor.UnitreeInterface(sys.argv[1], vendor.RobotType.GO2, vendor.MessageType.GO2)
robot.enable_motion_switcher_responder()
while True:
    time.sleep(1.0)
