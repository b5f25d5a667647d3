"""Robot models as data."""

from cavalcade.robots.catalogue import (
    MODELS,
    ModelRegistry,
    is_model_file,
    load_model,
    register_model,
    robot_model,
)
from cavalcade.robots.description import JOINTS, LEGS, PARTS, BodyShape, QuadrupedDescription
from cavalcade.robots.model import Drive, LegModel, RobotModel, check_model

__all__ = [
    "JOINTS",
    "LEGS",
    "MODELS",
    "PARTS",
    "BodyShape",
    "Drive",
    "LegModel",
    "ModelRegistry",
    "QuadrupedDescription",
    "RobotModel",
    "check_model",
    "is_model_file",
    "load_model",
    "register_model",
    "robot_model",
]
