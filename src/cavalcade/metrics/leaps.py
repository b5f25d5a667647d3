"""What cannot have been motion between the samples of live robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import wrap_angle
from cavalcade.recording.frames import Recording
from cavalcade.robots import RobotModel

GAP = 0.5
"""Samples are at most so far apart, s, or two cycles; the checker's figure, on purpose not shared,
as those below."""

FASTER = 3.0
"""Nobody goes or turns faster than so many times its limit,"""

FARTHER = (0.5, 1.0)
"""and further than so much beyond that, m and rad."""


def leaps(recording: Recording, models: Sequence[RobotModel], rate: float) -> NDArray[np.bool_]:
    """`(T - 1, N)` whether each robot cannot have gone from one sample to the next.

    A simulation or a localisation was restarted there, or fell silent: what was between, nobody
    knows. Cycles come at `rate`, Hz.
    """
    lasted = np.diff(recording.time)[:, None]
    change = np.diff(recording.poses, axis=0)
    speed = np.array([max(model.max_speed_x, model.max_speed_y) for model in models])
    turning = np.array([model.max_yaw_rate for model in models])
    gap = lasted > max(2.0 / rate, GAP) * (1.0 + 1e-3)
    moved = np.hypot(change[..., 0], change[..., 1])
    turned = np.abs(wrap_angle(change[..., 2]))
    far = moved > FASTER * speed * lasted + FARTHER[0]
    found: NDArray[np.bool_] = gap | far | (turned > FASTER * turning * lasted + FARTHER[1])
    return found
