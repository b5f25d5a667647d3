"""Whether a recording shows the whole run: time stamps, gaps, the same samples for all."""

from __future__ import annotations

import numpy as np

from cavalcade.checking.report import Violation
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array, wrap_angle

Pose = tuple[float, float, float]

_SLACK = 1e-6
_START = (0.05, 0.05)
"""How far the first sample may lie from the scenario's start, m and rad: one cycle of motion."""


def disordered(tracks: tuple[Track, ...]) -> list[Violation]:
    """Time stamps that do not increase; such tracks can be judged no further."""
    result = []
    for robot, track in enumerate(tracks):
        wrong = np.flatnonzero(np.diff(track.time) <= 0.0)
        if len(wrong):
            time = float(track.time[wrong[0] + 1])
            text = f"the time stamps of robot {robot} do not increase"
            step = time - float(track.time[wrong[0]])
            result.append(Violation("samples", time, (robot,), text, step, 0.0))
    return result


def incomplete(tracks: tuple[Track, ...], rate: float, end: float | None) -> list[Violation]:
    """Samples that are missing: between others, at the end, or for some robots only.

    Args:
        tracks: With increasing time stamps.
        rate: Of the planner, Hz: there is at least a sample per cycle.
        end: Simulated time that the summary claims, s, if it does.
    """
    result = []
    cycle = 1.0 / rate
    samples = np.unique(np.concatenate([track.time for track in tracks]))
    for robot, track in enumerate(tracks):
        wide = np.flatnonzero(np.diff(track.time) > cycle * (1.0 + 1e-3) + _SLACK)
        for k in wide:
            gap = float(track.time[k + 1] - track.time[k])
            text = f"robot {robot} has no samples for {gap:.3f} s; a cycle lasts {cycle:.3f} s"
            result.append(Violation("samples", float(track.time[k]), (robot,), text, gap, cycle))
        if len(track.time) != len(samples):
            missing = float(np.setdiff1d(samples, track.time)[0])
            have, most = len(track.time), len(samples)
            text = f"robot {robot} has {have} samples of {most}"
            result.append(Violation("samples", missing, (robot,), text, have, most))
    if end is not None and samples[-1] - samples[0] < end - 2.0 * cycle - _SLACK:
        duration = float(samples[-1] - samples[0])
        everyone = tuple(range(len(tracks)))
        text = f"the recording covers {duration:.2f} s, the summary says {end:.2f} s"
        result.append(Violation("samples", float(samples[-1]), everyone, text, duration, end))
    return result


def misplaced(tracks: tuple[Track, ...], starts: tuple[Pose, ...]) -> list[Violation]:
    """Robots that do not begin where the scenario says."""
    result = []
    for robot, (track, start) in enumerate(zip(tracks, starts, strict=True)):
        result += off_start(robot, float(track.time[0]), track.pose[0], start, _START)
    return result


def off_start(
    robot: int, time: float, pose: Array, start: Pose, most: tuple[float, float], heads: bool = True
) -> list[Violation]:
    """A robot that begins further from its start than `most`, m and rad.

    It does not matter how it is turned unless it `heads` anywhere.
    """
    x, y, yaw = pose - start
    distance, turn = float(np.hypot(x, y)), float(np.abs(wrap_angle(yaw)))
    if distance <= most[0] and (turn <= most[1] or not heads):
        return []
    text = f"robot {robot} begins {distance:.3f} m and {turn:.3f} rad from its start"
    return [Violation("start", time, (robot,), text, distance, most[0])]
