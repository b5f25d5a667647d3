"""Footholds: on the ground, on ground that carries, within reach, and none in flight.

Legs are numbered front left, front right, rear left, rear right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cavalcade.checking.distance import beside
from cavalcade.checking.ground import Floor, Indices
from cavalcade.checking.plans.body import GROUND_BAND, LEAST_TRAVERSABILITY
from cavalcade.checking.plans.motion import FLIGHT, LANDING, TAKE_OFF, Motion
from cavalcade.checking.report import Violation, broken, stretches
from cavalcade.geometry import Array
from cavalcade.robots.model import LegModel

STRETCH = 1.2
"""A stretched leg as a multiple of the reach that plans leave it: thigh and shank of Go1 measure
0.43 m together, of Spirit 0.41 m, and plans count on 0.375 m."""

ON_GROUND = 0.01
"""How far a foothold may lie above or below the ground around it, m."""

UNSUPPORTED = 0.06
"""How long no foot may stand while the body does not fly, s."""

_TINY = 1e-6
_FORWARD = np.array([1.0, 1.0, -1.0, -1.0])
_LEFT = np.array([1.0, -1.0, 1.0, -1.0])


def check_footholds(motion: Motion, legs: LegModel, ground: Floor) -> list[Violation]:
    """What is wrong with a legged robot's footholds."""
    if not len(motion.footholds):
        text = f"robot {motion.robot} has no footholds"
        return [broken("foothold", 0.0, motion.robot, text, 0.0, 1.0)]
    return _malformed(motion) or (
        _order(motion)
        + _on_ground(motion, ground)
        + _in_flight(motion)
        + _unsupported(motion)
        + _out_of_reach(motion, legs, ground)
    )


def _violation(motion: Motion, k: int, text: str, value: float, limit: float) -> Violation:
    time, _, leg = motion.footholds[k, :3]
    said = f"robot {motion.robot}: the foot of leg {int(leg)} put down at {time:.2f} s {text}"
    return broken("foothold", time, motion.robot, said, value, limit)


def _malformed(motion: Motion) -> list[Violation]:
    down, up, leg = motion.footholds[:, :3].T
    result = []
    for k in np.flatnonzero(~np.isin(leg, range(4)))[:1]:
        result.append(_violation(motion, k, "belongs to no leg", leg[k], 3.0))
    for k in np.flatnonzero(up < down - _TINY)[:1]:
        result.append(_violation(motion, k, "leaves before it comes", up[k], down[k]))
    return result


def _order(motion: Motion) -> list[Violation]:
    """No leg stands in two places at a time."""
    for leg in range(4):
        mine = np.flatnonzero(motion.footholds[:, 2] == leg)
        mine = mine[np.argsort(motion.footholds[mine, 0], kind="stable")]
        down, up = motion.footholds[mine, 0], motion.footholds[mine, 1]
        twice = np.flatnonzero(down[1:] < up[:-1] - _TINY)
        for k in twice[:1]:
            text = "comes before the leg has left its last place"
            return [_violation(motion, mine[k + 1], text, down[k + 1], up[k])]
    return []


def _on_ground(motion: Motion, ground: Floor) -> list[Violation]:
    place, height = motion.footholds[:, 3:5], motion.footholds[:, 5]
    low, high = ground.range_at(place)
    away = np.maximum(np.maximum(low - height, height - high), 0.0)
    result = [
        _violation(motion, k, f"is {away[k]:.3f} m off the ground", away[k], 0.0)
        for k in np.flatnonzero(away > ON_GROUND)[:1]
    ]
    best, least = ground.best_at(place), LEAST_TRAVERSABILITY
    for k in np.flatnonzero(best < least - GROUND_BAND)[:1]:
        text = f"is on ground of traversability {best[k]:.2f}; the least is {least}"
        result.append(_violation(motion, k, text, best[k], least))
    return result


def _in_flight(motion: Motion) -> list[Violation]:
    """No foot stands while the body flies."""
    down, up = motion.footholds[:, 0], motion.footholds[:, 1]
    for begin, end in _flights(motion):
        stand = np.flatnonzero(np.minimum(up, end) - np.maximum(down, begin) > _TINY)
        for k in stand[:1]:
            text = f"stands in the flight of {begin:.2f} to {end:.2f} s"
            return [_violation(motion, k, text, up[k], begin)]
    return []


def _flights(motion: Motion) -> list[tuple[float, float]]:
    flying = stretches(motion.phase[:-1] == FLIGHT)
    return [(float(motion.time[begin]), float(motion.time[end])) for begin, end in flying]


def _unsupported(motion: Motion) -> list[Violation]:
    """A body that does not fly stands on something."""
    stands = np.concatenate((motion.footholds[:, :2], np.array(_flights(motion)).reshape(-1, 2)))
    stands = stands[np.argsort(stands[:, 0], kind="stable")]
    reached = 0.0
    last = float(motion.time[-1])
    for begin, end in [*stands, (last, last)]:
        if begin - reached > UNSUPPORTED:
            text = f"robot {motion.robot} stands on no foot from {reached:.2f} to {begin:.2f} s"
            gap = begin - reached
            return [broken("foothold", reached, motion.robot, text, gap, UNSUPPORTED)]
        reached = max(reached, float(end))
    return []


def _out_of_reach(motion: Motion, legs: LegModel, ground: Floor) -> list[Violation]:
    """The longest way from hip to foot over each stance, at the samples within it."""
    first = np.searchsorted(motion.time, motion.footholds[:, 0] - _TINY)
    last = np.searchsorted(motion.time, motion.footholds[:, 1] + _TINY)
    count = np.maximum(last - first, 0)
    which = np.repeat(np.arange(len(count)), count)
    sample = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    sample = sample + np.repeat(first, count)
    leg = motion.footholds[which, 2].astype(np.int64)
    # In take-off the front legs, in landing the rear ones may hang, and all in flight.
    phase = motion.phase[sample]
    hanging = ((phase == TAKE_OFF) & (leg < 2)) | ((phase == LANDING) & (leg >= 2))
    hanging |= phase == FLIGHT
    away = np.where(hanging, 0.0, _distances(motion, legs, ground, which, sample))
    limit = STRETCH * legs.h_max
    longest = np.zeros(len(count))
    np.maximum.at(longest, which, away)
    wrong = np.flatnonzero(longest > limit)
    if not len(wrong):
        return []
    k = wrong[0]
    moment = float(motion.time[sample[(which == k) & (away > limit)][0]])
    text = f"is {longest[k]:.3f} m from its hip; the leg reaches {limit:.3f} m"
    return [replace(_violation(motion, k, text, longest[k], limit), time=moment)]


def _distances(
    motion: Motion, legs: LegModel, ground: Floor, which: Indices, sample: Indices
) -> Array:
    """Of foot `which` `(K,)` from its leg's hip at samples `(K,)`, m."""
    leg = motion.footholds[which, 2].astype(np.int64)
    foot, pose = motion.footholds[which, 3:], motion.track.pose[sample]
    forward, left = legs.hip_x * _FORWARD[leg], legs.hip_y * _LEFT[leg]
    x, y = beside(pose, forward[:, None], left[:, None])[:, 0].T
    z = motion.position[sample, 2] + ground.slope_at(pose[:, :2], pose[:, 2]) * forward
    return np.sqrt((x - foot[:, 0]) ** 2 + (y - foot[:, 1]) ** 2 + (z - foot[:, 2]) ** 2)
