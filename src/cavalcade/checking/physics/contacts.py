"""Contacts that should not be, from the recording and from geometry, and falls.

What geometry shows the recording must know of.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.ground import Floor
from cavalcade.checking.physics.record import RobotRecord, Touch
from cavalcade.checking.physics.touching import Overlap
from cavalcade.checking.report import Kind, Violation, broken, stretches
from cavalcade.robots.description import QuadrupedDescription

DEEP = 0.001
"""Parts that lie deeper in something than this, m, touch it."""

TOGETHER = 0.1
"""Contacts of the same things with shorter breaks are one, s."""

ON_CALVES = 0.2
"""More than this part of the time calves on the ground are no accident, and hide what carries."""

BODY = ("trunk", "hip", "thigh")
"""Parts that have no business on the ground."""

TIPPED = 1.0
"""A trunk tilted by more has fallen, rad."""

LOW = 0.4
"""A trunk below this part of the standing height, for `FOR_GOOD` s, lies."""

FOR_GOOD = 0.1


def recorded_contacts(record: RobotRecord) -> list[Violation]:
    """Touches of what should not be touched: one per contact, at its first moment."""
    last: dict[tuple[str, str], float] = {}
    result = []
    for touch in record.touches:
        if touch.other == "ground" and touch.part not in BODY:
            continue
        what = (touch.part, touch.other)
        before = last.get(what, -np.inf)
        last[what] = touch.time
        if touch.time > before + TOGETHER:
            result.append(_violation(record, touch))
    calves = [touch for touch in record.touches if (touch.part, touch.other) == ("calf", "ground")]
    if calves:
        part = float(touched(replace(record, touches=tuple(calves))).mean())
        if part > ON_CALVES:
            words = f" {100.0 * part:.0f} % of the time"
            result.append(_violation(record, calves[0], "", part, words))
    return result


def hidden_contacts(record: RobotRecord, overlaps: Iterable[Overlap]) -> list[Violation]:
    """Overlaps that the recording says nothing of: once for each other thing."""
    result: dict[tuple[str, str], Violation] = {}
    for overlap in overlaps:
        if overlap.other == "ground" and overlap.part not in BODY:
            continue
        for begin, end in stretches(overlap.depth > DEEP):
            first, last = record.time[begin], record.time[end - 1]
            low, high = first - TOGETHER, last + TOGETHER
            if overlap.other in {t.other for t in record.touches if low <= t.time <= high}:
                continue
            depth = float(overlap.depth[begin:end].max())
            words = f", {depth:.3f} m deep, and the recording says nothing of it"
            touch = Touch(float(first), overlap.part, overlap.other)
            found = _violation(record, touch, overlap.obstacle, depth, words)
            key = (overlap.other, overlap.obstacle)
            if key not in result or found.time < result[key].time:
                result[key] = found
            break
    return list(result.values())


def check_upright(
    record: RobotRecord, description: QuadrupedDescription, floor: Floor
) -> list[Violation]:
    """One violation per fall, at the moment it is certain: a trunk tips over, or lies."""
    tilt = np.arccos(np.clip(record.turn[:, 2, 2], -1.0, 1.0))
    low, _ = floor.range_at(record.base[:, :2], 0.0)
    height = (record.base[:, 2] - low) / description.stand_height
    result = []
    lies = np.zeros(len(tilt), dtype=bool)
    for begin, end in stretches(height < LOW):
        lies[begin:end] = record.time[begin:end] - record.time[begin] >= FOR_GOOD - 1e-9
    for begin, _ in stretches((tilt > TIPPED) | lies):
        tipped = tilt[begin] > TIPPED
        how = f"tilted by {tilt[begin]:.2f} rad" if tipped else f"{height[begin]:.2f} of its height"
        text = f"robot {record.robot} has fallen: its trunk is {how}"
        value, limit = (tilt[begin], TIPPED) if tipped else (height[begin], LOW)
        result.append(broken("fall", record.time[begin], record.robot, text, value, limit))
    return result


def touched(record: RobotRecord) -> NDArray[np.bool_]:
    """Intervals `(T - 1,)` in or next to which something but a foot carries."""
    result = np.zeros(len(record.time) - 1, dtype=bool)
    if record.touches and len(result):
        times = np.array([touch.time for touch in record.touches])
        at = np.clip(np.searchsorted(record.time, times) - 1, 0, len(result) - 1)
        for shift in (-1, 0, 1):
            result[np.clip(at + shift, 0, len(result) - 1)] = True
    return result


def _violation(
    record: RobotRecord, touch: Touch, obstacle: str = "", value: float = 0.0, words: str = ""
) -> Violation:
    sample = int(np.searchsorted(record.time, touch.time).clip(0, len(record.time) - 1))
    x, y, z = record.base[sample, :3]
    robots: tuple[int, ...] = (record.robot,)
    kind: Kind = "contact"
    what = "the ground" if touch.other == "ground" else obstacle or touch.other
    if touch.other.startswith("robot "):
        robots, kind = (record.robot, int(touch.other.removeprefix("robot "))), "robot-robot"
    elif touch.other == "obstacle":
        kind = "robot-obstacle"
    text = (
        f"the {touch.part} of robot {record.robot} touches {what}{words}; its trunk is at "
        f"({x:.3f}, {y:.3f}, {z:.3f}) m"
    )
    return Violation(kind, touch.time, robots, text, value, 0.0, obstacle)
