"""Where the ground breaks on a robot's path, and how to cross it squarely."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cavalcade.geometry import Array

Heights = Callable[[Array], Array]
"""Heights `(N,)` in m of the ground at points `(N, 2)`, map frame."""

LEVEL = 0.02
"""Ground belongs to a side of the break as far as its height is that of the side within this, m."""

_LINES = (-0.18, -0.12, 0.0, 0.12, 0.18)
"""Lines beside the path, m, along which the ground is looked at."""

_SPAN, _AWAY, _GRAIN = 0.3, 0.12, 0.005
"""Looked at so far from a break, m; a side's own height is that beyond the second; every so many
m."""

_OBLIQUE = 0.6
"""Breaks are crossed squarely up to that angle from the planned direction, rad."""


@dataclass(frozen=True)
class Crossing:
    """A break of the ground as a leap needs it; map frame.

    Attributes:
        direction: `(2,)` unit vector across it.
        start: `(2,)` where the path meets the last of the ground before it.
        gap: From there to the first of the ground behind it, along `direction`, m.
        before, behind: Heights on both sides, m.
    """

    direction: Array
    start: Array
    gap: float
    before: float
    behind: float

    @property
    def yaw(self) -> float:
        """Heading of `direction`, rad."""
        return math.atan2(self.direction[1], self.direction[0])

    @property
    def rise(self) -> float:
        """Height of the far side over the near one, m."""
        return self.behind - self.before


def find_crossing(
    take_off: Array, landed: Array, edges: tuple[float, float], heights: Heights | None
) -> Crossing:
    """The break between two poses `(4,)` x, y, z, yaw of the body, near `edges`, m along the line.

    Heights of the ground tell how the break lies and where its sides are level; without them it is
    across the line, between the bodies' heights.
    """
    ahead = np.asarray(landed[:2] - take_off[:2], dtype=float)
    ahead = ahead / max(math.hypot(*ahead), 1e-9)
    origin = np.asarray(take_off[:2], dtype=float)
    near, far = edges
    if heights is None:
        rise = float(landed[2] - take_off[2])
        return Crossing(ahead, origin + near * ahead, far - near, 0.0, rise)
    side = np.array([-ahead[1], ahead[0]])
    lines = np.array(_LINES)
    places, levels = [], []
    for edge, sign in ((near, -1.0), (far, 1.0)):
        ends = [_end(heights, origin + u * side, ahead, edge, sign) for u in lines]
        place, height = np.array(ends).T
        places.append(place)
        levels.append(float(np.median(height)))
    # The straight lines nearest to both edges say how the break lies.
    slope = 0.5 * sum(float(np.polyfit(lines, place, 1)[0]) for place in places)
    turn = min(max(-math.atan(slope), -_OBLIQUE), _OBLIQUE)
    across = math.cos(turn) * ahead + math.sin(turn) * side
    first, last = (origin + np.outer(lines, side) + np.outer(place, ahead) for place in places)
    begin = float((first @ across).min())
    middle = first[len(lines) // 2]
    start = middle + (begin - float(middle @ across)) * across
    return Crossing(across, start, float((last @ across).max()) - begin, *levels)


def _end(
    heights: Heights, origin: Array, ahead: Array, edge: float, sign: float
) -> tuple[float, float]:
    """Where level ground ends near an edge, m along the path, and its height.

    `sign` is -1 for the ground before the edge, 1 for that behind it.
    """
    away = np.arange(-_AWAY, _SPAN, _GRAIN)
    height = heights(origin + np.outer(edge + sign * away, ahead))
    own = float(np.median(height[away > _AWAY]))
    off = np.flatnonzero((np.abs(height - own) > LEVEL) & (away <= _AWAY))
    first = int(off[-1]) + 1 if len(off) else 0
    return edge + sign * float(away[first]), own
