"""Robots of a fleet in physics that are handed over to leap."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco._postures import planar_poses
from cavalcade.fleet.protocol import LeapRequest
from cavalcade.geometry import Array
from cavalcade.locomotion.approach import DONE, FAILED, LEAP, WALK, LeapPilot
from cavalcade.locomotion.control import LegControl
from cavalcade.locomotion.crossing import Heights

PERIOD = 0.02
"""Time between two decisions of a pilot, s."""

APPROACH = 1.5
"""How long before a take-off robots are handed over, s of planned time."""


class Leapers:
    """The pilots of those robots that were handed over.

    `fronts` `(N,)` are how far front hips are ahead of the trunks' origins, m; without `heights`
    the ground is level.
    """

    def __init__(self, control: LegControl, fronts: Array, heights: Heights | None) -> None:
        self._control, self._fronts, self._heights = control, fronts, heights
        self._pilots: dict[int, LeapPilot] = {}
        self._next = -math.inf
        self._orders = np.zeros((control.size, 3))
        self.failed = np.zeros(control.size, dtype=bool)

    @property
    def leaping(self) -> NDArray[np.bool_]:
        """`(N,)` who was handed over and has not been given back."""
        held = np.zeros(self._control.size, dtype=bool)
        held[list(self._pilots)] = True
        return held

    def take(self, robot: int, request: LeapRequest) -> None:
        """Take a robot over."""
        if not 0 <= robot < self._control.size:
            raise InputError(f"expected a robot from 0 to {self._control.size - 1}", key="robot")
        if robot in self._pilots:
            raise InputError(f"robot {robot} is leaping already", key="robot")
        self.failed[robot] = False
        front = float(self._fronts[robot])
        self._pilots[robot] = LeapPilot(
            request.take_off, request.landed, request.edges, self._heights, front
        )

    def due(self, now: float) -> bool:
        """Whether pilots are to decide now."""
        if not self._pilots or now < self._next - 1e-9:
            return False
        self._next = now + PERIOD
        return True

    def overrule(self, commands: Array) -> Array:
        """Commands `(N, 3)` with those of the pilots in their robots' rows."""
        mine = self.leaping
        return np.where(mine[:, None], self._orders, commands) if mine.any() else commands

    def steer(self, now: float, qpos: Array) -> NDArray[np.bool_]:
        """Let the pilots decide; `overrule` says what their robots are to do then.

        `qpos` is `(N, 19)` as measured; returns `(N,)` whose pilots decided.
        """
        steered = self.leaping
        control, poses = self._control, planar_poses(qpos)
        standing, leaps, fallen = control.standing, control.leaping, control.fallen
        for robot, pilot in list(self._pilots.items()):
            order = FAILED
            if not fallen[robot] and not (pilot.leapt and control.leap_failed[robot]):
                order = pilot.step(
                    now, poses[robot], control.feet[robot], standing[robot], leaps[robot]
                )
            self._orders[robot] = pilot.velocity if order == WALK else 0.0
            if order == LEAP and pilot.manoeuvre is not None:
                try:
                    control.leap(robot, pilot.manoeuvre)
                except InputError:
                    order = FAILED  # too far or too high: it stays where it is
            if order in (DONE, FAILED):
                self.failed[robot] = order == FAILED
                del self._pilots[robot]
        return steered
