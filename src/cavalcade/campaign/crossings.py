"""How robots in physics cross the gap or step of generated terrain, by the criterion of leaps."""

from __future__ import annotations

import numpy as np

from cavalcade.campaign.judging import records_of
from cavalcade.checking.heights import read_heights
from cavalcade.checking.physics.leaps import leap_reason
from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario

KINDS = ("gap", "step")
"""Terrain with one break, across the whole width."""

BEFORE = 0.9
"""A leap is judged from when the robot was last so far before the far edge, m."""


def crossings(scenario: Scenario, recording: Recording) -> dict[str, int]:
    """How many robots came across, and how many of them as a leap has to be.

    `crossings` and `strict_crossings`: of the break in the middle of the ground; nothing on other
    ground and without physics.
    """
    source = scenario.world.generate
    if recording.physics is None or source is None or source.kind not in KINDS:
        return {}
    heights = read_heights(scenario)
    if heights is None:
        return {}
    middle = source.size[0] / 2.0 if source.at is None else source.at
    half = (source.width or 0.0) / 2.0
    found = {"crossings": 0, "strict_crossings": 0}
    for record, model in zip(records_of(recording.physics), scenario.models, strict=True):
        first, last = record.base[0, 0], record.base[-1, 0]
        sign = 1.0 if first < middle else -1.0
        if model.description is None or sign * (last - middle) < half:
            continue
        found["crossings"] += 1
        past = sign * (record.base[:, 0] - middle) - half
        before = np.flatnonzero(past < -BEFORE)
        begin = float(record.time[before[-1]]) if len(before) else float(record.time[0])
        y = float(np.interp(begin, record.time, record.base[:, 1]))
        end = np.array([middle + sign * (half + 0.6), y])
        reason = leap_reason(record, model.description, heights, end, begin)
        found["strict_crossings"] += not reason
    return found
