"""Quantities over the time of a run, thin enough for a page."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cavalcade.drawing.distances import neighbour_distances, obstacle_distances
from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array
from cavalcade.metrics.run_summary import placement_errors
from cavalcade.recording import Recording
from cavalcade.studio.study.results import Result

_MOST_SAMPLES = 600
"""Of a run; of more cycles every so many-th is looked at."""


@dataclass(frozen=True)
class Curve:
    """A quantity of the whole team over time.

    Attributes:
        name: With its unit.
        time: `(K,)` s.
        values: `(K,)`; nan where there is none.
        limit: What it should stay above, None without one.
    """

    name: str
    time: Array
    values: Array
    limit: float | None = None


def curves_of(result: Result) -> tuple[Curve, ...]:
    """What there is to see of a run over time; of a plan nothing but speeds and distances."""
    recording = result.recording if result.recording is not None else _sampled(result)
    if len(recording.time) < 2:
        return ()
    kept = np.unique(np.linspace(0, len(recording.time) - 1, _MOST_SAMPLES).round().astype(int))
    thin = replace(
        recording,
        time=recording.time[kept],
        poses=recording.poses[kept],
        estimated=recording.estimated[kept],
        commands=recording.commands[kept],
        status=tuple(recording.status[k] for k in kept) if recording.status else (),
        physics=None,
    )
    scene = Scene(result.scenario, result.start, thin)
    radius = None if result.scenario.goals else scene.radius
    found = [
        Curve("closest obstacle (m)", thin.time, obstacle_distances(scene).min(axis=1), radius)
    ]
    if scene.size > 1:
        nearest = neighbour_distances(thin.poses).min(axis=1)
        limit = None if radius is None else 2.0 * radius
        found.append(Curve("closest robots (m)", thin.time, nearest, limit))
    errors = _formation_errors(thin)
    if errors is not None:
        found.append(Curve("formation error (m)", thin.time, errors))
    found.append(Curve("fastest robot (m/s)", thin.time, _speeds(recording, kept)))
    return tuple(found)


def _sampled(result: Result) -> Recording:
    """A plan as if it had been carried out."""
    player = result.player
    count = max(2, min(_MOST_SAMPLES, int((player.end - player.begin) / 0.05) + 2))
    time = np.linspace(player.begin, player.end, count)
    poses = np.array([player.at(float(one)).poses for one in time])
    return Recording(time, poses, poses, np.zeros_like(poses), (), (), ())


def _formation_errors(recording: Recording) -> Array | None:
    """`(K,)` m: the mean distance to the own slot of the best placement of the shape."""
    slots = np.zeros((*recording.poses.shape[:2], 2))
    taking_part = np.zeros(slots.shape[:2], dtype=bool)
    for k, status in enumerate(recording.status):
        has_slot = (status.roles >= 0) & (status.roles < len(status.slots))
        taking_part[k] = has_slot
        slots[k, has_slot] = status.slots[status.roles[has_slot]]
    count = taking_part.sum(axis=1)
    if not count.any():
        return None
    errors = placement_errors(recording.poses[..., :2], slots, taking_part).sum(axis=1)
    return np.where(count > 0, errors / np.maximum(count, 1), np.nan)


def _speeds(recording: Recording, kept: Array) -> Array:
    """`(K,)` m/s over ground, of the fastest robot, as a mean over half a second."""
    time = recording.time
    ahead = np.searchsorted(time, time[kept] + 0.25).clip(0, len(time) - 1)
    behind = np.searchsorted(time, time[kept] - 0.25).clip(0, len(time) - 1)
    gone = recording.poses[ahead, :, :2] - recording.poses[behind, :, :2]
    elapsed = np.maximum(time[ahead] - time[behind], 1e-9)
    return np.asarray((np.hypot(gone[..., 0], gone[..., 1]) / elapsed[:, None]).max(axis=1))
