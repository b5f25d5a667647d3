"""Kernels that join two states by few moves: turns on the spot, straights and arcs.

A word is such a sequence of moves: turn-straight-turn between states at rest; the four
arc-straight-arc words of Dubins (Am. J. Math. 79, 1957); arc-straight and then a turn on the spot
where the end is at rest; a turn on the spot and then straight-arc where the start is at rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.kernels import subroutine
from cavalcade.lattice.primitives import DURATION, make_move, trapezoid

MOST_WORDS, MOST_MOVES = 16, 5

_LEAST = 1e-9
"""Places nearer than this are one, m: no part of a word is shorter."""


class Words(NamedTuple):
    """The words between two states, as `connect` writes them.

    Attributes:
        moves: `(MOST_WORDS, MOST_MOVES, 6)`.
        counts: `(MOST_WORDS,)` moves of each word; -1 once it was taken.
        costs: `(MOST_WORDS,)` seconds and the cost of the metres.
    """

    moves: Array
    counts: NDArray[np.int64]
    costs: Array


@subroutine
def no_words():
    """Empty tables to write words to."""
    return Words(
        np.empty((MOST_WORDS, MOST_MOVES, 6)),
        np.zeros(MOST_WORDS, dtype=np.int64),
        np.empty(MOST_WORDS),
    )


@subroutine
def take_cheapest(words, number):
    """The cheapest of the first `number` words that was not taken yet, and its number of moves.

    -1, 0 once all were taken.
    """
    pick = -1
    for k in range(number):
        if words.counts[k] >= 0 and (pick < 0 or words.costs[k] < words.costs[pick]):
            pick = k
    if pick < 0:
        return -1, 0
    count = words.counts[pick]
    words.counts[pick] = -1
    return pick, count


@subroutine
def _turned(angle):
    """The angle in [0, 2 pi); those within rounding of a whole turn are none."""
    angle = angle % (2.0 * math.pi)
    return 0.0 if angle > 2.0 * math.pi - 1e-9 else angle


@subroutine
def _wrapped(angle):
    """The angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@subroutine
def backward_factor(limits):
    """What a metre backwards costs, in metres: robots that are slow that way should not like it."""
    return 4.0 if limits.backward_speed < limits.speed else 1.0


@subroutine
def _lay(words, number, turns, parts, speeds, limits, metre_cost):
    """Write a word of at most five moves as number `number`; the new number of words.

    Args:
        turns: Turns on the spot at the start and at the end, rad.
        parts: `(3, 2)` lengths (m) and turns (rad) driven in between.
        speeds: At the start and at the end, m/s.
    """
    v0, v1 = speeds
    # What is too short to be driven does not count either: the last part driven ends at v1.
    total = 0.0
    for k in range(3):
        if abs(parts[k, 0]) >= _LEAST:
            total += abs(parts[k, 0])
    ahead = parts[0, 0] >= 0.0 and parts[1, 0] >= 0.0 and parts[2, 0] >= 0.0
    a, vmax = limits.acceleration, limits.speed if ahead else limits.backward_speed
    duration, peak = trapezoid(total, v0, v1, vmax, a)
    if duration < 0.0 or number >= words.moves.shape[0]:
        return number
    rows = words.moves[number]
    count = 0
    cost = metre_cost * total * (1.0 if ahead else backward_factor(limits))
    if abs(turns[0]) > 1e-9:
        make_move(rows[count], 0.0, turns[0], 0.0, 0.0, 0.0, limits)
        cost += rows[count, DURATION]
        count += 1
    # One trapezoid of speed over all parts: each ends as fast as both ends of the whole allow.
    gone, speed = 0.0, v0
    for k in range(3):
        length = abs(parts[k, 0])
        if length < _LEAST:
            continue
        gone += length
        left = max(total - gone, 0.0)
        after = min(peak, math.sqrt(v0 * v0 + 2.0 * a * gone))
        after = min(after, math.sqrt(v1 * v1 + 2.0 * a * left))
        if left < _LEAST:
            after = v1
        if not make_move(rows[count], parts[k, 0], parts[k, 1], speed, after, peak, limits):
            return number
        cost += rows[count, DURATION]
        speed = after
        count += 1
    if abs(turns[1]) > 1e-9:
        make_move(rows[count], 0.0, turns[1], 0.0, 0.0, 0.0, limits)
        cost += rows[count, DURATION]
        count += 1
    words.counts[number], words.costs[number] = count, cost
    return number + 1


@subroutine
def _arc_then_straight(dx, dy, yaw, radius, side):
    """Turn (signed) and straight length from the origin with heading `yaw` to (dx, dy); -1: none.

    side: 1 to turn left, -1 right.
    """
    cx, cy = -side * radius * math.sin(yaw), side * radius * math.cos(yaw)
    gx, gy = dx - cx, dy - cy
    square = gx * gx + gy * gy - radius * radius
    if square < -1e-9:  # beyond what rounding makes of circles that touch
        return 0.0, -1.0
    straight = math.sqrt(max(square, 0.0))
    heading = math.atan2(gy, gx) + side * math.atan2(radius, straight)
    return side * _turned(side * (heading - yaw)), straight


