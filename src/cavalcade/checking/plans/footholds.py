"""Footholds: on the ground, on ground that carries, within reach, and none in flight.

Legs are numbered front left, front right, rear left, rear right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.heights import Ground
from cavalcade.checking.plans.body import GROUND_BAND, LEAST_TRAVERSABILITY
from cavalcade.checking.plans.motion import FLIGHT, LANDING, TAKE_OFF, Motion
from cavalcade.checking.report import Violation
from cavalcade.checking.stretches import stretches
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


def check_footholds(motion: Motion, legs: LegModel, ground: Ground | None) -> list[Violation]:
    """What is wrong with a legged robot's footholds; None is level ground at height 0."""
    if not len(motion.footholds):
        text = f"robot {motion.robot} has no footholds"
        return [Violation("foothold", 0.0, (motion.robot,), text, 0.0, 1.0)]
    malformed = _malformed(motion)
    if malformed:
        return malformed
    return (
        _order(motion)
        + _on_ground(motion, ground)
        + _in_flight(motion)
        + _unsupported(motion)
        + _out_of_reach(motion, legs, ground)
    )


def _violation(motion: Motion, k: int, text: str, value: float, limit: float) -> Violation:
    time, leg = float(motion.footholds[k, 0]), int(motion.footholds[k, 2])
    said = f"robot {motion.robot}: the foot of leg {leg} put down at {time:.2f} s {text}"
    return Violation("foothold", time, (motion.robot,), said, value, limit)


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
        if len(twice):
            k = int(twice[0])
            text = "comes before the leg has left its last place"
            return [_violation(motion, int(mine[k + 1]), text, float(down[k + 1]), float(up[k]))]
    return []


def _on_ground(motion: Motion, ground: Ground | None) -> list[Violation]:
    place, height = motion.footholds[:, 3:5], motion.footholds[:, 5]
    if ground is None:
        low = high = np.zeros(len(height))
    else:
        low, high = ground.range_at(place)
    away = np.maximum(np.maximum(low - height, height - high), 0.0)
    result = [
        _violation(motion, k, f"is {away[k]:.3f} m off the ground", away[k], 0.0)
        for k in np.flatnonzero(away > ON_GROUND)[:1]
    ]
    if ground is not None:
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
        if len(stand):
            k = int(stand[0])
            text = f"stands in the flight of {begin:.2f} to {end:.2f} s"
            return [_violation(motion, k, text, float(up[k]), begin)]
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
            gap = float(begin) - reached
            return [Violation("foothold", reached, (motion.robot,), text, gap, UNSUPPORTED)]
        reached = max(reached, float(end))
    return []


def _out_of_reach(motion: Motion, legs: LegModel, ground: Ground | None) -> list[Violation]:
    """The longest way from hip to foot over each stance, at the samples within it."""
    first = np.searchsorted(motion.time, motion.footholds[:, 0] - _TINY)
    last = np.searchsorted(motion.time, motion.footholds[:, 1] + _TINY)
    count = np.maximum(last - first, 0)
    which = np.repeat(np.arange(len(count)), count)
    sample = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    sample = sample + np.repeat(first, count)
    leg = motion.footholds[which, 2].astype(np.int64)
    away = _distances(motion, legs, ground, which, sample)
    away = np.where(_needed(motion.phase[sample], leg), away, 0.0)
    limit = STRETCH * legs.h_max
    longest = np.zeros(len(count))
    np.maximum.at(longest, which, away)
    wrong = np.flatnonzero(longest > limit)
    if not len(wrong):
        return []
    k = int(wrong[0])
    moment = float(motion.time[sample[(which == k) & (away > limit)][0]])
    text = f"is {longest[k]:.3f} m from its hip; the leg reaches {limit:.3f} m"
    found = _violation(motion, k, text, float(longest[k]), limit)
    return [replace(found, time=moment)]


def _needed(phase: NDArray[np.int64], leg: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether the leg must reach: in take-off the front, in landing the rear may hang."""
    hanging = ((phase == TAKE_OFF) & (leg < 2)) | ((phase == LANDING) & (leg >= 2))
    return ~hanging & (phase != FLIGHT)


def _distances(
    motion: Motion,
    legs: LegModel,
    ground: Ground | None,
    which: NDArray[np.int64],
    sample: NDArray[np.int64],
) -> Array:
    """Of foot `which` `(K,)` from its leg's hip at samples `(K,)`, m."""
    leg = motion.footholds[which, 2].astype(np.int64)
    place, yaw = motion.position[sample], motion.yaw[sample]
    forward, left = legs.hip_x * _FORWARD[leg], legs.hip_y * _LEFT[leg]
    x = place[:, 0] + np.cos(yaw) * forward - np.sin(yaw) * left
    y = place[:, 1] + np.sin(yaw) * forward + np.cos(yaw) * left
    z = place[:, 2]
    if ground is not None:
        z = z + ground.slope_at(place[:, :2], yaw) * forward
    foot = motion.footholds[which, 3:]
    return np.sqrt((x - foot[:, 0]) ** 2 + (y - foot[:, 1]) ** 2 + (z - foot[:, 2]) ** 2)
