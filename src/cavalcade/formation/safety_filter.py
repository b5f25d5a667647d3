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
from cavalcade.geometry import Array, inverse_transform_points, rotation
from cavalcade.robots import RobotModel, robot_model
from cavalcade.robots.motion import check_holonomic, limits_of
from cavalcade.values import instance_of, instances_of, number_array, number_in
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
_LARGEST = 1e7  # m, m/s: what arithmetic takes
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
        origin = instance_of(map, OccupancyMap, "map").origin
        local = number_array(poses, "poses", (None, 3), "(N, 3) poses")
        count = len(local)
        moving, wanted = (
            number_array(values, name, (count, 3), f"({count}, 3) velocities")
            for name, values in (("velocities", velocities), ("commands", commands))
        )
        obstacles = instances_of(obstacles, DynamicObstacle, "obstacles")
        clearance = number_in(clearance, "clearance", 0.0)
        order = np.arange(count)
        if rank is not None:
            ranks = number_array(rank, "rank", (count,), f"each of 0..{count - 1} once")
            if sorted(ranks.tolist()) != order.tolist():
                raise InputError(f"expected each of 0..{count - 1} once", key="rank")
            order = ranks.astype(np.int64)
        still = np.zeros(count, bool)
        if frozen is not None:
            told = np.ma.filled(np.asanyarray(frozen), True)
            if told.shape != (count,) or told.dtype.kind not in "biu":
                raise InputError(f"expected {count} truth values", key="frozen")
            still = told.astype(bool)
        local[:, :2] = inverse_transform_points(origin, local[:, :2])
        local[:, 2] -= origin[2]
        moving[:, :2] = moving[:, :2] @ rotation(origin[2])
        c, s = np.cos(local[:, 2]), np.sin(local[:, 2])
        x, y = wanted[:, 0].copy(), wanted[:, 1].copy()
        wanted[:, 0], wanted[:, 1] = c * x - s * y, s * x + c * y
        if distances is None:
            distances = surface_distance(map.occupied, map.resolution)
        _check(distances, None, float, "distances")
        if distances.shape != map.grid.shape or np.isnan(distances).any():
            raise InputError(f"expected {map.grid.shape} distances in m", key="distances")
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
        period: Seconds per cycle, 0.001 to 10.
        expected: Of localisation and radio; the less they can be relied on, the wider the gaps.

    Attributes:
        parameters: Footprint, gaps of the two stages, and what is predicted.
    """

    def __init__(
        self, model: str | RobotModel, period: float, expected: Imperfections | None = None
    ) -> None:
        period = number_in(period, "period", 1e-3, 10.0, "s")
        model = robot_model(model)
        check_holonomic(model)
        expected = Imperfections() if expected is None else expected
        instance_of(expected, Imperfections, "expected")
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
        poses = number_array(poses, "poses", (None, 3), "(N, 3) poses", _LARGEST)
        shape = (len(poses), 3)
        wanted = number_array(wanted, "wanted", shape, f"{shape} velocities", _LARGEST)
        return to_body(wanted, poses[:, 2], self.parameters.horizon.limits)

    def apply(self, inputs: SafetyInputs) -> tuple[Array, NDArray[np.int64]]:
        """Safe commands near the wanted ones.

        Returns:
            Commands `(N, 3)` in the body frame: m/s, m/s, rad/s; and `(N,)` how far each had to
            step down: 0 for the filtered command itself, 4 for a stop.

        Raises:
            InputError: Inputs that do not fit together, or are not finite.
        """
        _check_inputs(inputs)
        return filtered(inputs, self.parameters)


def filtered(inputs: SafetyInputs, parameters: FilterParameters) -> tuple[Array, NDArray[np.int64]]:
    """What `SafetyFilter.apply` returns, of inputs that are known to be sound."""
    team, surroundings = inputs
    count = len(team.poses)
    ratio = min(_PRECEDENCE, _WEIGHTS ** (1.0 / max(count - 1, 1)))
    weights = np.where(team.frozen, 1e9, ratio ** (count - 1.0 - team.rank))
    team = team._replace(clearances=np.where(team.frozen, 0.0, team.clearances))
    return safe_commands(team, weights, surroundings, parameters)


def _check_inputs(inputs: SafetyInputs) -> None:
    """Refuse what the kernels cannot take; what `SafetyInputs.of` makes passes.

    Raises:
        InputError: One line with the name of the part.
    """
    instance_of(inputs, SafetyInputs, "inputs")
    team, around = inputs
    instance_of(team, TeamState, "inputs.team")
    instance_of(around, Surroundings, "inputs.surroundings")
    count, moving = np.size(team.rank), np.shape(around.poses)[:1]
    for name in ("poses", "velocities", "wanted"):
        _check(getattr(team, name), (count, 3), float, name)
    _check(team.clearances, (count,), float, "clearances")
    for name in ("frozen", "evading"):
        _check(getattr(team, name), (count,), bool, name)
    _check(team.rank, (count,), int, "rank")
    if sorted(team.rank.tolist()) != list(range(count)):
        raise InputError(f"expected each of 0..{count - 1} once", key="rank")
    for name, width in (("poses", 3), ("half", 2), ("velocities", 2)):
        _check(getattr(around, name), (*moving, width), float, f"surroundings.{name}")
    _check(around.distances, None, float, "surroundings.distances")
    number_in(around.cell, "surroundings.cell", 1e-4, 1e4, "m")


def _check(array: Array, shape: tuple[int, ...] | None, kind: type, key: str) -> None:
    """Refuse what is no array of a shape and kind, and numbers beyond `_LARGEST`.

    Without a shape it is a grid, of which the numbers are not looked at.
    """
    right = type(array) is np.ndarray and array.dtype == kind and array.flags.c_contiguous
    if shape is None:
        if not (right and array.ndim == 2 and array.size):
            raise InputError(f"expected (rows, cols) of {kind.__name__}", key=key)
        return
    if not (right and array.shape == shape):
        raise InputError(f"expected {kind.__name__} of shape {shape}", key=key)
    if kind is float and not (np.abs(array) <= _LARGEST).all():
        raise InputError(f"expected finite numbers within ±{_LARGEST:g}", key=key)


def _widened(margins: Margins, error: float) -> Margins:
    """Gaps for robots whose places are known to `error` m each."""
    pair = math.sqrt(2.0) * error
    return Margins(margins.obstacle + error, margins.footprint + pair, margins.centres + pair)
