"""The safety filter: commands that keep oriented footprints apart and off obstacles.

Two stages. The first changes the wanted velocities as little as possible (weighted least
squares) so that no robot closes in on anything faster than it can brake for. The second rolls
every command out for one cycle followed by a full stop and lets robots step down until that is
clear, so that stopping stays possible in every cycle.

The guarantee: from a state in which all robots can stop without contact - standing apart is one -
robots that obey the commands within their motion limits touch neither what stands nor one
another, whatever was wanted, as long as the filter is asked in every period. Dynamic obstacles
are taken to go on as they do; robots keep clear of them as far as braking and giving way can, but
no filter keeps clear of an obstacle that drives into a robot with nowhere to go.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.eikonal import surface_distance
from cavalcade.errors import InputError
from cavalcade.formation._certificate import safe_commands
from cavalcade.formation._clearance import Footprint, Surroundings
from cavalcade.formation._least_change import (
    FilterParameters,
    Horizon,
    Margins,
    TeamState,
    to_body,
)
from cavalcade.formation.dynamic_obstacles import DynamicObstacle, obstacle_boxes
from cavalcade.formation.estimation import Imperfections
from cavalcade.geometry import Array, as_floats, inverse_transform_points, rotation
from cavalcade.robots import RobotModel, robot_model
from cavalcade.robots.motion import limits_of
from cavalcade.world import OccupancyMap

AIMED = Margins(obstacle=0.04, footprint=0.06, centres=0.62)
"""What the first stage aims at.

The gaps between centres are the paper's 0.60 m and a little more, the same for every model: what
keeps bodies of any size apart are the gaps between footprints.
"""
INSISTED = Margins(obstacle=0.01, footprint=0.02, centres=0.605)
"""What the second stage insists on."""
_PRECEDENCE = 4.0  # how much dearer a robot's change is than that of the next in rank
_DISCS = (5, 2)  # columns and rows of the discs that stand for a body: its corners count
_WEIGHTS = 1000.0  # largest ratio of such weights in one team


class SafetyInputs(NamedTuple):
    """What one cycle of the filter knows, in the grid's frame: the team, and what is around it.

    `SafetyInputs.of` makes them from poses and commands.
    """

    team: TeamState
    surroundings: Surroundings

    @classmethod
    def of(
        cls,
        map: OccupancyMap,
        poses: ArrayLike,
        velocities: ArrayLike,
        commands: ArrayLike,
        *,
        obstacles: Sequence[DynamicObstacle] = (),
        clearance: float = 0.0,
        rank: ArrayLike | None = None,
        frozen: ArrayLike | None = None,
        distances: Array | None = None,
    ) -> SafetyInputs:
        """Inputs from what is known in the map's frame.

        Args:
            map: The world.
            poses: `(N, 3)` x, y in m and yaw in rad.
            velocities: `(N, 3)` present velocities in the map's frame: m/s, m/s, rad/s.
            commands: `(N, 3)` commands that are asked for, body frame: m/s, m/s, rad/s.
            obstacles: What moves.
            clearance: What centres keep off obstacles besides the footprints' own gap, m.
            rank: `(N,)` precedence, 0 first; None for the robots' order.
            frozen: `(N,)` robots that cannot be commanded; None for no robot.
            distances: `surroundings.distances` of earlier inputs on the same map, which saves most
                of the work; None to find them.

        Raises:
            InputError: Arrays that do not fit together, or are not finite.
        """
        given = {"poses": poses, "velocities": velocities, "commands": commands}
        arrays = [as_floats(value, key) for key, value in given.items()]
        for name, array in zip(given, arrays, strict=True):
            shape = (len(np.atleast_1d(arrays[0])), 3)
            if array.shape != shape or not np.isfinite(array).all():
                raise InputError("expected finite (N, 3) numbers, N the same for all", key=name)
        local, moving, wanted = arrays
        count, origin = len(local), map.origin
        order = np.arange(count) if rank is None else np.array(rank, dtype=np.int64)
        still = np.zeros(count, bool) if frozen is None else np.array(frozen, dtype=bool)
        if sorted(order.tolist()) != list(range(count)):
            raise InputError(f"expected each of 0..{count - 1} once", key="rank")
        if still.shape != (count,):
            raise InputError(f"expected {count} truth values", key="frozen")
        local[:, :2] = inverse_transform_points(origin, local[:, :2])
        local[:, 2] -= origin[2]
        moving[:, :2] = moving[:, :2] @ rotation(origin[2])
        c, s = np.cos(local[:, 2]), np.sin(local[:, 2])
        x, y = wanted[:, 0].copy(), wanted[:, 1].copy()
        wanted[:, 0], wanted[:, 1] = c * x - s * y, s * x + c * y
        if distances is None:
            distances = surface_distance(map.occupied, map.resolution)
        return cls(
            TeamState(
                local, moving, wanted, order, still, np.zeros(count, bool),
                np.full(count, float(clearance)),
            ),
            Surroundings(distances, map.resolution, *obstacle_boxes(obstacles, origin)),
        )  # fmt: skip


class SafetyFilter:
    """Filters the commands of one team. See the module for what it guarantees.

    Args:
        model: The robots' model or its name.
        period: Seconds per cycle.
        expected: Of localisation and radio; the less they can be relied on, the wider the gaps.

    Attributes:
        parameters: Footprint, gaps of the two stages, and what is predicted.
    """

    def __init__(
        self, model: str | RobotModel, period: float, expected: Imperfections | None = None
    ) -> None:
        if not (math.isfinite(period) and period > 0.0):
            raise InputError(f"expected a period above 0 s, got {period!r}", key="period")
        model = robot_model(model) if isinstance(model, str) else model
        expected = expected or Imperfections()
        error = expected.error(period, model.length / 2.0)
        # A command stays in effect until the next one arrives.
        period *= expected.held(period)
        substeps = max(1, int(np.ceil(period / 0.025 - 1e-9)))
        stop = max(
            model.max_speed_x / model.max_acceleration,
            model.max_yaw_rate / model.max_yaw_acceleration,
        )
        steps = substeps + int(np.ceil(stop / (period / substeps))) + 1
        self.parameters = FilterParameters(
            Footprint.of(model.length, model.width, *_DISCS),
            _widened(AIMED, error),
            _widened(INSISTED, error),
            Horizon(limits_of(model), 0.6 * model.max_acceleration, period, substeps, steps),
        )

    def in_body(self, poses: Array, wanted: Array) -> Array:
        """Wanted velocities `(N, 3)` as body-frame commands, unfiltered but within the limits."""
        return to_body(wanted, poses[:, 2], self.parameters.horizon.limits)

    def apply(self, inputs: SafetyInputs) -> tuple[Array, NDArray[np.int64]]:
        """Safe commands near the wanted ones.

        Returns:
            Commands `(N, 3)` in the body frame: m/s, m/s, rad/s; and `(N,)` how far each had to
            step down: 0 for the filtered command itself, 4 for a stop.
        """
        team, surroundings = inputs
        count = len(team.poses)
        ratio = min(_PRECEDENCE, _WEIGHTS ** (1.0 / max(count - 1, 1)))
        weights = np.where(team.frozen, 1e9, ratio ** (count - 1.0 - team.rank))
        team = team._replace(clearances=np.where(team.frozen, 0.0, team.clearances))
        return safe_commands(team, weights, surroundings, self.parameters)


def _widened(margins: Margins, error: float) -> Margins:
    """Gaps for robots whose places are known to `error` m each."""
    pair = math.sqrt(2.0) * error
    return Margins(margins.obstacle + error, margins.footprint + pair, margins.centres + pair)
