"""The last filter: commands that keep oriented footprints apart and off obstacles.

Two stages. The first changes the wanted velocities as little as possible (weighted least
squares) so that no robot closes in on anything faster than it can brake for. The second rolls
every command out for one cycle followed by a full stop and lets robots step down until that is
clear, so that stopping stays possible in every cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation._safety import certify, least_change, to_body
from cavalcade.formation.estimation import Imperfections
from cavalcade.formation.goals import BodyCover
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import limits_of

_PRECEDENCE = 4.0  # how much dearer a robot's change is than that of the next in rank
_DISCS = (5, 2)  # columns and rows of the discs that stand for a body: its corners count
_WEIGHTS = 1000.0  # largest ratio of such weights in one team


@dataclass(frozen=True)
class Margins:
    """Gaps in m: what the first stage aims at, and what the second insists on.

    Those between centres are the paper's 0.60 m and a little more, the same for every model: what
    keeps bodies of any size apart are the gaps between footprints.
    """

    obstacle: float = 0.04
    footprint: float = 0.06
    centres: float = 0.62
    hard_obstacle: float = 0.01
    hard_footprint: float = 0.02
    hard_centres: float = 0.605

    def widened(self, error: float) -> Margins:
        """For robots whose places are known to `error` m each."""
        pair = math.sqrt(2.0) * error
        return Margins(
            self.obstacle + error,
            self.footprint + pair,
            self.centres + pair,
            self.hard_obstacle + error,
            self.hard_footprint + pair,
            self.hard_centres + pair,
        )


class SafetyFilter:
    """Filters the commands of one team.

    Args:
        model: The robots' size and limits.
        period: Seconds per cycle.
        expected: Of localisation and radio; the less they can be relied on, the wider the gaps.
    """

    def __init__(
        self, model: RobotModel, period: float, expected: Imperfections | None = None
    ) -> None:
        expected = expected or Imperfections()
        self._margins = Margins().widened(expected.error(period, model.length / 2.0))
        # A command stays in effect until the next one arrives.
        period *= expected.held(period)
        self._period = period
        self._limits = limits_of(model)
        self._half = np.array([model.length, model.width]) / 2.0
        cover = BodyCover.of(model.length, model.width, *_DISCS)
        self._discs, self._disc_radius = cover.offsets, cover.radius
        self._braking = 0.6 * model.max_acceleration
        self._substeps = max(1, int(np.ceil(period / 0.025 - 1e-9)))
        stop = max(
            model.max_speed_x / model.max_acceleration,
            model.max_yaw_rate / model.max_yaw_acceleration,
        )
        self._steps = self._substeps + int(np.ceil(stop / (period / self._substeps))) + 1

    def in_body(self, poses: Array, wanted: Array) -> Array:
        """Wanted velocities `(N, 3)` as body-frame commands, unfiltered but within the limits."""
        return to_body(wanted, poses[:, 2], self._limits[0], self._limits[1], self._limits[2])

    def apply(
        self,
        poses: Array,
        velocities: Array,
        wanted: Array,
        rank: NDArray[np.int64],
        frozen: NDArray[np.bool_],
        flees: NDArray[np.bool_],
        distance: Array,
        cell: float,
        clearances: Array,
        movers: Array,
        mover_speeds: Array,
    ) -> tuple[Array, NDArray[np.int64]]:
        """Safe commands near the wanted ones.

        Args:
            poses: `(N, 3)` in the grid's frame.
            velocities: `(N, 3)` present velocities, grid's frame: m/s, m/s, rad/s.
            wanted: `(N, 3)` wanted velocities, grid's frame.
            rank: `(N,)` precedence, 0 first: later robots give way.
            frozen: `(N,)` robots that cannot be commanded.
            flees: `(N,)` robots that get out of the way of what moves.
            distance: `(rows, cols)` distance to the nearest obstacle, m.
            cell: Cell size, m.
            clearances: `(N,)` what centres keep off obstacles, m.
            movers: `(M, 5)` moving obstacles: pose, half length, half width.
            mover_speeds: `(M, 2)` m/s.

        Returns:
            Commands `(N, 3)` in the body frame, and `(N,)` how far each had to step down: 0 for
            the filtered command itself, 4 for a stop.
        """
        m = self._margins
        count = len(poses)
        sizes = np.repeat(self._half[None], count, axis=0)
        ratio = min(_PRECEDENCE, _WEIGHTS ** (1.0 / max(count - 1, 1)))
        weights = np.where(frozen, 1e9, ratio ** (count - 1.0 - rank))
        keep = np.where(frozen, 0.0, clearances)
        u = least_change(
            poses, wanted, weights, sizes, movers, mover_speeds, self._discs, self._disc_radius,
            np.where(keep > 0.0, keep + 0.01, 0.0), np.array([m.obstacle, m.footprint, m.centres]),
            self._braking, self._period, distance, cell,
        )  # fmt: skip
        commands = self.in_body(poses, u)
        commands[frozen] = 0.0
        return certify(
            poses, velocities, commands, rank, frozen, flees, self._limits, self._period,
            self._substeps, self._steps, sizes, movers, mover_speeds, self._discs,
            self._disc_radius, keep,
            np.array([m.hard_obstacle, m.hard_footprint, m.hard_centres]), distance, cell,
        )  # fmt: skip