@subroutine
def _dubins(word, dx, dy, yaw0, yaw1, radius, parts):
    """The arc-straight-arc word 0 LSL, 1 RSR, 2 LSR, 3 RSL as `parts`; False if there is none.

    In the usual form: distances in radii, headings from the line between the two places. `t` and
    `q` are the angles of the arcs, `bend` the heading of the straight between them.
    """
    d = math.sqrt(dx * dx + dy * dy) / radius
    theta = math.atan2(dy, dx)
    alpha, beta = yaw0 - theta, yaw1 - theta
    sa, sb, ca, cb = math.sin(alpha), math.sin(beta), math.cos(alpha), math.cos(beta)
    cab = math.cos(alpha - beta)
    if word == 0:
        square = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb)
        bend = math.atan2(cb - ca, d + sa - sb)
        t, q = _turned(bend - alpha), _turned(beta - bend)
    elif word == 1:
        square = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa)
        bend = math.atan2(ca - cb, d - sa + sb)
        t, q = _turned(alpha - bend), _turned(bend - beta)
    elif word == 2:
        square = -2.0 + d * d + 2.0 * cab + 2.0 * d * (sa + sb)
        p = math.sqrt(max(square, 0.0))
        bend = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, p)
        t, q = _turned(bend - alpha), _turned(bend - beta)
    else:
        square = -2.0 + d * d + 2.0 * cab - 2.0 * d * (sa + sb)
        p = math.sqrt(max(square, 0.0))
        bend = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, p)
        t, q = _turned(alpha - bend), _turned(beta - bend)
    if square < -1e-9:
        return False
    first = 1.0 if word == 0 or word == 2 else -1.0
    last = 1.0 if word == 0 or word == 3 else -1.0
    parts[0, 0], parts[0, 1] = t * radius, first * t
    parts[1, 0], parts[1, 1] = math.sqrt(max(square, 0.0)) * radius, 0.0
    parts[2, 0], parts[2, 1] = q * radius, last * q
    return True


@subroutine
def connect(a, v0, b, v1, limits, metre_cost, words):
    """Write all words from pose `a` (x, y, yaw) at speed v0 to `b` at v1; how many there are.

    Moving states go forwards. A metre costs `metre_cost`, a second 1.
    """
    number = 0
    dx, dy = b[0] - a[0], b[1] - a[1]
    distance = math.sqrt(dx * dx + dy * dy)
    parts = np.zeros((3, 2))
    speeds, none = (v0, v1), (0.0, 0.0)
    # Turn, straight, turn; a short straight backwards, too.
    if v0 == 0.0 and v1 == 0.0:
        bearing = math.atan2(dy, dx) if distance >= _LEAST else a[2]
        parts[1, 0] = distance
        turns = (_wrapped(bearing - a[2]), _wrapped(b[2] - bearing))
        number = _lay(words, number, turns, parts, speeds, limits, metre_cost)
        if limits.backwards >= distance >= _LEAST:
            parts[1, 0] = -distance
            turns = (_wrapped(bearing + math.pi - a[2]), _wrapped(b[2] - bearing - math.pi))
            number = _lay(words, number, turns, parts, speeds, limits, metre_cost)
    radius = limits.radius
    if limits.free or radius <= 0.0 or distance < _LEAST:
        return number
    for word in range(4):
        if _dubins(word, dx, dy, a[2], b[2], radius, parts):
            number = _lay(words, number, none, parts, speeds, limits, metre_cost)
    # One arc, with a turn on the spot at the other end if the robot rests there.
    for side in (1, -1):
        if v1 == 0.0:
            turn, straight = _arc_then_straight(dx, dy, a[2], radius, side)
            if straight >= 0.0:
                parts[:] = 0.0
                parts[0, 0], parts[0, 1], parts[1, 0] = abs(turn) * radius, turn, straight
                turns = (0.0, _wrapped(b[2] - a[2] - turn))
                number = _lay(words, number, turns, parts, speeds, limits, metre_cost)
        if v0 == 0.0:
            turn, straight = _arc_then_straight(-dx, -dy, b[2] + math.pi, radius, side)
            if straight >= 0.0:
                parts[:] = 0.0
                parts[1, 0], parts[2, 0], parts[2, 1] = straight, abs(turn) * radius, -turn
                turns = (_wrapped(b[2] + turn - a[2]), 0.0)
                number = _lay(words, number, turns, parts, speeds, limits, metre_cost)
    # Wheels drive whole words backwards: those forwards between the poses turned round.
    if limits.backwards == math.inf and v0 == 0.0 and v1 == 0.0:
        for word in range(4):
            if _dubins(word, dx, dy, a[2] + math.pi, b[2] + math.pi, radius, parts):
                for k in range(3):
                    parts[k, 0] = -parts[k, 0]
                number = _lay(words, number, none, parts, speeds, limits, metre_cost)
    return number
