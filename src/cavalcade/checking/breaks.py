"""What cannot have been motion in the recordings of live robots.

Their simulation or their localisation may be restarted, or fall silent. Of what was between two
such poses nothing is known: they are judged each, and nothing is swept from one to the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cavalcade.checking.report import Violation
from cavalcade.checking.tracks import Track
from cavalcade.geometry import wrap_angle
from cavalcade.robots import RobotModel

LIVE_GAP = 0.5
"""Live robots may be without a sample so long, s: then they should have been stopped."""

FASTER = 3.0
"""Nobody goes or turns faster than so many times its limit, pushed or badly measured,"""

FARTHER = (0.5, 1.0)
"""and further than so much beyond that, m and rad."""

_SLACK = 1e-6


@dataclass(frozen=True)
class Break:
    """Two samples of some robots with no motion between them.

    Attributes:
        begin, end: When they were sampled, s.
        robots: Whose samples.
        gap: Whether they are too far apart in time; otherwise the poses are.
        limit: The longest gap, s.
    """

    begin: float
    end: float
    robots: tuple[int, ...]
    gap: bool
    limit: float

    def told(self, robots: int) -> Violation:
        """The violation that it is, in a team of so many robots."""
        lasted = self.end - self.begin
        what = f"not seen for {lasted:.2f} s" if self.gap else f"elsewhere {lasted:.2f} s later"
        text = f"{_names(self.robots, robots)} {what}: nobody knows what was between"
        return Violation("samples", self.begin, self.robots, text, lasted, self.limit)


def find_breaks(
    tracks: Sequence[Track], models: Sequence[RobotModel], rate: float
) -> tuple[Break, ...]:
    """The breaks, in order; what several robots have at once is one.

    A gap is longer than two cycles of `rate`, Hz, and `LIVE_GAP`; a leap goes further than
    `FASTER` and `FARTHER` allow.
    """
    longest = max(2.0 / rate, LIVE_GAP)
    found: dict[tuple[float, float, bool], list[int]] = {}
    for robot, (track, model) in enumerate(zip(tracks, models, strict=True)):
        lasted, change = np.diff(track.time), np.diff(track.pose, axis=0)
        fastest = max(model.max_speed_x, model.max_speed_y)
        gap = lasted > longest * (1.0 + 1e-3) + _SLACK
        leap = np.hypot(*change.T[:2]) > FASTER * fastest * lasted + FARTHER[0]
        turned = np.abs(wrap_angle(change[:, 2]))
        leap |= turned > FASTER * model.max_yaw_rate * lasted + FARTHER[1]
        for k in np.flatnonzero(gap | leap):
            when = (float(track.time[k]), float(track.time[k + 1]), bool(gap[k]))
            found.setdefault(when, []).append(robot)
    return tuple(
        Break(begin, end, tuple(robots), gap, longest)
        for (begin, end, gap), robots in sorted(found.items())
    )


def between(tracks: Sequence[Track], breaks: Sequence[Break]) -> list[tuple[Track, ...]]:
    """The team's motion in the stretches before, between and after the breaks.

    In a stretch a robot may be without samples.
    """
    windows, first = [], -np.inf
    for one in breaks:
        if one.begin >= first:
            windows.append((first, one.begin))
        first = max(first, one.end)
    windows.append((first, np.inf))
    result = []
    for begin, end in windows:
        within = [(track.time >= begin) & (track.time <= end) for track in tracks]
        pairs = zip(tracks, within, strict=True)
        result.append(tuple(Track(track.time[seen], track.pose[seen]) for track, seen in pairs))
    return result


def _names(some: tuple[int, ...], robots: int) -> str:
    if len(some) == 1:
        return f"robot {some[0]} was"
    if len(some) == robots:
        return "the team was"
    return f"robots {', '.join(map(str, some[:-1]))} and {some[-1]} were"
