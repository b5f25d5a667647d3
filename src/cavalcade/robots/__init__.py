"""Robot models as data."""

from cavalcade.robots.catalogue import MODELS, robot_model
from cavalcade.robots.legs import LegModel
from cavalcade.robots.model import Drive, RobotModel

__all__ = ["MODELS", "Drive", "LegModel", "RobotModel", "robot_model"]
