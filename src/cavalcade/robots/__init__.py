"""Robot models as data."""

from cavalcade.robots.catalogue import MODELS, robot_model
from cavalcade.robots.description import JOINTS, LEGS, PARTS, BodyShape, QuadrupedDescription
from cavalcade.robots.legs import LegModel
from cavalcade.robots.model import Drive, RobotModel

__all__ = [
    "JOINTS",
    "LEGS",
    "MODELS",
    "PARTS",
    "BodyShape",
    "Drive",
    "LegModel",
    "QuadrupedDescription",
    "RobotModel",
    "robot_model",
]
