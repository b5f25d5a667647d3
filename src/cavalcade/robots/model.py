"""What planners, fleets and the checker need to know of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cavalcade.robots.description import QuadrupedDescription
from cavalcade.robots.legs import LegModel

Drive = Literal["legged", "unicycle", "unicycle-2", "integrator", "integrator-2"]


@dataclass(frozen=True)
class RobotModel:
    """A robot seen from above.

    Under a formation planner robots are holonomic: the reachable velocities form an ellipse in
    the body frame with the semi-axes `max_speed_x` and `max_speed_y` (Norén et al., eq. 8).
    With goals of their own they move as `drive` says: `legged` as `legs` says; `unicycle`
    forwards, backwards and turning, `unicycle-2` the same with limited accelerations;
    `integrator` and `integrator-2` in all directions, the latter with limited acceleration. Their
    limits hold for the vector's length, whatever its direction.

    Attributes:
        name: The name scenario files use.
        length, width, height: Body in m; `length` lies along x. `length` and `width` are the
            oriented footprint that the checker sweeps; of a round robot both are its diameter.
        max_speed_x, max_speed_y: m/s, along and across the body.
        max_yaw_rate: rad/s.
        max_acceleration: m/s², of the velocity seen in the map frame; inf for drives without.
        max_yaw_acceleration: rad/s²; likewise.
        source: Where the figures come from.
        stray: How far a walking robot may be, in physics, from where the motion model of
            `cavalcade.robots.motion` sees it come to a stop, m; measured, see docs/physics.md.
        drive: How it moves towards a goal of its own.
        round: Whether the footprint is a disc.
        legs: Of a legged robot, for planners.
        description: Its mechanism, for physics; None where there is none.
    """

    name: str
    length: float
    width: float
    height: float
    max_speed_x: float
    max_speed_y: float
    max_yaw_rate: float
    max_acceleration: float
    max_yaw_acceleration: float
    source: str
    stray: float = 0.0
    drive: Drive = "legged"
    round: bool = False
    legs: LegModel | None = None
    description: QuadrupedDescription | None = None

    @property
    def body(self) -> tuple[float, float, float]:
        """The footprint as an inflated rectangle: length, width and inflation, m."""
        if self.round:
            return 0.0, 0.0, 0.5 * self.length
        return self.length, self.width, 0.0
