"""Hands robots over to a fleet that leaps by itself, and takes them back where they landed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.execution.time_scaling import TimeScaling
from cavalcade.fleet import LeapingFleet, LeapRequest
from cavalcade.geometry import Array, wrap_angle
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, Trajectory
from cavalcade.world import Terrain

AFTERWARDS = 2.0
"""A robot that has landed goes on at most this much later in its plan, s."""

PATIENCE = 3.0
"""Once nobody has come on for this long because of a leap, a robot may leap that would come
nearer to others than the margin, but touch nobody, s."""

_BREAK, _ACROSS, _GRAIN = 0.05, 0.05, 0.01
"""Ground breaks where its height changes by more than the first over the second, m; looked for
every so many m."""


@dataclass(frozen=True)
class Leap:
    """One leap of a trajectory: samples at which its parts begin and the last one ends."""

    take_off: int
    lift_off: int
    touch_down: int
    landed: int


class LeapScheduler:
    """When the robots of a team leap, if their fleet carries leaps out by itself.

    A leap begins when nobody can come in its way any more: everybody who goes before the robot,
    up to the end of the landing, has passed. Until then the robot waits where its approach
    begins. Robots that leap side by side may wait for each other so; then one leaps closer to
    the others than the margin. If none can without touching one, the team is stuck.
    """

    def __init__(
        self,
        paths: Sequence[Trajectory],
        fleet: LeapingFleet,
        terrain: Terrain | None,
        scaling: TimeScaling,
    ) -> None:
        self._paths, self._fleet, self._terrain = paths, fleet, terrain
        self._scaling = scaling
        self._waiting = [leaps_of(path) for path in paths]
        self._landed = np.zeros(len(paths))
        self._excused = np.zeros(len(paths), dtype=bool)
        self._moved = 0.0
        self._furthest = np.zeros(len(paths))
        self.trouble: tuple[str, tuple[int, ...]] | None = None
        self._cap()

    def step(self, now: float, poses: Array) -> None:
        """Take back who has landed."""
        scaling = self._scaling
        for robot in np.flatnonzero(scaling.held & ~self._fleet.leaping).tolist():
            if self._fleet.leap_failed[robot]:
                # Wherever it is, the others take it to be where it was handed over.
                self.trouble = (f"robot {robot} failed to leap", (robot,))
                continue
            leap = self._waiting[robot].pop(0)
            self._excused[robot] = False
            self._landed[robot] = self._paths[robot].time[leap.landed]
            scaling.go_on(robot, now, self._nearest(robot, poses[robot]))
        self._cap()
        self._watch(now)

    def hand_over(self, now: float) -> None:
        """Give the fleet who is about to begin an approach and may leap."""
        scaling = self._scaling
        progress = scaling.progress(now)
        for robot, waiting in enumerate(self._waiting):
            if not waiting or scaling.held[robot] or not math.isinf(scaling.caps[robot]):
                continue
            begin = self._begin(robot)
            if progress[robot] + scaling.rates[robot] * scaling.period >= begin - 1e-9:
                request = request_of(self._paths[robot], waiting[0], self._terrain)
                scaling.held[robot] = True
                scaling.rates[robot] = 0.0
                self._fleet.leap(robot, request)

    def _begin(self, robot: int) -> float:
        """When the next approach begins, s of plan time."""
        start = float(self._paths[robot].time[self._waiting[robot][0].take_off])
        return max(start - self._fleet.approach, float(self._landed[robot]))

    def _cap(self) -> None:
        """Nobody goes on to an approach whose leap is not free to its end."""
        bounds = self._scaling.bounds()
        for robot, waiting in enumerate(self._waiting):
            cap = math.inf
            if waiting and not self._scaling.held[robot]:
                end = self._paths[robot].time[waiting[0].landed]
                free = self._excused[robot] or bounds[robot] >= end
                cap = math.inf if free else self._begin(robot)
            self._scaling.caps[robot] = cap

    def _nearest(self, robot: int, pose: Array) -> float:
        """The plan time after the landing at which the plan is nearest to a pose."""
        landed = float(self._landed[robot])
        latest = min(landed + AFTERWARDS, float(self._scaling.bounds()[robot]))
        if self._waiting[robot]:
            latest = min(latest, self._begin(robot))
        moments = np.arange(landed, max(latest, landed) + 1e-9, 0.01)
        away = self._paths[robot].poses_at(moments) - pose
        far = np.hypot(away[:, 0], away[:, 1]) + 0.3 * np.abs(wrap_angle(away[:, 2]))
        return float(moments[int(np.argmin(far))])

    def _watch(self, now: float) -> None:
        """Notice when leaps wait for each other, and let one begin."""
        scaling = self._scaling
        if (scaling.sure > self._furthest + 1e-6).any() or scaling.held.any():
            self._furthest = scaling.sure.copy()
            self._moved = now
        waits = np.flatnonzero(np.isfinite(scaling.caps))
        if not len(waits) or now - self._moved <= PATIENCE:
            return
        bounds = scaling.bounds(margin=False)
        for robot in waits[np.argsort(scaling.sure[waits], kind="stable")].tolist():
            if bounds[robot] >= self._paths[robot].time[self._waiting[robot][0].landed]:
                self._excused[robot] = True
                self._moved = now
                return
        names = tuple(waits.tolist())
        self.trouble = (f"the leap of robot {names[0]} is never free to its end", names)


def leaps_of(path: Trajectory) -> list[Leap]:
    """The leaps of a trajectory in order; one may follow another at once."""
    phase = np.asarray(path.phase[:-1])
    found = []
    begins = np.flatnonzero((phase == TAKE_OFF) & (np.concatenate([[-1], phase[:-1]]) != TAKE_OFF))
    for first in begins.tolist():
        marks = [first]
        for part in (TAKE_OFF, FLIGHT, LANDING):
            k = marks[-1]
            while k < len(phase) and phase[k] == part:
                k += 1
            marks.append(k)
        found.append(Leap(*marks))
    return found


def request_of(path: Trajectory, leap: Leap, terrain: Terrain | None) -> LeapRequest:
    """What a fleet is told of a leap of a trajectory."""
    first, last = (
        np.array([*path.position[mark], path.yaw[mark]]) for mark in (leap.take_off, leap.landed)
    )
    return LeapRequest(first, last, edges_of(terrain, first, last))


def edges_of(terrain: Terrain | None, start: Array, end: Array) -> tuple[float, float] | None:
    """Where the ground at the start ends and that at the end begins, m from the start."""
    step = end[:2] - start[:2]
    length = math.hypot(*step)
    if terrain is None or length < _GRAIN:
        return None
    along = np.arange(0.0, length + _GRAIN, _GRAIN)
    heights = terrain.heights_at(start[:2] + along[:, None] * step / length)
    apart = round(_ACROSS / _GRAIN)
    if len(heights) <= apart:
        return None
    broken = np.flatnonzero(np.abs(heights[apart:] - heights[:-apart]) > _BREAK)
    if not len(broken):
        return None
    # A break shows from `apart` before it up to it: its place is the middle of each run.
    first, last = broken[0], broken[-1]
    run = np.split(broken, np.flatnonzero(np.diff(broken) > 1) + 1)
    near = 0.5 * (first + run[0][-1] + apart) * _GRAIN
    far = 0.5 * (run[-1][0] + last + apart) * _GRAIN
    return float(near), float(far)
