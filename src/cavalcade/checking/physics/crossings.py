"""Where the ground breaks on a robot's way, so that its leap can be judged."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.heights import Ground, Heights, ground_around
from cavalcade.checking.physics.floor import floor_of
from cavalcade.checking.physics.leaps import Leap, judge_leap
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.report import Violation
from cavalcade.geometry import Array
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.scenario import Scenario

BREAK, LEVEL = 0.05, 0.02
"""Ground that differs by more from that at the end of the way is a break; it ends where the ground
differs by less than the second from there on, m."""

SIDE, GRAIN = 0.15, 0.005
"""Ways beside it tell how the break lies, m; they are looked at every so many m."""

ENDS = 0.1
"""The first and last part of a way are its sides of the break, m."""


def find_leap(ground: Ground, start: Array, end: Array, begin: float) -> Leap | None:
    """What is to be leapt on a straight way; None where the ground does not break.

    Args:
        ground: Its heights.
        start, end: `(2,)` of the way, m.
        begin: When the take-off begins at the earliest, s.
    """
    way = end - start
    length = math.hypot(*way)
    if length < 2.0 * ENDS:
        return None
    along = way / length
    side = np.array([-along[1], along[0]])
    marks = np.arange(0.0, length, GRAIN)
    offsets = np.array([-SIDE, 0.0, SIDE])
    places = start + marks[:, None, None] * along + offsets[:, None] * side
    heights = ground.heights_at(places)
    beyond = np.median(heights[marks > length - ENDS], axis=0)
    before = float(np.median(heights[marks < ENDS, 1]))
    if (np.abs(heights - beyond) <= BREAK).all():
        return None
    off = np.abs(heights - beyond) > LEVEL
    far = [_last(column, marks) for column in off.T]
    turn = -math.atan((far[2] - far[0]) / (2.0 * SIDE))
    edge = start + far[1] * along
    heading = math.atan2(along[1], along[0]) + turn
    return Leap((float(edge[0]), float(edge[1])), heading, before, float(beyond[1]), begin)


def _last(off: NDArray[np.bool_], marks: Array) -> float:
    return float(marks[np.flatnonzero(off)[-1]]) + GRAIN if off.any() else 0.0


def check_leaps(
    scenario: Scenario, records: Sequence[RobotRecord], heights: Heights | None
) -> list[Violation]:
    """Leaps that robots were commanded, by the strict criterion of `judge_leap`."""
    result: list[Violation] = []
    for record, model in zip(records, scenario.models, strict=True):
        own = [one for one in scenario.task.commands or () if one.robot in (None, record.robot)]
        ends = [*(one.at for one in own[1:]), math.inf]
        for command, end in zip(own, ends, strict=True):
            if command.leap is None or heights is None or model.description is None:
                continue
            part = _between(record, command.at, end)
            point = np.array(command.leap)
            reason = leap_reason(part, model.description, heights, point, command.at)
            if reason:
                text = f"robot {record.robot} does not leap as it should: {reason}"
                result.append(Violation("leap", command.at, (record.robot,), text, 0.0, 1.0))
    return result


def leap_reason(
    record: RobotRecord,
    description: QuadrupedDescription,
    heights: Heights,
    end: Array,
    begin: float,
) -> str:
    """What the leap of a robot from where it is at `begin` s towards a point fails by; else empty.

    Also of a way without a break there is nothing to say.
    """
    first = int(np.searchsorted(record.time, begin))
    start = record.base[min(first, len(record.time) - 1), :2]
    around = np.concatenate([record.base[:, :2], [end]])
    leap = find_leap(ground_around(heights, around), start, end, begin)
    if leap is None:
        return ""
    return judge_leap(record, description, leap, floor_of(heights, around)).reason


def _between(record: RobotRecord, begin: float, end: float) -> RobotRecord:
    """The part of a record up to `end` s, from a moment before `begin` on."""
    chosen = (record.time >= begin - 0.1) & (record.time <= end)
    names = ("time", "base", "joints", "rates", "torques", "forces")
    touches = tuple(touch for touch in record.touches if begin - 0.1 <= touch.time <= end)
    return replace(record, touches=touches, **{k: getattr(record, k)[chosen] for k in names})
