"""Which way a robot gets out of the path of what moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation._escape import STEP, judge_ways, roll, turn_rate
from cavalcade.formation.goals import BodyCover
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import limits_of

STEPS = 80  # for which ways are judged
_DURATIONS = np.array([0, 5, 10, 15, 20, 25, 30, 40, 50])  # steps for which a way may be gone
# m: to what stands, to robots, between their centres, to what moves: at least, and aimed at.
_GAPS = np.array([0.02, 0.03, 0.61, 0.02, 0.10])
_DEARER = 20.0  # s that a way may take longer for 1 m less behind what is aimed at
_GOOD = 0.01  # m that a way at hand may stay behind before all others are looked at
_FAIR = 0.05  # m that the way a robot goes already may stay behind before that
_LATER = 0.15  # s by which a hit has to be later to count as later
_KEPT = 0.5  # s that the way a robot goes may take longer than another
_TILTS = np.radians([0.0, 22.5, -22.5, 45.0, -45.0, 67.5, -67.5])


@dataclass(frozen=True)
class Way:
    """To go in a direction for some steps and stand then.

    Attributes:
        direction: `(2,)` of unit length.
        turning: Whether the body turns its longer axis, front or rear, into it.
        steps: Of `STEP` s.
    """

    direction: Array
    turning: bool
    steps: int = 0


@dataclass(frozen=True)
class Surroundings:
    """What ways are judged by, in the grid's frame.

    Attributes:
        movers, speeds: `(M, 5)` and `(M, 2)` what moves: pose, half length, half width; m/s.
        others: `(K, STEPS, 3)` where other robots are going to be.
        distance, cell: Distance map and its cell size, m.
        radius: Clearance of the centre that is aimed at in the end, m.
    """

    movers: Array
    speeds: Array
    others: Array
    distance: Array
    cell: float
    radius: float


class WayFinder:
    """Finds ways for robots of one model.

    Args:
        model: The robots'.
        top: Speed to command, m/s.
        error: To which robots' places are known, m: gaps are that much wider.
    """

    def __init__(self, model: RobotModel, top: float, error: float = 0.0) -> None:
        self._limits = limits_of(model)
        self._half = np.array([model.length, model.width]) / 2.0
        self._cover = BodyCover.of(model.length, model.width, 5, 2)
        self._top = top
        both = np.sqrt(2.0)
        self._gaps = _GAPS + error * np.array([1.0, both, both, 1.0, 1.0])
        self._get_ready()

    def at_hand(
        self,
        ways: list[Way],
        before: Way | None,
        pose: Array,
        velocity: Array,
        around: Surroundings,
    ) -> Way | None:
        """The way that the robot goes, or the first of some others that is good; None if none is.

        Each is gone for the least time that does.
        """
        allowed = np.full(len(ways), _GOOD)
        if before is not None:
            ways, allowed = [before, *ways], np.append(_FAIR, allowed)
        hits, short = self._judged(ways, pose, velocity, around)
        good = np.isposinf(hits[:, 1:]) & (short[:, 1:] <= allowed[:, None])
        for way, each in zip(ways, good, strict=True):
            if each.any():
                steps = int(_DURATIONS[1 + int(np.argmax(each))])
                return Way(way.direction, way.turning, steps)
        return None

    def of_all(
        self,
        across: Array,
        along: Array,
        before: Way | None,
        pose: Array,
        velocity: Array,
        around: Surroundings,
    ) -> tuple[Way, float]:
        """The best of 16 directions and all times, standing included, and when it is hit, s.

        Args:
            across, along: Unit vectors; at equal cost directions near the first are preferred.
            before: The way that the robot goes, which is kept unless another is clearly better.
            pose, velocity: `(3,)` of the robot.
            around: What there is.
        """
        directions = [
            np.cos(tilt) * side * across + np.sin(tilt) * along
            for tilt in _TILTS
            for side in (1.0, -1.0)
        ]
        ways = [Way(d, turn) for turn in (True, False) for d in (*directions, along, -along)]
        if before is not None:
            ways.append(before)
        hits, short = self._judged(ways, pose, velocity, around)
        latest = float(hits.max())
        cost = np.where(hits >= latest - _LATER, _DURATIONS * STEP + _DEARER * short, np.inf)
        if before is not None:
            cost[-1] -= _KEPT
        k, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        return Way(ways[k].direction, ways[k].turning, int(_DURATIONS[j])), latest

    def command(self, way: Way, yaw: float) -> Array:
        """Velocity `(3,)` in the grid's frame: m/s, m/s, rad/s."""
        if way.steps == 0:
            return np.zeros(3)
        x, y = way.direction
        rate = turn_rate(yaw, x, y, self._limits[2]) if way.turning else 0.0
        return np.array([self._top * x, self._top * y, rate])

    def poses(self, way: Way, pose: Array, velocity: Array) -> Array:
        """`(STEPS, 3)` on that way."""
        states = np.empty((STEPS, 6))
        x, y = way.direction
        roll(pose, velocity, x, y, way.turning, self._top, way.steps, self._limits, states)
        return states[:, :3]

    def _get_ready(self) -> None:
        """Load or compile the kernels: no cycle may wait for that when something sets out."""
        nothing = Surroundings(
            np.empty((0, 5)), np.empty((0, 2)), np.empty((0, STEPS, 3)), np.ones((2, 2)), 1.0, 0.0
        )
        rest, way = np.zeros(3), Way(np.array([1.0, 0.0]), True, 1)
        self._judged([way], rest, rest, nothing)
        self.command(way, 0.0)
        self.poses(way, rest, rest)

    def _judged(
        self, ways: list[Way], pose: Array, velocity: Array, around: Surroundings
    ) -> tuple[Array, Array]:
        turning: NDArray[np.bool_] = np.array([way.turning for way in ways])
        hits, short = judge_ways(
            pose, velocity, np.array([way.direction for way in ways]), turning, _DURATIONS,
            self._top, self._limits, self._half, around.movers, around.speeds, around.others,
            self._cover.offsets, self._cover.radius, self._gaps, around.radius, around.distance,
            around.cell, STEPS,
        )  # fmt: skip
        return hits, short
