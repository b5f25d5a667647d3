"""The order in which robots pass where their paths meet, as a plan has it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cavalcade.execution import _precedence
from cavalcade.execution._precedence import Braking, Progress
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory, team_poses
from cavalcade.robots import RobotModel

STEP = 0.025
"""Side of the cells, s."""

MARGIN = 0.10
"""Gap that is kept between bodies whose order is enforced, m: each may be half of it off."""

SLACK = 2
"""Robots that the plan keeps side by side may be this many cells out of step."""

_STILL = 1e-9


class Precedence:
    """What robots must wait for if each follows its trajectory at a pace of its own.

    Let s_k be the plan time up to which robot k has come. The plan itself is the diagonal of the
    square of all (s_i, s_j); cells of it are blocked in which the bodies would come within
    `margin` of each other. Where (a, b) with a < b is blocked, i passes first in the plan: j
    must stay before b until i has passed a. The paths (s_i, s_j) that keep to this for all cells
    go round each blocked region on the side of the diagonal (Čáp, Gregoire, Frazzoli 2016;
    the same order between events as in Hönig et al. 2019), so no robot enters a shared region
    before its turn, and none meets another however late any of them is.

    It cannot come to a standstill while there is a robot that can move. Let j be the one with
    the least progress. A cell holds it up only if some i has not passed a yet: then
    b > a >= s_i >= s_j, in whole cells, so that the place where j must stop lies before it
    and j may go on at least to the end of the cell that i is in. When all are in one cell all
    may leave it. So the least progress grows until the plan ends.

    A cell in which one of the two has stood since the diagonal is no reason to wait: the plan has
    just that meeting. Near the diagonal, where plans bring bodies closer than `margin`, only what
    is closer than the plan is blocked; where that is so both ways, the two keep in step. They may
    rely on each other up to `reach`, the plan time that a robot needs to stop, s.
    """

    def __init__(
        self,
        paths: Sequence[Trajectory],
        models: Sequence[RobotModel],
        reach: float,
        margin: float = MARGIN,
        step: float = STEP,
    ) -> None:
        end = max((path.duration for path in paths), default=0.0)
        count = math.ceil(end / step - 1e-9) + 2
        self.step = step
        poses = np.ascontiguousarray(
            team_poses(paths, step * np.arange(count, dtype=float)).transpose(1, 0, 2)
        )  # fmt: skip
        self.band = math.ceil(reach / step) + 2
        bodies = np.array([model.body for model in models]).reshape(-1, 3)
        self.near, self.far = _precedence.first_cells(
            poses, _spread(poses, models), _rests(poses), bodies, margin, self.band
        )
        backwards = np.minimum.accumulate(self.near[..., ::-1], axis=-1)
        self._order = _precedence.Order(
            self.near, np.ascontiguousarray(backwards[..., ::-1]), self.far, step, SLACK
        )

    def bounds(self, progress: Array) -> Array:
        """`(N,)` plan times beyond which nobody may go while the others are at `progress` `(N,)`.

        inf for who need not wait.
        """
        return np.asarray(_precedence.strict_bounds(self._order, np.asarray(progress, float)))

    def rates(self, progress: Progress, wanted: Array, braking: Braking) -> Array:
        """`(N,)` rates of progress for the next cycle; see `_precedence.allowed_rates`."""
        return np.asarray(_precedence.allowed_rates(self._order, progress, wanted, braking))


def reach_of(model: RobotModel) -> float:
    """Distance of the farthest point of a body from the axis it turns about, m; 0 for a disc."""
    return 0.0 if model.round else 0.5 * math.hypot(model.length, model.width)


def _spread(poses: Array, models: Sequence[RobotModel]) -> Array:
    """`(N, K)` m, see `_precedence.first_cells`."""
    spread = np.zeros(poses.shape[:2])
    for robot, model in enumerate(models):
        change = np.diff(poses[robot], axis=0)
        moved = np.hypot(change[:, 0], change[:, 1]) + reach_of(model) * np.abs(change[:, 2])
        spread[robot, :-1] = 0.5 * moved
        spread[robot, 1:] = np.maximum(spread[robot, 1:], 0.5 * moved)
    return spread


def _rests(poses: Array) -> NDArray[np.int64]:
    """`(N, K)` the last sample of the rest that each sample is part of, itself where it moves."""
    robots, count = poses.shape[:2]
    rests = np.tile(np.arange(count), (robots, 1))
    still = np.abs(np.diff(poses, axis=1)).max(axis=2) <= _STILL
    for k in range(count - 2, -1, -1):
        rests[:, k] = np.where(still[:, k], rests[:, k + 1], k)
    return rests
