"""Getting out of the way of dynamic obstacles in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation._clearance import Footprint, ObstacleBoxes, Surroundings
from cavalcade.formation._evasive_motion import (
    STEP,
    Drive,
    Gaps,
    Manoeuvres,
    judge_manoeuvres,
    roll_out_manoeuvre,
    turn_rate,
)
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel
from cavalcade.robots.motion import limits_of

STEPS = 80  # for which manoeuvres are judged
_DURATIONS = np.array([0, 5, 10, 15, 20, 25, 30, 40, 50])  # steps that a manoeuvre may take
_GAPS = Gaps(obstacle=0.02, footprint=0.03, centres=0.61, box=0.02, aimed=0.10)
_DEARER = 20.0  # s that a manoeuvre may take longer for 1 m less behind what is aimed at
_GOOD = 0.01  # m that a simple manoeuvre may stay behind before all others are looked at
_FAIR = 0.05  # m that the manoeuvre a robot is in already may stay behind before that
_LATER = 0.15  # s by which a hit has to be later to count as later
_KEPT = 0.5  # s that the manoeuvre a robot is in may take longer than another
_TILTS = np.radians([0.0, 22.5, -22.5, 45.0, -45.0, 67.5, -67.5])
_HORIZON = 5.0  # s ahead of an obstacle within which the strip it sweeps is left
_CLEAR = 0.55  # m between a robot's centre and that strip
_WAIT = 0.3  # m beside that in which robots do not come nearer


@dataclass(frozen=True)
class Manoeuvre:
    """To go in a direction for some steps and stand then.

    Attributes:
        direction: `(2,)` of unit length.
        turning: Whether the body turns its longer axis, front or rear, into it.
        steps: Of `STEP` s.
    """

    direction: Array
    turning: bool
    steps: int = 0


class Scene(NamedTuple):
    """What one robot's manoeuvres are judged by, in the grid's frame.

    Attributes:
        pose, velocity: `(3,)` of the robot.
        surroundings: Map and dynamic obstacles.
        others: `(K, STEPS, 3)` where other robots are going to be.
        clearance: Of the centre that is aimed at in the end, m.
    """

    pose: Array
    velocity: Array
    surroundings: Surroundings
    others: Array
    clearance: float


class ManoeuvreSearch:
    """Finds evasive manoeuvres for robots of one model at one speed to command, m/s.

    Their places are known to `error` m: gaps are that much wider.
    """

    def __init__(self, model: RobotModel, speed: float, error: float = 0.0) -> None:
        self._drive = Drive(limits_of(model), float(speed))
        self._footprint = Footprint.of(model.length, model.width, 5, 2)
        both = np.sqrt(2.0)
        wider = error * np.array([1.0, both, both, 1.0, 1.0])
        self._gaps = Gaps(*(np.array(_GAPS[:5]) + wider).tolist())

    def simple(
        self, simple: list[Manoeuvre], before: Manoeuvre | None, scene: Scene
    ) -> Manoeuvre | None:
        """The manoeuvre a robot is in, or the first of some others that is good; None if none is.

        Each takes the least time that does.
        """
        allowed = np.full(len(simple), _GOOD)
        if before is not None:
            simple, allowed = [before, *simple], np.append(_FAIR, allowed)
        hits, short = self._judged(simple, scene)
        good = np.isposinf(hits[:, 1:]) & (short[:, 1:] <= allowed[:, None])
        for manoeuvre, each in zip(simple, good, strict=True):
            if each.any():
                steps = int(_DURATIONS[1 + int(np.argmax(each))])
                return Manoeuvre(manoeuvre.direction, manoeuvre.turning, steps)
        return None

    def best(
        self, across: Array, along: Array, before: Manoeuvre | None, scene: Scene
    ) -> tuple[Manoeuvre, float]:
        """The best of 16 directions and all times, standing included, and when it is hit, s.

        At equal cost directions near the unit vector `across` are preferred. The manoeuvre
        `before`, which a robot is in, is kept unless another is clearly better.
        """
        directions = [
            np.cos(tilt) * side * across + np.sin(tilt) * along
            for tilt in _TILTS
            for side in (1.0, -1.0)
        ]
        tried = [Manoeuvre(d, turn) for turn in (True, False) for d in (*directions, along, -along)]
        if before is not None:
            tried.append(before)
        hits, short = self._judged(tried, scene)
        cost = np.where(hits >= hits.max() - _LATER, _DURATIONS * STEP + _DEARER * short, np.inf)
        if before is not None:
            cost[-1] -= _KEPT
        k, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        # Not the latest hit of all: the chosen one may be hit up to `_LATER` sooner.
        return Manoeuvre(tried[k].direction, tried[k].turning, int(_DURATIONS[j])), float(
            hits[k, j]
        )

    def command(self, manoeuvre: Manoeuvre, yaw: float) -> Array:
        """Velocity `(3,)` in the grid's frame: m/s, m/s, rad/s."""
        if manoeuvre.steps == 0:
            return np.zeros(3)
        x, y = manoeuvre.direction
        rate = 0.0
        if manoeuvre.turning:
            rate = turn_rate(yaw, x, y, self._drive.limits.max_yaw_rate)
        return np.array([self._drive.speed * x, self._drive.speed * y, rate])

    def poses(self, manoeuvre: Manoeuvre, pose: Array, velocity: Array) -> Array:
        """Poses `(STEPS, 3)` in that manoeuvre."""
        states = np.empty((STEPS, 6))
        roll_out_manoeuvre(
            pose, velocity, manoeuvre.direction, manoeuvre.turning, manoeuvre.steps, self._drive,
            states,
        )  # fmt: skip
        return states[:, :3]

    def get_ready(self) -> None:
        """Call all kernels once."""
        rest, one = np.zeros(3), Manoeuvre(np.array([1.0, 0.0]), True, 1)
        free = Surroundings(np.ones((2, 2)), 1.0, *ObstacleBoxes.none())
        self._judged([one], Scene(rest, rest, free, np.empty((0, STEPS, 3)), 0.0))
        self.command(one, 0.0)
        self.poses(one, rest, rest)

    def _judged(self, tried: list[Manoeuvre], scene: Scene) -> tuple[Array, Array]:
        """When each is hit and how far it stays behind, as `judge_manoeuvres` says."""
        candidates = Manoeuvres(
            np.array([manoeuvre.direction for manoeuvre in tried]),
            np.array([manoeuvre.turning for manoeuvre in tried]),
            _DURATIONS,
        )
        hits, short = judge_manoeuvres(
            scene.pose, scene.velocity, candidates, self._drive, self._footprint,
            scene.surroundings, scene.others, self._gaps._replace(clearance=scene.clearance),
        )  # fmt: skip
        return hits, short


