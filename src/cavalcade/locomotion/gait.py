"""When each foot stands: a trot while the body walks, all feet down while it rests.

Times in s. In a trot the diagonal pairs of legs swing in turns (the paper's gait; period and duty
are the robot's). Feet are never in the air when they must push or catch: all are down before a
take-off begins, leave the ground together at lift-off and come down together at touch-down.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT, WALK, Trajectory
from cavalcade.robots.model import LegModel

FRONT_LEFT, FRONT_RIGHT, REAR_LEFT, REAR_RIGHT = 0, 1, 2, 3

_PAIRS = ((FRONT_LEFT, REAR_RIGHT), (FRONT_RIGHT, REAR_LEFT))
_STILL = 0.01
"""A body slower than this rests, m/s and rad/s."""

_REST, _STEP, _HOLD, _AIR = 0, 1, 2, 3


@dataclass(frozen=True)
class _Span:
    kind: int
    start: float
    end: float


def stances(trajectory: Trajectory, legs: LegModel) -> Array:
    """All stances of the four feet, from the first moment to the trajectory's end.

    Steps take the gait's period exactly, but for spans after a leap, where it is stretched or
    shortened so that whole steps fit, and for the shorter steps beside a leap. A rest
    shorter than a period between two walks is no rest: the feet go on stepping.

    Args:
        trajectory: Of the body.
        legs: Its gait.

    Returns:
        `(M, 3)` t_down, t_up, leg, sorted by t_down and leg. The last stance of each leg ends
        with the trajectory, but the foot stays there for good.
    """
    swings = _swings(_spans(trajectory, legs.gait_period), legs)
    found: list[tuple[float, float, int]] = []
    for leg, intervals in enumerate(swings):
        down = 0.0
        for lift, land in intervals:
            # No stance between two swings that follow each other without one.
            if lift > down + 1e-9 or down == 0.0:
                found.append((down, lift, leg))
            down = land
        found.append((down, max(trajectory.duration, down), leg))
    found.sort(key=lambda stance: (stance[0], stance[2]))
    return np.array(found, dtype=float)


def _swings(spans: list[_Span], legs: LegModel) -> list[list[tuple[float, float]]]:
    """Per leg (lift, land) times, in order."""
    swings: list[list[tuple[float, float]]] = [[], [], [], []]
    pair = 0
    for index, span in enumerate(spans):
        if span.kind == _AIR:
            for leg in range(4):
                swings[leg].append((span.start, span.end))
        elif span.kind == _STEP:
            after = index > 0 and spans[index - 1].kind == _HOLD
            until = index + 1 < len(spans) and spans[index + 1].kind == _HOLD
            for lift, length in _steps(span, 0.5 * legs.gait_period, after, until):
                air = min(length, 2.0 * length * (1.0 - legs.duty))
                for leg in _PAIRS[pair]:
                    swings[leg].append((lift, lift + air))
                pair = 1 - pair
    return swings


def _steps(span: _Span, half: float, after: bool, until: bool) -> Iterator[tuple[float, float]]:
    """(start, length) of the half periods in which one pair swings.

    From rest, the feet stand as long as it takes for the last swing to end with the span. Beside
    a leap the other pair stands for the landing or the take-off besides: steps there are half as
    long, so that it need not reach twice as far: `after` a landing, or `until` a take-off.
    """
    length = span.end - span.start
    lost = 0.5 * (after + until)
    if after:
        count = max(round(length / half + lost), 2)
    else:
        count = max(int((length + 1e-9) / half + lost), 2)
    if after or (count - lost) * half > length:
        half = length / (count - lost)
    start = max(span.start, span.end - (count - lost) * half)
    for k in range(count):
        short = (after and k == 0) or (until and k == count - 1)
        lasts = 0.5 * half if short else half
        yield start, lasts
        start += lasts


def _spans(trajectory: Trajectory, period: float) -> list[_Span]:
    """What the feet have to do, span after span."""
    kinds = _kinds(trajectory)
    time = trajectory.time
    changes = np.flatnonzero(np.diff(kinds)) + 1
    edges = [0, *changes.tolist(), len(kinds)] if len(kinds) else [0]
    spans = [_Span(int(kinds[a]), float(time[a]), float(time[b])) for a, b in pairwise(edges)]
    for index in range(1, len(spans) - 1):
        short = spans[index].end - spans[index].start < period
        between = spans[index - 1].kind == spans[index + 1].kind == _STEP
        if spans[index].kind == _REST and short and between:
            spans[index] = _Span(_STEP, spans[index].start, spans[index].end)
    merged: list[_Span] = []
    for span in spans:
        if merged and merged[-1].kind == span.kind:
            span = _Span(span.kind, merged.pop().start, span.end)
        merged.append(span)
    return merged


def _kinds(trajectory: Trajectory) -> NDArray[np.int8]:
    """`(T - 1,)` of each interval between two samples."""
    steps = np.diff(trajectory.time)
    speed = np.hypot(trajectory.velocity[:, 0], trajectory.velocity[:, 1])
    moved = np.hypot(*np.diff(trajectory.position[:, :2], axis=0).T)
    turned = np.abs(np.diff(trajectory.yaw))
    still = (np.maximum(speed[:-1], speed[1:]) < _STILL) & (moved < _STILL * steps + 1e-6)
    still &= turned < _STILL * steps + 1e-6
    phase = trajectory.phase[:-1]
    kinds = np.where(still, _REST, _STEP)
    kinds = np.where(phase == WALK, kinds, np.where(phase == FLIGHT, _AIR, _HOLD))
    return np.asarray(kinds, dtype=np.int8)
