"""Which moments of a run tell its story."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing.scene import Scene
from cavalcade.geometry import Array


def choose_moments(scene: Scene, count: int = 6) -> NDArray[np.int64]:
    """Indices `(<= count,)` of cycles, rising: the start, the end and tellers in between.

    The moments are spread evenly over the way the team has gone, not over time, so that waiting
    does not fill panels. Each is then moved, by less than half the spacing, to the tightest
    moment or to just after a change of leader or state nearby.
    """
    cycles = len(scene.time)
    if cycles <= count:
        return np.arange(cycles)
    centre = np.median(scene.poses[..., :2], axis=1)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(centre, axis=0).T))])
    way = way + np.linspace(0.0, 1e-3 + 0.05 * way[-1], cycles)
    interest = _interest(scene)
    chosen = [0]
    for number in range(1, count - 1):
        target = way[-1] * number / (count - 1)
        window = way[-1] / (count - 1) * 0.4
        near = np.flatnonzero(np.abs(way - target) <= window)
        near = near[near > chosen[-1]]
        if len(near) == 0:
            near = np.array([min(chosen[-1] + 1, cycles - 1)])
        score = interest[near] - 0.3 * np.abs(way[near] - target) / window
        chosen.append(int(near[np.argmax(score)]))
    chosen.append(cycles - 1)
    return np.unique(chosen)


def _interest(scene: Scene) -> Array:
    """`(T,)` how much a cycle has to tell, about 0..1."""
    positions = scene.poses[..., :2]
    cycles = len(scene.time)
    interest = np.zeros(cycles)
    if scene.size > 1:
        offsets = positions - positions.mean(axis=1, keepdims=True)
        moments = np.einsum("tni,tnj->tij", offsets, offsets) / scene.size
        spread = np.linalg.eigvalsh(moments)
        # A line has a vanishing second moment: the tighter the place, the flatter the team.
        flatness = 1.0 - np.sqrt(np.maximum(spread[:, 0], 0.0) / np.maximum(spread[:, 1], 1e-9))
        interest += 0.5 * flatness
    step = float(np.median(np.diff(scene.time))) if cycles > 1 else 1.0
    lag = max(1, round(0.4 / max(step, 1e-6)))
    for before, after in ((i - 1, i) for i in range(1, cycles)):
        old, new = scene.status[before], scene.status[after]
        if old.leader != new.leader or old.state != new.state:
            interest[after : min(after + lag, cycles)] += 0.3
    return interest