@dataclass(frozen=True)
class _Strip:
    """The strip that an obstacle sweeps, as a robot in front of it sees it.

    Attributes:
        along, across: Unit vectors of its motion and to the left of it.
        beside: How far the robot is to the left of its middle, m.
        needed: From how far off its middle a robot is clear of it, m.
        arrival: When the obstacle gets to the robot's height, s.
    """

    along: Array
    across: Array
    beside: float
    needed: float
    arrival: float

    @property
    def out(self) -> Array:
        """Straight to the side on which the strip is left sooner."""
        return self.across if self.beside >= 0.0 else -self.across


class DynamicAvoidance:
    """Takes robots out of the way of what moves. It remembers each one's manoeuvre."""

    def __init__(self, model: RobotModel, speed: float, error: float = 0.0) -> None:
        self._search = ManoeuvreSearch(model, speed, error)
        self._manoeuvres: dict[int, Manoeuvre] = {}

    def get_ready(self) -> None:
        """Load or compile the kernels: no cycle may wait for that when something sets out."""
        self._search.get_ready()

    def forget(self) -> None:
        """Choose all manoeuvres anew."""
        self._manoeuvres.clear()

    def apply(
        self,
        wanted: Array,
        poses: Array,
        velocities: Array,
        active: NDArray[np.int64],
        surroundings: Surroundings,
        clearance: float,
    ) -> list[int]:
        """Replace the wanted velocities of robots that a dynamic obstacle is going to meet.

        Such a robot leaves the strip that the obstacle will sweep; one that would enter a strip
        in front of the obstacle waits. Straight out on the nearer side is the first choice, then
        the other side. Where something stands, comes or goes there, it is the best of 16
        directions and several times, standing included, for which the robot stays clear.

        Args:
            wanted: `(N, 3)` velocities in the grid's frame, changed in place.
            poses, velocities: `(N, 3)`.
            active: Robots that take part.
            surroundings: Map and dynamic obstacles.
            clearance: Of centres that is aimed at, m.

        Returns:
            The robots that get out of the way, the most urgent first: others give way to them.
        """
        met: dict[int, _Strip] = {}
        for k in active:
            strips = _strips(poses[k, :2], surroundings)
            inside = [strip for strip in strips if abs(strip.beside) < strip.needed]
            if inside:
                met[int(k)] = min(inside, key=lambda strip: strip.arrival)
                continue
            for strip in strips:
                closing = -float(wanted[k, :2] @ strip.out)
                if abs(strip.beside) < strip.needed + _WAIT and closing > 0.0:
                    wanted[k, :2] += closing * strip.out
        self._manoeuvres = {k: known for k, known in self._manoeuvres.items() if k in met}
        order = sorted(met, key=lambda k: (met[k].arrival, k))
        plans = np.repeat(poses[:, None], STEPS, axis=1)  # where each robot is going to be
        stays = np.ones(len(poses), np.bool_)
        stays[active] = False
        for k in order:
            # Others stand first; if that leaves nothing, as if those that can will make room.
            others = np.arange(len(poses)) != k
            scenes = [
                Scene(poses[k], velocities[k], surroundings, plans[who], clearance)
                for who in (others, others & stays)
            ]
            chosen = self._choose(k, met[k], scenes)
            self._manoeuvres[k] = chosen
            wanted[k] = self._search.command(chosen, poses[k, 2])
            plans[k] = self._search.poses(chosen, poses[k], velocities[k])
            stays[k] = True
        return order

    def _choose(self, robot: int, strip: _Strip, scenes: list[Scene]) -> Manoeuvre:
        """A simple manoeuvre in the first scene that has a good one, else the latest hit."""
        simple = [Manoeuvre(strip.out, True), Manoeuvre(-strip.out, True)]
        before = self._manoeuvres.get(robot)
        if before is not None and before.steps == 0:
            before = None
        best, latest = simple[0], -1.0
        for scene in scenes:
            good = self._search.simple(simple, before, scene)
            if good is not None:
                return good
            found, hit = self._search.best(strip.out, strip.along, before, scene)
            if hit > latest:
                best, latest = found, hit
            if np.isposinf(latest):
                break
        return best


def _strips(point: Array, boxes: Surroundings) -> list[_Strip]:
    """The strips of all obstacles that sweep past the height of a point within the horizon."""
    found = []
    for pose, half, velocity in zip(boxes.poses, boxes.half, boxes.velocities, strict=True):
        pace = float(np.hypot(*velocity))
        if pace < 1e-6:
            continue
        along = velocity / pace
        across = np.array([-along[1], along[0]])
        axes = np.array([[np.cos(pose[2]), np.sin(pose[2])], [-np.sin(pose[2]), np.cos(pose[2])]])
        half_across = float(np.abs(axes @ across) @ half)
        half_along = float(np.abs(axes @ along) @ half)
        offset = point - pose[:2]
        ahead, beside = float(offset @ along), float(offset @ across)
        if -half_along - 0.4 < ahead < half_along + 0.4 + pace * _HORIZON:
            arrival = (ahead - half_along) / pace
            found.append(_Strip(along, across, beside, half_across + _CLEAR, arrival))
    return found
