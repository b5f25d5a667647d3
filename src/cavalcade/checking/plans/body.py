"""The body over the ground: belly clearance, reach of the legs, ground that carries.

Heights are of the body's centre. The trunk's four lower corners and the middle between them keep
the least clearance in all phases; hips stay within the legs' reach of ground that carries while
their legs push: all in walking, the rear ones in take-off, the front ones in landing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.distance import beside
from cavalcade.checking.ground import Floor
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


def check_body(motion: Motion, legs: LegModel, ground: Floor) -> tuple[list[Violation], float]:
    """What contradicts the ground around the motion; the belly's least clearance over it, m."""
    pitches = _pitches(motion, ground)
    clear = np.stack([_clearance(motion, legs, ground, pitch) for pitch in pitches])
    clearance = np.where(motion.phase == WALK, clear[0], clear.max(axis=0))
    words = "has its belly {value:.3f} m above the ground; the least is {limit:.3f} m"
    short = legs.h_min - clearance - BELLY_SLACK
    result = motion.excesses("belly", clearance, legs.h_min, words, excess=short)
    for end, name in ((1.0, "front"), (-1.0, "rear")):
        pushing = _pushing(motion, end)
        high = np.stack([_hip_heights(motion, legs, ground, p, end) for p in pitches])
        most = np.where(motion.phase == WALK, high[0], high.min(axis=0))
        words = f"has a {name} hip {{value:.3f}} m above the ground; legs reach {{limit:.3f}} m"
        high = np.where(pushing, most, 0.0)
        result += motion.excesses("reach", high, legs.h_max, words, REACH_SLACK)
    return result + _carried(motion, legs, ground), float(clearance.min())


def _carried(motion: Motion, legs: LegModel, ground: Floor) -> list[Violation]:
    """Walking over, or pushing from, ground that carries nobody."""
    place = motion.position[:, :2]
    worst = np.where(motion.phase == WALK, ground.best_at(place), 1.0)
    for end in (1.0, -1.0):
        hips = ground.best_at(_hips(motion, legs, end)).min(axis=1)
        worst = np.where(_pushing(motion, end), np.minimum(worst, hips), worst)
    words = "stands on ground of traversability {value:.2f}; the least is {limit:.2f}"
    short = LEAST_TRAVERSABILITY - worst - GROUND_BAND
    return motion.excesses("traversability", worst, LEAST_TRAVERSABILITY, words, excess=short)


def _pushing(motion: Motion, end: float) -> Bools:
    """`(T,)` whether the legs in front (1) or behind (-1) push.

    A sample at the end of a leap's phase belongs to the phase before as well, which ends there;
    only the phase after is asked.
    """
    leap = TAKE_OFF if end < 0.0 else LANDING
    return (motion.phase == WALK) | (motion.phase == leap)


def _pitches(motion: Motion, ground: Floor) -> tuple[Array, ...]:
    """Pitches `(T,)` in rad, nose up, that the body may have: first along the ground.

    What a body does in a leap the plan does not say: it may follow the ground, be level, or go
    evenly from what it was before to what it is after.
    """
    follow: Array = np.arctan(ground.slope_at(motion.position[:, :2], motion.yaw))
    if not follow.any():
        return (follow,)
    level, walking = np.zeros(len(follow)), motion.phase == WALK
    if not walking.any():
        return follow, level
    return follow, level, np.interp(motion.time, motion.time[walking], follow[walking])


def _clearance(motion: Motion, legs: LegModel, ground: Floor, pitch: Array) -> Array:
    """`(T,)` m, of the lowest of the five points, over the ground below it."""
    x = legs.trunk_length / 2.0 * np.array([1.0, 1.0, -1.0, -1.0, 0.0])
    y = legs.trunk_width / 2.0 * np.array([1.0, -1.0, -1.0, 1.0, 0.0])
    sine, cosine = np.sin(pitch)[:, None], np.cos(pitch)[:, None]
    down = -legs.trunk_height / 2.0
    forward = cosine * x - sine * down
    height = motion.position[:, 2, None] + sine * x + cosine * down
    below = ground.heights_at(beside(motion.track.pose, forward, y))
    return (height - below).min(axis=1)


def _hip_heights(motion: Motion, legs: LegModel, ground: Floor, pitch: Array, end: float) -> Array:
    """`(T,)` of the higher of both hips at one end, above the ground, m."""
    height = motion.position[:, 2] + np.sin(pitch) * end * legs.hip_x
    below = ground.highest_at(_hips(motion, legs, end, np.cos(pitch)), NEARBY)
    return (height[:, None] - below).max(axis=1)


def _hips(motion: Motion, legs: LegModel, end: float, shortened: Array | float = 1.0) -> Array:
    """`(T, 2, 2)` places of the hips at one end, seen from above.

    Pitch shortens the body, seen so, by the factor `shortened` `(T,)`.
    """
    forward = np.broadcast_to(end * legs.hip_x * np.asarray(shortened), len(motion.time))
    return beside(motion.track.pose, forward[:, None], legs.hip_y * np.array([1.0, -1.0]))
