"""What figures read off a track: its robots, speeds, loads, and when feet carry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.scene import runs
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import LOADED, PhysicsTrack
from cavalcade.robots.description import QuadrupedDescription

if TYPE_CHECKING:
    from cavalcade.scenario import Scenario

_CYCLE = 0.5
"""Speeds are means over so long, about a cycle of the trot, s."""


def descriptions_of(scenario: Scenario, track: PhysicsTrack) -> list[QuadrupedDescription]:
    """The mechanisms of the robots of a track.

    Raises:
        RecordingError: The track is empty, or not that of the scenario's robots.
    """
    if not len(track.time) or track.size != len(scenario.models):
        raise RecordingError(
            f"expected samples of {len(scenario.models)} robots, "
            f"got {len(track.time)} of {track.size}",
            key="track",
        )
    found = []
    for model in scenario.models:
        if model.description is None:
            raise RecordingError(f"{model.name} has no legs in physics", key="track")
        found.append(model.description)
    return found


def planar_speed(track: PhysicsTrack) -> Array:
    """`(T, N)` m/s of the trunks over ground, without the sway of single steps."""
    time = track.time
    ahead = np.minimum(time + _CYCLE / 2.0, time[-1])
    behind = np.maximum(time - _CYCLE / 2.0, time[0])
    speed = np.empty((len(time), track.size))
    for robot in range(track.size):
        gone = [
            np.interp(ahead, time, track.base[:, robot, axis])
            - np.interp(behind, time, track.base[:, robot, axis])
            for axis in (0, 1)
        ]
        speed[:, robot] = np.hypot(*gone) / np.maximum(ahead - behind, 1e-9)
    return speed


def peaks(time: Array, values: Array, columns: int) -> tuple[Array, Array]:
    """At most so many times, and the largest of the values `(T, N)` around each."""
    stride = max(1, -(-len(time) // columns))
    starts = np.arange(0, len(time), stride)
    return time[starts], np.maximum.reduceat(values, starts, axis=0)


def spread(time: Array, values: Array, columns: int) -> tuple[Array, tuple[Array, Array, Array]]:
    """At most so many times, and the least, mean and largest of the values `(T, N)` around each.

    Around is at least a cycle of the trot.
    """
    marks = np.linspace(time[0], time[-1], min(columns, len(time)))
    reach = max(_CYCLE / 2.0, float(marks[1] - marks[0]) if len(marks) > 1 else 0.0)
    first = np.searchsorted(time, marks - reach)
    last = np.searchsorted(time, marks + reach, side="right")
    parts = [values[a:b] for a, b in zip(first, last, strict=True)]
    low = np.array([part.min(axis=0) for part in parts])
    high = np.array([part.max(axis=0) for part in parts])
    return marks, (low, np.array([part.mean(axis=0) for part in parts]), high)


def loaded_spans(time: Array, force: Array) -> list[tuple[float, float]]:
    """Begin and end of each stretch in which a foot carries; a sample tells of what was before."""
    return [
        (float(time[max(first - 1, 0)]), float(time[last - 1]))
        for carries, first, last in runs((force >= LOADED).tolist())
        if carries
    ]


def busiest_window(track: PhysicsTrack, length: float) -> tuple[float, float]:
    """Begin and end of the time in which most feet lift off or come down; a flight goes first."""
    time = track.time
    carries: NDArray[np.bool_] = np.greater_equal(track.foot_forces[..., 2], LOADED)
    length = min(length, track.duration)
    first, last = float(time[0]), float(time[-1])
    flight = np.flatnonzero(track.flying.any(axis=1))
    if len(flight):
        start = float(time[flight[0]]) - length / 2.0
    else:
        changes = np.concatenate([[0], np.cumsum((carries[1:] != carries[:-1]).sum(axis=(1, 2)))])
        ends = np.interp(time + length, time, changes) - changes
        fits = time <= last - length + 1e-9
        # Of the equally busy ones that in the middle.
        busy = np.flatnonzero(fits & (ends >= 0.98 * ends[fits].max()))
        start = float(time[busy[len(busy) // 2]])
    start = min(max(start, first), last - length)
    return start, start + length
