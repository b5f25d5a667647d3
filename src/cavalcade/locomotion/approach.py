"""Brings a robot before a break of the ground, lets it leap, and hands it back behind it."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import Array, wrap_angle
from cavalcade.locomotion.crossing import Crossing, Heights, find_crossing
from cavalcade.locomotion.leap import LeapManoeuvre, LeapSettings

NEAR, SQUARE = 0.012, 0.03
"""Within these of where it wants to leap from a robot stops, m, rad."""

SHORT, OVER, BESIDE, ASKEW = 0.06, 0.015, 0.06, 0.06
"""It leaps if its front feet are no more short of, or over, where they should be, and the trunk no
more beside its line or turned, m, rad."""

LEEWAY = 0.05
"""The trunk is aimed at most so far from where it should stand, so that the feet stand right, m."""

FAST, ASIDE, TURN = 0.4, 0.2, 0.8
"""Greatest velocities while it approaches: ahead, aside, turning; m/s, m/s, rad/s."""

GAIN = 2.0
"""Speed per distance while it approaches, 1/s."""

SLOW = 0.08
"""Least speed of a robot that is not there yet, m/s."""

RUN_UP = 0.2
"""A robot that is askew or beside its line comes no nearer than this, m."""

PAUSE, AFTER = 0.2, 0.3
"""It stands so long before it looks where its feet are, and after its landing, s."""

TRIES, PATIENCE = 8, 30.0
"""It gives up after so many corrections, or so long, s."""

WALK, LEAP, WAIT, DONE, FAILED = range(5)
"""What a robot is to do: walk with the commanded velocity, leap now, go on leaping, or nothing."""


class LeapPilot:
    """Decides what one robot does from the hand-over to the end of a leap.

    Where the ground does not break it walks to where the leap should have ended. `take_off`,
    `landed` and `edges` are those of a `LeapRequest`; `heights` may be unknown; front hip joints
    are `front` m ahead of the trunk's origin.

    Attributes:
        velocity: `(3,)` command for a robot that is to walk, body frame, m/s, m/s, rad/s.
        manoeuvre: For a robot that is to leap.
        leapt: Whether it has been told to.
    """

    def __init__(
        self,
        take_off: Array,
        landed: Array,
        edges: tuple[float, float] | None,
        heights: Heights | None,
        front: float,
    ) -> None:
        self._settings = LeapSettings()
        self._front = front
        self._crossing: Crossing | None = None
        self._goal = np.array([landed[0], landed[1], landed[3]], dtype=float)
        if edges is not None:
            self._crossing = find_crossing(take_off, landed, edges, heights)
            self._goal = self._stand(self._crossing)
        self._aim = self._goal.copy()
        self._begun = math.nan
        self._still = math.nan
        self._tries = 0
        self.leapt = False
        self.velocity = np.zeros(3)
        self.manoeuvre: LeapManoeuvre | None = None

    def step(self, time: float, pose: Array, feet: Array, stands: bool, leaps: bool) -> int:
        """What to do at `time` s: `WALK`, `LEAP`, `WAIT`, `DONE` or `FAILED`.

        The trunk is at `pose` `(3,)` and feet stand at `feet` `(4, 3)`; the robot stands or leaps.
        """
        if math.isnan(self._begun):
            self._begun = time
        self.velocity = np.zeros(3)
        if leaps:
            self._still = math.nan
            return WAIT
        if self.leapt:
            return DONE if self._stood(time, stands, AFTER) else WALK
        if time - self._begun > PATIENCE:
            return FAILED
        if math.isnan(self._still) and not self._there(pose):
            self.velocity = self._towards(pose)
            return WALK
        if not self._stood(time, stands, PAUSE):
            if math.isnan(self._still):
                self._still = math.inf  # arrived: from now on it waits to stand
            return WALK
        if self._crossing is None:
            return DONE
        off = self._off(self._crossing, pose, feet)
        if -SHORT <= off[0] <= OVER and abs(off[1]) <= BESIDE and abs(off[2]) <= ASKEW:
            self.manoeuvre = self._leap(self._crossing, pose)
            self.leapt = True
            return LEAP
        self._tries += 1
        if self._tries > TRIES:
            return FAILED
        self._correct(self._crossing, off)
        self._still = math.nan
        return WALK

    def _stand(self, crossing: Crossing) -> Array:
        """Where the trunk is when the front feet, below the hips, stand where they should."""
        away = self._front + self._before(crossing)
        place = crossing.start - away * crossing.direction
        return np.array([place[0], place[1], crossing.yaw])

    def _before(self, crossing: Crossing) -> float:
        """How far before the edge front feet stand, m."""
        settings = self._settings
        more = settings.brink if crossing.rise < -0.5 * settings.brink else 0.0
        return settings.before + settings.head * max(crossing.rise, 0.0) + more

    def _leap(self, crossing: Crossing, pose: Array) -> LeapManoeuvre:
        settings = self._settings
        across = crossing.direction
        ahead = float((crossing.start - pose[:2]) @ across)
        end = pose[:2] + (ahead + crossing.gap + settings.margin + self._front) * across
        return LeapManoeuvre(
            (float(pose[0]), float(pose[1]), crossing.before, float(pose[2])),
            (float(end[0]), float(end[1]), crossing.behind, crossing.yaw),
            (ahead, ahead + crossing.gap),
        )

    def _off(self, crossing: Crossing, pose: Array, feet: Array) -> Array:
        """How far front feet are ahead of, the body beside and turned from what is wanted."""
        across = crossing.direction
        wanted = float(crossing.start @ across) - self._before(crossing)
        ahead = float((feet[:2, :2] @ across).max()) - wanted
        aside = float((pose[:2] - self._goal[:2]) @ np.array([-across[1], across[0]]))
        return np.array([ahead, aside, float(wrap_angle(pose[2] - crossing.yaw))])

    def _correct(self, crossing: Crossing, off: Array) -> None:
        """Aim at elsewhere, so that the feet come to where they should be."""
        across = crossing.direction
        shift = off[0] * across + off[1] * np.array([-across[1], across[0]])
        self._aim[:2] -= shift
        # Feet that find no ground further on do not come after a body that goes on.
        self._aim[:2] = self._goal[:2] + np.clip(self._aim[:2] - self._goal[:2], -LEEWAY, LEEWAY)

    def _there(self, pose: Array) -> bool:
        near = math.hypot(*(self._aim[:2] - pose[:2])) <= NEAR
        return near and abs(float(wrap_angle(self._aim[2] - pose[2]))) <= SQUARE

    def _towards(self, pose: Array) -> Array:
        """The velocity that brings the robot to where it stops."""
        yaw = float(wrap_angle(self._aim[2] - pose[2]))
        c, s = math.cos(self._aim[2]), math.sin(self._aim[2])
        offset = self._aim[:2] - pose[:2]
        along, aside = c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]
        if abs(aside) > 0.05 or abs(yaw) > 0.15:
            along -= RUN_UP
        along = min(max(GAIN * along, -FAST), FAST)
        aside = min(max(GAIN * aside, -ASIDE), ASIDE)
        speed = math.hypot(along, aside)
        if speed < SLOW and math.hypot(*offset) > NEAR:
            along, aside = along * SLOW / max(speed, 1e-9), aside * SLOW / max(speed, 1e-9)
        # From the frame of the aim to that of the body.
        c, s = math.cos(yaw), math.sin(yaw)
        turn = min(max(2.0 * yaw, -TURN), TURN)
        return np.array([c * along - s * aside, s * along + c * aside, turn])

    def _stood(self, time: float, stands: bool, lasts: float) -> bool:
        """Whether the robot has stood for so long."""
        if not stands:
            if not math.isnan(self._still):
                self._still = math.inf
            return False
        if not math.isfinite(self._still):
            self._still = time
        return time - self._still >= lasts
