"""How one Go2 is reached and located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from cavalcade.errors import InputError
from cavalcade.values import number_in, pose_of, whole_number

PoseSource = Literal["sport", "external"]


@dataclass(frozen=True)
class Go2Link:
    """One robot's place on the network, and who says where it is.

    All Go2s use the same topics: each needs a DDS domain or a network interface of its own.

    Attributes:
        domain: DDS domain; a robot as it is delivered is in 0.
        interface: Network interface that the robot is behind, such as `eth1`; None for the one
            that the system prefers. `lo` for a mock on this machine.
        pose_source: `sport` takes the robot's own odometry, which drifts: some centimetres per
            metre. `external` are poses that the application hands in with `Go2Fleet.set_pose`,
            such as those of motion capture.
        offset: Pose of the odometry's origin in the map, x, y in m, yaw in rad. None: the robot
            stands at its start when the fleet starts.
        battery_min: Charge below which the robot is to stop, %.

    Raises:
        InputError: A value is out of range.
    """

    domain: int = 0
    interface: str | None = None
    pose_source: PoseSource = "sport"
    offset: tuple[float, float, float] | None = None
    battery_min: float = 20.0

    def __post_init__(self) -> None:
        whole_number(self.domain, "domain", 0, 232)
        name = "eth0" if self.interface is None else self.interface
        if not isinstance(name, str) or not name or set(name) & set("\"'<>& "):
            raise InputError("expected the name of a network interface", key="interface")
        if self.pose_source not in get_args(PoseSource):
            raise InputError(
                "who says where it is", key="pose_source", choices=get_args(PoseSource)
            )
        if self.offset is not None:
            object.__setattr__(self, "offset", pose_of(self.offset, "offset"))
        number_in(self.battery_min, "battery_min", 0.0, 100.0)

    @property
    def place(self) -> str:
        """Where it is, for people."""
        return f"domain {self.domain} on {self.interface or 'the default interface'}"
