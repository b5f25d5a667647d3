"""How one robot is found on the graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from cavalcade.errors import InputError

PoseSource = Literal["PoseStamped", "PoseWithCovarianceStamped", "Odometry", "tf"]
VelocityType = Literal["Twist", "TwistStamped"]


@dataclass(frozen=True)
class Ros2Robot:
    """One robot's topics. Names without a leading slash are relative to the robot's namespace.

    Attributes:
        name: The robot's, which is its namespace: `robot_0` has topics `/robot_0/...`.
        pose_type: Of the message that says where it is, or `tf` for a transform.
        pose_topic: Where that is published; not used with `tf`.
        velocity_type, velocity_topic: Of the commands it listens to.
        frame: In which poses have to be given.
        base_frame: The robot's own, `NAME/base_link` if empty: which transform is looked up, and
            what stamped commands bear.

    Raises:
        InputError: A value is none of the choices, or a name is empty.
    """

    name: str
    pose_type: PoseSource = "PoseStamped"
    pose_topic: str = "pose"
    velocity_type: VelocityType = "Twist"
    velocity_topic: str = "cmd_vel"
    frame: str = "map"
    base_frame: str = ""

    def __post_init__(self) -> None:
        for key, choices in (("pose_type", PoseSource), ("velocity_type", VelocityType)):
            if getattr(self, key) not in get_args(choices):
                raise InputError("unknown type", key=key, choices=get_args(choices))
        for key in ("name", "pose_topic", "velocity_topic", "frame"):
            if not isinstance(getattr(self, key), str) or not getattr(self, key).strip("/ "):
                raise InputError("expected a name", key=key)
        if not self.base_frame:
            object.__setattr__(self, "base_frame", f"{self.namespace[1:]}/base_link")

    @property
    def namespace(self) -> str:
        """With its leading slash."""
        return "/" + self.name.strip("/")

    @property
    def pose_source(self) -> str:
        """Where its pose comes from, for people: the topic or the transform."""
        if self.pose_type == "tf":
            return f"tf {self.frame} -> {self.base_frame}"
        return self.topic(self.pose_topic)

    def topic(self, name: str) -> str:
        """A topic's whole name."""
        return name if name.startswith("/") else f"{self.namespace}/{name}"


def scenario_robots(count: int) -> tuple[Ros2Robot, ...]:
    """The robots of a scenario: `robot_0`, `robot_1` and so on, with PoseStamped and Twist."""
    return tuple(Ros2Robot(f"robot_{number}") for number in range(count))
