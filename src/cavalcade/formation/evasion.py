"""Stepping aside in time for obstacles that move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.escaping import STEPS, Surroundings, Way, WayFinder
from cavalcade.formation.ground import Ground
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel

_HORIZON = 5.0  # s ahead of an obstacle within which its swept way is left
_CLEAR = 0.55  # m between a robot's centre and the swept way of an obstacle
_WAIT = 0.3  # m beside that in which robots do not come nearer


@dataclass(frozen=True)
class _Strip:
    """The strip that an obstacle sweeps, as a robot in front of it sees it; m and s."""

    along: Array
    across: Array
    beside: float
    needed: float
    arrival: float

    @property
    def out(self) -> Array:
        """Straight to the side on which the strip is left sooner."""
        return self.across if self.beside >= 0.0 else -self.across


class Evasion:
    """Takes robots out of the way of what moves. It remembers which way each of them goes.

    Args:
        model: The robots'.
        top: Speed to command, m/s.
        error: To which robots' places are known, m.
    """

    def __init__(self, model: RobotModel, top: float, error: float = 0.0) -> None:
        self._finder = WayFinder(model, top, error)
        self._ways: dict[int, Way] = {}

    def forget(self) -> None:
        """Choose all ways anew."""
        self._ways.clear()

    def apply(
        self,
        wanted: Array,
        poses: Array,
        velocities: Array,
        active: NDArray[np.int64],
        movers: Array,
        speeds: Array,
        ground: Ground,
        radius: float,
    ) -> list[int]:
        """Replace the wanted velocities of robots that a moving obstacle is going to meet.

        Such a robot leaves the strip that the obstacle will sweep; one that would enter a strip
        in front of the obstacle waits. Straight out on the nearer side is the first choice, then
        the other side. Where something stands, comes or goes in the way there, it is the best of
        16 directions and several times, standing included, for which the robot stays clear.

        Args:
            wanted: `(N, 3)` velocities in the grid's frame, changed in place.
            poses, velocities: `(N, 3)`.
            active: Robots that take part.
            movers: `(M, 5)` pose, half length, half width.
            speeds: `(M, 2)` m/s.
            ground: The map.
            radius: Clearance of centres that is aimed at, m.

        Returns:
            The robots that get out of the way, the most urgent first: others give way to them.
        """
        met: dict[int, _Strip] = {}
        for k in active:
            strips = _strips(poses[k, :2], movers, speeds)
            inside = [strip for strip in strips if abs(strip.beside) < strip.needed]
            if inside:
                met[int(k)] = min(inside, key=lambda strip: strip.arrival)
                continue
            for strip in strips:
                closing = -float(wanted[k, :2] @ strip.out)
                if abs(strip.beside) < strip.needed + _WAIT and closing > 0.0:
                    wanted[k, :2] += closing * strip.out
        self._ways = {k: way for k, way in self._ways.items() if k in met}
        order = sorted(met, key=lambda k: (met[k].arrival, k))
        plans = np.repeat(poses[:, None], STEPS, axis=1)  # where each robot is going to be
        stays = np.ones(len(poses), np.bool_)
        stays[active] = False
        for k in order:
            # Others stand first; if that leaves no way, as if those that can will make room.
            others = np.arange(len(poses)) != k
            scenes = [
                Surroundings(movers, speeds, plans[who], ground.distance, ground.cell, radius)
                for who in (others, others & stays)
            ]
            way = self._way(k, poses[k], velocities[k], met[k], scenes)
            self._ways[k] = way
            wanted[k] = self._finder.command(way, poses[k, 2])
            plans[k] = self._finder.poses(way, poses[k], velocities[k])
            stays[k] = True
        return order

    def _way(
        self, robot: int, pose: Array, velocity: Array, strip: _Strip, scenes: list[Surroundings]
    ) -> Way:
        at_hand = [Way(strip.out, True), Way(-strip.out, True)]
        before = self._ways.get(robot)
        if before is not None and before.steps == 0:
            before = None
        best, latest = at_hand[0], -1.0
        for around in scenes:
            good = self._finder.at_hand(at_hand, before, pose, velocity, around)
            if good is not None:
                return good
            way, hit = self._finder.of_all(strip.out, strip.along, before, pose, velocity, around)
            if hit > latest:
                best, latest = way, hit
            if np.isposinf(latest):
                break
        return best


def _strips(point: Array, movers: Array, speeds: Array) -> list[_Strip]:
    """The strips of all obstacles that sweep past the height of a point within the horizon."""
    found = []
    for box, speed in zip(movers, speeds, strict=True):
        pace = float(np.hypot(*speed))
        if pace < 1e-6:
            continue
        along = speed / pace
        across = np.array([-along[1], along[0]])
        axes = np.array([[np.cos(box[2]), np.sin(box[2])], [-np.sin(box[2]), np.cos(box[2])]])
        half_across = float(np.abs(axes @ across) @ box[3:5])
        half_along = float(np.abs(axes @ along) @ box[3:5])
        offset = point - box[:2]
        ahead, beside = float(offset @ along), float(offset @ across)
        if -half_along - 0.4 < ahead < half_along + 0.4 + pace * _HORIZON:
            arrival = (ahead - half_along) / pace
            found.append(_Strip(along, across, beside, half_across + _CLEAR, arrival))
    return found
