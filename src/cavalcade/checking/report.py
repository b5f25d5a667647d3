"""What the checker says: a list of violations and the figures it measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

_Contact = Literal["robot-robot", "robot-obstacle", "robot-map"]
_Limit = Literal["speed", "yaw-rate", "acceleration", "yaw-acceleration"]
_Claim = Literal["start", "samples", "arrival", "summary"]
_Plan = Literal["plan", "phase", "dynamics", "ballistics", "force", "heading"]
_PlanOnGround = Literal["belly", "reach", "traversability", "foothold", "flight-over-robot"]
_Force = Literal["weight", "momentum", "angular-momentum", "torque", "friction"]
_Body = Literal["joint", "footing", "slide", "contact", "fall", "pose", "leap"]

Kind = _Contact | _Limit | _Claim | _Plan | _PlanOnGround | _Force | _Body
"""`robot-map` is contact with an occupied cell of the map or with its border. Those from `plan`
to `flight-over-robot` are about plans only; `plan` is an array that is missing or malformed.
Those from `weight` on are about robots in physics only."""


@dataclass(frozen=True)
class Violation:
    """One broken rule.

    Attributes:
        kind: Which rule.
        time: When it was broken first, s of the recording.
        robots: The robots concerned.
        message: One line for people: what, where, and how far beyond the limit.
        value: The measured figure in SI units; for contact the distance at `time`, which is 0
            within the tolerance.
        limit: What `value` had to keep to, tolerance left out.
        obstacle: For contact what was touched: `world.obstacles[3]`, `event at 12 s`, `map` or
            `border`; otherwise empty.
    """

    kind: Kind
    time: float
    robots: tuple[int, ...]
    message: str
    value: float
    limit: float
    obstacle: str = ""


@dataclass(frozen=True)
class PhysicsFigures:
    """Figures of bodies, joints and feet.

    Attributes:
        carried: Per robot, mean vertical force on the feet over what the described weight and the
            motion take; None where it is too short or too often touching something.
        max_torque_ratio: Largest torque over its joint's limit.
        max_slide_m: Farthest that a standing foot slid with nothing against it.
    """

    carried: tuple[float | None, ...]
    max_torque_ratio: float
    max_slide_m: float


@dataclass(frozen=True)
class Figures:
    """What was measured on the way.

    Attributes:
        robots: How many.
        duration_s: Length of the recording.
        min_footprint_gap_m: Smallest distance between two footprints, or a footprint and an
            obstacle or the border, at any time, also between samples; at most 0.1 mm too large,
            and 1 m if nothing came closer than that.
        max_speed_ratio: Largest speed as a fraction of what the velocity ellipse allows in that
            direction, or of the largest speed of robots with goals of their own.
        max_yaw_rate: Largest, rad/s.
        max_acceleration: Largest, m/s².
        max_yaw_acceleration: Largest, rad/s².
        min_belly_clearance_m: Of plans of legged robots: smallest distance of the trunk from the
            ground below it, m.
        physics: Of runs in physics.
    """

    robots: int
    duration_s: float
    min_footprint_gap_m: float
    max_speed_ratio: float
    max_yaw_rate: float
    max_acceleration: float
    max_yaw_acceleration: float
    min_belly_clearance_m: float | None = None
    physics: PhysicsFigures | None = None


@dataclass(frozen=True)
class Report:
    """The checker's verdict.

    Attributes:
        violations: All that was found, in order of time.
        figures: What was measured; None if the time stamps are in disorder.
    """

    violations: tuple[Violation, ...]
    figures: Figures | None

    @property
    def ok(self) -> bool:
        """Whether no rule was broken."""
        return not self.violations


def make_report(violations: list[Violation], figures: Figures | None = None) -> Report:
    """The violations in order of time; without figures the motion could not be measured."""
    return Report(tuple(sorted(violations, key=lambda violation: violation.time)), figures)


def broken(
    kind: Kind,
    time: SupportsFloat,
    robot: int,
    message: str,
    value: SupportsFloat = 0.0,
    limit: SupportsFloat = 0.0,
) -> Violation:
    """What one robot did; figures may be NumPy's."""
    return Violation(kind, float(time), (robot,), message, float(value), float(limit))


def stretches(beyond: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Begin and end (exclusive) of every stretch of `beyond` `(T,)` that holds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], beyond.astype(np.int8), [0]))))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        yield int(begin), int(end)


def excesses(
    kind: Kind,
    robot: int,
    time: Array,
    value: Array,
    limit: Array | float,
    words: str,
    slack: Array | float = 0.0,
    *,
    excess: Array | None = None,
) -> list[Violation]:
    """One violation per stretch with `value > limit + slack`, at its first moment.

    Args:
        kind, robot: As in `Violation`.
        time: `(K,)` s, when each value holds.
        value: `(K,)` in SI units.
        limit: `(K,)` or one for all.
        words: What the robot does; `{value:.3f}` and `{limit:.3f}` are those of the worst moment.
        slack: `(K,)` or one for all.
        excess: `(K,)` what is positive in such a stretch instead, and largest in its worst moment.
    """
    limits = np.broadcast_to(limit, value.shape)
    beyond = value - limit - slack if excess is None else excess
    result = []
    for begin, end in stretches(beyond > 0.0):
        worst = begin + int(beyond[begin:end].argmax())
        reached, wanted = float(value[worst]), float(limits[worst])
        text = f"robot {robot} {words.format(value=reached, limit=wanted)}"
        result.append(broken(kind, time[begin], robot, text, reached, wanted))
    return result
