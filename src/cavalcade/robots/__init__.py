"""Robot models as data."""

from cavalcade.robots.model import MODELS, RobotModel, robot_model

__all__ = ["MODELS", "RobotModel", "robot_model"]
