"""Runs with physics, judged from what was recorded of bodies, joints and contacts.

Shares nothing with controllers, simulators and planners: forward kinematics, momentum, contact by
geometry and the criterion of a leap are its own. What it knows of robots is their description.
"""

from cavalcade.checking.ground import Floor
from cavalcade.checking.heights import floor_of
from cavalcade.checking.physics.judge import Conditions, Push, judge_robots
from cavalcade.checking.physics.leaps import Leap, LeapVerdict, judge_leap
from cavalcade.checking.physics.record import RobotRecord, Touch, records_from

__all__ = [
    "Conditions",
    "Floor",
    "Leap",
    "LeapVerdict",
    "Push",
    "RobotRecord",
    "Touch",
    "floor_of",
    "judge_leap",
    "judge_robots",
    "records_from",
]
