"""Figures written flat on the ground, as strokes: they turn and shrink with it."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array

# Places of a grid three wide and five high, numbered by rows from the lower left corner.
_STROKES = {
    "0": ("0-2-14-12-0",),
    "1": ("9-13-1", "0-2"),
    "2": ("12-14-8-6-0-2",),
    "3": ("12-14-2-0", "6-8"),
    "4": ("12-6-8", "14-2"),
    "5": ("14-12-6-8-2-0",),
    "6": ("14-12-0-2-8-6",),
    "7": ("12-14-1",),
    "8": ("0-2-14-12-0", "6-8"),
    "9": ("0-2-14-12-6-8",),
    "-": ("6-8",),
    "m": ("0-6-8-2", "1-7"),
    " ": (),
}
_ADVANCE = 3.4
"""From one sign to the next, in steps of the grid."""


def written(text: str, place: Array, height: float, align: float = 0.5) -> Array:
    """Segments `(K, 2, 2)` of a text whose upper edge is at `place` `(2,)`, m.

    Args:
        text: Digits, `-`, `m` and blanks.
        place: m.
        height: Of the signs, m.
        align: Which share of the text's width is left of the place.
    """
    step = height / 4.0
    width = step * (_ADVANCE * (len(text) - 1) + 2.0)
    corner = np.asarray(place, dtype=float) - (align * width, height)
    segments = []
    for number, sign in enumerate(text):
        for stroke in _STROKES[sign]:
            index = np.array([int(part) for part in stroke.split("-")])
            points = np.column_stack([index % 3 + number * _ADVANCE, index // 3]) * step + corner
            segments.append(np.stack([points[:-1], points[1:]], axis=1))
    return np.concatenate(segments) if segments else np.zeros((0, 2, 2))
