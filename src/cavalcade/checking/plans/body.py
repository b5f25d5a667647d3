"""The body over the ground: belly clearance, reach of the legs, ground that carries.

Heights are of the body's centre. The trunk's four lower corners and the middle between them keep
the least clearance in all phases; hips stay within the legs' reach of ground that carries while
their legs push: all in walking, the rear ones in take-off, the front ones in landing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.heights import Ground
from cavalcade.checking.plans.motion import LANDING, TAKE_OFF, WALK, Motion
from cavalcade.checking.report import Violation
from cavalcade.geometry import Array
from cavalcade.robots.model import LegModel

LEAST_TRAVERSABILITY = 0.3

BELLY_SLACK = 0.01
"""Of the belly's clearance, m."""

REACH_SLACK = 0.02
"""Of the legs' reach, m."""

GROUND_BAND = 0.05
"""Of traversability, beside taking the best of the nine cells around."""

NEARBY = 0.05
"""Legs may reach for the highest ground this near, m."""

Bools = NDArray[np.bool_]


def check_body(
    motion: Motion, legs: LegModel, ground: Ground | None, clearance: Array
) -> list[Violation]:
    """What contradicts the ground around the motion; None is level ground at height 0.

    `clearance` `(T,)` m is that of `belly_clearance`.
    """
    words = "has its belly {value:.3f} m above the ground; the least is {limit:.3f} m"
    low = motion.shortfalls("belly", clearance, legs.h_min, words, BELLY_SLACK)
    return low + _reach(motion, legs, ground) + _carried(motion, legs, ground)


def belly_clearance(motion: Motion, legs: LegModel, ground: Ground | None) -> Array:
    """`(T,)` m, of the lowest of the five points, over the ground below it."""
    pitches = _pitches(motion, ground)
    clear = np.stack([_clearance(motion, legs, ground, pitch) for pitch in pitches])
    return np.where(motion.phase == WALK, clear[0], clear.max(axis=0))


def _reach(motion: Motion, legs: LegModel, ground: Ground | None) -> list[Violation]:
    """Hips too high above the ground that their legs push."""
    pitches = _pitches(motion, ground)
    result = []
    for end, name in ((1.0, "front"), (-1.0, "rear")):
        pushing = _pushing(motion, end)
        high = np.stack([_hip_heights(motion, legs, ground, p, end) for p in pitches])
        most = np.where(motion.phase == WALK, high[0], high.min(axis=0))
        words = f"has a {name} hip {{value:.3f}} m above the ground; legs reach {{limit:.3f}} m"
        high = np.where(pushing, most, 0.0)
        result += motion.excesses("reach", high, legs.h_max, words, REACH_SLACK)
    return result


def _carried(motion: Motion, legs: LegModel, ground: Ground | None) -> list[Violation]:
    """Walking over, or pushing from, ground that carries nobody."""
    if ground is None:
        return []
    place = motion.position[:, :2]
    worst = np.where(motion.phase == WALK, ground.best_at(place), 1.0)
    for end in (1.0, -1.0):
        hips = ground.best_at(_hips(motion, legs, end)).min(axis=1)
        worst = np.where(_pushing(motion, end), np.minimum(worst, hips), worst)
    words = "stands on ground of traversability {value:.2f}; the least is {limit:.2f}"
    return motion.shortfalls("traversability", worst, LEAST_TRAVERSABILITY, words, GROUND_BAND)


def _pushing(motion: Motion, end: float) -> Bools:
    """`(T,)` whether the legs in front (1) or behind (-1) push.

    A sample at the end of a leap's phase belongs to the phase before as well, which ends there;
    only the phase after is asked.
    """
    leap = TAKE_OFF if end < 0.0 else LANDING
    return (motion.phase == WALK) | (motion.phase == leap)


def _pitches(motion: Motion, ground: Ground | None) -> tuple[Array, ...]:
    """Pitches `(T,)` in rad, nose up, that the body may have: first along the ground.

    What a body does in a leap the plan does not say: it may follow the ground, be level, or go
    evenly from what it was before to what it is after.
    """
    level = np.zeros(len(motion.time))
    if ground is None:
        return (level,)
    follow: Array = np.arctan(ground.slope_at(motion.position[:, :2], motion.yaw))
    walking = motion.phase == WALK
    if not walking.any():
        return follow, level
    return follow, level, np.interp(motion.time, motion.time[walking], follow[walking])


def _clearance(motion: Motion, legs: LegModel, ground: Ground | None, pitch: Array) -> Array:
    x = legs.trunk_length / 2.0 * np.array([1.0, 1.0, -1.0, -1.0, 0.0])
    y = legs.trunk_width / 2.0 * np.array([1.0, -1.0, -1.0, 1.0, 0.0])
    sine, cosine = np.sin(pitch)[:, None], np.cos(pitch)[:, None]
    down = -legs.trunk_height / 2.0
    forward = cosine * x - sine * down
    height = motion.position[:, 2, None] + sine * x + cosine * down
    below = 0.0 if ground is None else ground.heights_at(_beside(motion, forward, y))
    return (height - below).min(axis=1)


def _hip_heights(
    motion: Motion, legs: LegModel, ground: Ground | None, pitch: Array, end: float
) -> Array:
    """`(T,)` of the higher of both hips at one end, above the ground, m."""
    height = motion.position[:, 2] + np.sin(pitch) * end * legs.hip_x
    if ground is None:
        return height
    below = ground.highest_at(_hips(motion, legs, end, np.cos(pitch)), NEARBY)
    return (height[:, None] - below).max(axis=1)


def _hips(motion: Motion, legs: LegModel, end: float, shortened: Array | float = 1.0) -> Array:
    """`(T, 2, 2)` places of the hips at one end, seen from above.

    Pitch shortens the body, seen so, by the factor `shortened` `(T,)`.
    """
    forward = np.broadcast_to(end * legs.hip_x * np.asarray(shortened), len(motion.time))
    forward = np.repeat(forward[:, None], 2, axis=1)
    return _beside(motion, forward, legs.hip_y * np.array([1.0, -1.0]))


def _beside(motion: Motion, forward: Array, left: Array) -> Array:
    """`(T, K, 2)` places beside the centre: `(T, K)` m forward, `(K,)` to the left."""
    c, s = np.cos(motion.yaw)[:, None], np.sin(motion.yaw)[:, None]
    x = motion.position[:, 0, None] + c * forward - s * left
    y = motion.position[:, 1, None] + s * forward + c * left
    return np.stack((x, y), axis=-1)
