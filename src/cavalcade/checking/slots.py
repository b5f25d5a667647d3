"""Where the slots of a formation lie: a second reading of the scenario file's shapes.

Formation frame: x forward, y left, the origin at the formation's centre.
"""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array
from cavalcade.scenario import FormationSection


def slots_of(formation: FormationSection, robots: int) -> Array:
    """Slots `(robots, 2)` in m."""
    steps = np.arange(robots, dtype=float)
    if formation.slots is not None:
        return np.array(formation.slots, dtype=float)
    if formation.shape == "square":
        return _ring(4, _size(formation.side) / np.sqrt(2.0))
    if formation.shape == "triangle":
        return _ring(3, _size(formation.side) / np.sqrt(3.0))
    if formation.shape == "circle":
        return _ring(robots, _size(formation.radius) if robots > 1 else 0.0)
    spacing = _size(formation.spacing)
    middle = (robots - 1) / 2.0
    if formation.shape == "line":
        return np.column_stack((np.zeros(robots), (middle - steps) * spacing))
    if formation.shape == "column":
        return np.column_stack(((middle - steps) * spacing, np.zeros(robots)))
    # A wedge: two arms at right angles, the tip in front and on the axis, however long the arms.
    arm = np.ceil(steps / 2.0) * spacing / np.sqrt(2.0)
    side = np.where(steps % 2 == 1, 1.0, -1.0)
    return np.column_stack((arm.mean() - arm, side * arm))


def _ring(count: int, radius: float) -> Array:
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def _size(value: float | None) -> float:
    if value is None:
        raise ValueError("the scenario is not resolved")
    return value
