"""From desired to wanted velocities: springs, avoidance, limits, yaw (steps 9 to 12)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation._shaping import add_springs, avoid_obstacles, limit_speeds
from cavalcade.formation.cycle import Cycle, path_heading
from cavalcade.formation.settings import FormationSettings, Variant
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

_TURN_GAIN = 2.5  # rad/s of yaw rate per rad of heading error
_NEAR = 0.30  # m from its slot at which a robot turns to the goal's heading
_NARROW = 0.30  # W_B below which a robot trusts its path and turns to the path ahead
_BRISK = 0.6  # of d_slowdown: where our variant slows down before its slots
_DOCKING = 0.60  # m from its final slot at which a robot goes straight for it
_REST = (0.015, 0.085)  # m: a robot this near to its slot rests, and until it is this far off
_REST_TURN = (0.03, 0.12)  # rad: the same for the goal's heading
_HELD_BACK = 0.5  # of the top speed: what springs may take from a robot on its path


class Shaper:
    """Applies springs, avoidance layer and limits, as the variant has them.

    It remembers what dampers need.
    """

    def __init__(
        self, variant: Variant, settings: FormationSettings, model: RobotModel, period: float
    ) -> None:
        self._variant = variant
        self._settings = settings
        self._period = period
        self.top = min(settings.v_max_x, model.max_speed_x)
        slowdown = settings.d_slowdown * (_BRISK if variant.improved else 1.0)
        across = min(settings.v_max_y, model.max_speed_y)
        # Whole numbers would make the kernels compile once more.
        self._limits = (float(self.top), float(across), float(settings.v_min), float(slowdown))
        self.turn = model.max_yaw_rate
        self.reset()

    def reset(self) -> None:
        """Forget what is remembered from cycle to cycle."""
        self.forget_springs()
        self._resting: NDArray[np.bool_] | None = None
        self._turned: NDArray[np.bool_] | None = None

    def forget_springs(self) -> None:
        """Forget the springs' lengths: the next cycle does not follow the last one."""
        self._lengths: Array = np.empty(0)
        self._joined: NDArray[np.int64] = np.empty((0, 2), np.int64)

    def shape(self, cycle: Cycle, desired: Array, springs: bool) -> None:
        """Set the velocity of a cycle with roles and `away` from a desired one `(N, 2)`, m/s.

        With `springs` they act, if the variant has any.
        """
        settings, maps, points = self._settings, cycle.plan.maps, cycle.points
        velocity = desired.copy()
        w = maps.speed_at(points)
        if springs and self._variant.springs and len(cycle.team.ends):
            self._add_springs(cycle, velocity)
            if self._variant.improved:
                _spare_pace(velocity, desired, _HELD_BACK * self.top)
        else:
            self.forget_springs()
        if self._variant.avoidance:
            # The paper filters the whole velocity, also what leads along the path into a narrow
            # place or to a slot beside an obstacle. There our variant trusts the path and
            # filters only what springs add to it.
            alone = not springs or len(cycle.team.ends) == 0
            trusted = (w < _NARROW) | (cycle.away < _DOCKING) | alone
            kept = np.where(trusted[:, None] & self._variant.improved, desired, 0.0)
            velocity -= kept
            avoid_obstacles(
                velocity, points, maps.speed_b, maps.cell, settings.d_safe_b,
                settings.w_min_avoid,
            )  # fmt: skip
            velocity += kept
        yaw = np.ascontiguousarray(cycle.poses[:, 2])
        limit_speeds(velocity, yaw, w, cycle.away, self._limits)
        velocity[~cycle.team.present] = 0.0
        if self._variant.improved:
            # Noise on the poses must not keep a robot in its slot busy.
            self._resting = _held(self._resting, cycle.away, _REST)
            velocity[self._resting] = 0.0
        cycle.velocity = velocity

    def yaw_rates(self, cycle: Cycle) -> Array:
        """Turn `(N,)` rad/s to the direction of motion; near a final slot, to the goal's heading.

        In narrow ground our variant turns to the path ahead instead: what springs and avoidance
        make of the velocity would turn a body across it.
        """
        aim = cycle.headings()
        if self._variant.improved:
            w = cycle.plan.maps.speed_at(cycle.points)
            for k in cycle.active[w[cycle.active] < _NARROW]:
                ahead = path_heading(cycle.paths[k])
                if ahead is not None:
                    aim[k] = ahead
        if cycle.final:
            aim = np.where(cycle.away < _NEAR, cycle.plan.pose[2], aim)
            aim = np.where(np.isnan(cycle.facing), aim, cycle.facing)
        rate = _TURN_GAIN * wrap_angle(aim - cycle.poses[:, 2])
        rate[~cycle.team.present] = 0.0
        if self._variant.improved and cycle.final:
            off = np.abs(wrap_angle(cycle.plan.pose[2] - cycle.poses[:, 2]))
            off = np.where(cycle.away < _NEAR, off, np.inf)
            self._turned = _held(self._turned, off, _REST_TURN)
            rate[self._turned] = 0.0
        return np.clip(rate, -self.turn, self.turn)

    def _add_springs(self, cycle: Cycle, velocity: Array) -> None:
        team = cycle.team
        pairs = team.pairs(cycle.roles)
        previous = self._lengths
        if pairs.shape != self._joined.shape:
            previous = np.full(len(pairs), np.nan)
        elif (pairs != self._joined).any():
            previous = np.where((pairs == self._joined).all(axis=1), previous, np.nan)
        self._lengths = add_springs(
            velocity, cycle.points, pairs, team.springs, previous, self._period
        )
        self._joined = pairs


def _held(
    before: NDArray[np.bool_] | None, error: Array, bounds: tuple[float, float]
) -> NDArray[np.bool_]:
    """Hysteresis `(N,)`: true from an error below the first bound until one above the second."""
    if before is None or len(before) != len(error):
        return error < bounds[0]
    return (error < bounds[0]) | (before & (error < bounds[1]))


def _spare_pace(velocity: Array, desired: Array, most: float) -> None:
    """Let springs slow a robot on its path by `most` m/s at the utmost; what turns it stays."""
    pace = np.hypot(desired[:, 0], desired[:, 1])
    course = desired / np.maximum(pace, 1e-9)[:, None]
    back = -((velocity - desired) * course).sum(axis=1)
    velocity += np.maximum(back - most, 0.0)[:, None] * course
