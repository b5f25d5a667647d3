"""What decides where robots go: the seam between the control loop and planners of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from cavalcade.formation import DynamicObstacle, Formation
from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import OccupancyMap


@runtime_checkable
class Policy(Protocol):
    """Poses in, velocity commands out, once per cycle."""

    @property
    def status(self) -> PlannerStatus:
        """Of the last cycle."""

    def step(self, poses: Array, time: float, stamps: Array) -> Array:
        """Poses `(N, 3)` and their times `(N,)` in, body-frame velocities `(N, 3)` out."""

    def pause(self) -> None:
        """Stop until `resume`.

        Derived classes need do nothing, as `step` is not called meanwhile.
        """
        return

    def resume(self) -> None:
        """Go on."""
        return


@runtime_checkable
class Degradable(Policy, Protocol):
    """A policy that can go on without a robot."""

    def lose(self, robot: int) -> None:
        """Go on without a robot."""

    def rejoin(self, robot: int) -> None:
        """Take a robot back."""


@runtime_checkable
class Reconfigurable(Degradable, Protocol):
    """A policy that takes another task or another world while it runs.

    `cavalcade.formation.FormationPlanner` is one.
    """

    def set_goals(self, goals: Sequence[Sequence[float]]) -> None:
        """Replace the goals by these poses of the formation's centre."""

    def set_formation(self, formation: Formation) -> None:
        """Change the shape."""

    def update_map(self, map: OccupancyMap) -> None:
        """Replace the map."""

    def set_dynamic_obstacles(self, obstacles: Sequence[DynamicObstacle]) -> None:
        """Say what moves and how fast."""
