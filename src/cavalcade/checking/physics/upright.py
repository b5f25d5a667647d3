"""Falls: a trunk that tips over or lies on the ground."""

from __future__ import annotations

import numpy as np

from cavalcade.checking.physics.floor import Floor
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.stretches import stretches
from cavalcade.checking.report import Violation
from cavalcade.geometry import Array
from cavalcade.robots.description import QuadrupedDescription

TIPPED = 1.0
"""A trunk tilted by more has fallen, rad."""

LOW = 0.4
"""A trunk below this part of the standing height, for `FOR_GOOD` s, lies."""

FOR_GOOD = 0.1


def check_upright(
    record: RobotRecord, description: QuadrupedDescription, floor: Floor
) -> list[Violation]:
    """One violation per fall, at the moment it is certain."""
    tilt = np.arccos(np.clip(record.turn[:, 2, 2], -1.0, 1.0))
    height = height_over(record, floor) / description.stand_height
    result = []
    lies = np.zeros(len(tilt), dtype=bool)
    for begin, end in stretches(height < LOW):
        lies[begin:end] = record.time[begin:end] - record.time[begin] >= FOR_GOOD - 1e-9
    for begin, _ in stretches((tilt > TIPPED) | lies):
        tipped = tilt[begin] > TIPPED
        how = f"tilted by {tilt[begin]:.2f} rad" if tipped else f"{height[begin]:.2f} of its height"
        text = f"robot {record.robot} has fallen: its trunk is {how}"
        value, limit = (tilt[begin], TIPPED) if tipped else (height[begin], LOW)
        result.append(
            Violation("fall", float(record.time[begin]), (record.robot,), text, float(value), limit)
        )
    return result


def height_over(record: RobotRecord, floor: Floor) -> Array:
    """Of the trunk's origin over the lowest ground right below it, `(T,)` m."""
    low, _ = floor.range_at(record.base[:, :2], 0.0)
    height: Array = record.base[:, 2] - low
    return height
