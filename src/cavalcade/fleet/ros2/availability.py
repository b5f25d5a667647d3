"""Loading ROS 2 when it is needed: `rclpy` and the types of messages.

It comes from a distribution that was sourced or from wheels; both are used alike.
"""

from __future__ import annotations

import importlib
import warnings
from typing import Any

from cavalcade.errors import InputError

_HOW = (
    "source a distribution made for this Python (source /opt/ros/jazzy/setup.bash), "
    "or pip install 'cavalcade[ros2]'"
)


def load_rclpy() -> Any:
    """The module `rclpy`.

    Raises:
        InputError: It is not there or does not load; the line says how to get it.
    """
    try:
        with warnings.catch_warnings():
            # Its parsers of interface files use what newer Pythons call deprecated.
            warnings.simplefilter("ignore", DeprecationWarning)
            importlib.import_module("rosidl_generator_py")
            return importlib.import_module("rclpy")
    except ImportError as error:
        # What is there but does not load is mostly made for another Python.
        why = "" if isinstance(error, ModuleNotFoundError) else f" ({error})"
        raise InputError(f"rclpy cannot be loaded{why}: {_HOW}", key="ros2") from None


def message_type(name: str) -> Any:
    """The class of a message or service by its name, such as `geometry_msgs/msg/Twist`.

    Raises:
        InputError: There is none; the line says where it comes from.
    """
    load_rclpy()
    package, kind, message = name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), message)
    except (ImportError, AttributeError):
        wheel = f"ros-{package.replace('_', '-')}"
        raise InputError(
            f"{name} is not there: install the package {package} of your ROS 2 distribution, "
            f"or pip install {wheel}",
            key="ros2",
        ) from None


def has_message_type(name: str) -> bool:
    """Whether there is a message of that name; some packages have no wheels."""
    try:
        message_type(name)
    except InputError:
        return False
    return True
