"""Kernels that join two states by few moves: turns on the spot, straights and arcs.

The words: turn-straight-turn between states at rest; the four arc-straight-arc words of Dubins
(Am. J. Math. 79, 1957); arc-straight and then a turn on the spot where the end is at rest;
a turn on the spot and then straight-arc where the start is at rest.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.lattice.primitives import (
    ACCELERATION,
    BACK_SPEED,
    BACKWARDS,
    DURATION,
    FREE,
    RADIUS,
    SPEED,
    make_move,
    trapezoid,
)

MOST_WORDS, MOST_MOVES = 16, 5


@njit(cache=True)
def _turned(angle):
    """The angle in [0, 2 pi); those within rounding of a whole turn are none."""
    angle = angle % (2.0 * math.pi)
    return 0.0 if angle > 2.0 * math.pi - 1e-9 else angle


@njit(cache=True)
def _wrapped(angle):
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@njit(cache=True)
def backward_factor(mover):
    """What a metre backwards costs, in metres: robots that are slow that way should not like it."""
    return 4.0 if mover[BACK_SPEED] < mover[SPEED] else 1.0


@njit(cache=True)
def _lay(words, counts, costs, number, first, parts, last, v0, v1, mover, price):
    """Write a word of at most five moves as number `number`; the new number of words.

    `first` and `last` are turns on the spot, `parts` `(3, 2)` lengths and turns driven in between.
    """
    total = abs(parts[0, 0]) + abs(parts[1, 0]) + abs(parts[2, 0])
    ahead = parts[0, 0] >= 0.0 and parts[1, 0] >= 0.0 and parts[2, 0] >= 0.0
    a, vmax = mover[ACCELERATION], mover[SPEED] if ahead else mover[BACK_SPEED]
    duration, peak = trapezoid(total, v0, v1, vmax, a)
    if duration < 0.0 or number >= words.shape[0]:
        return number
    count = 0
    cost = price * total * (1.0 if ahead else backward_factor(mover))
    if abs(first) > 1e-9:
        make_move(words[number, count], 0.0, first, 0.0, 0.0, 0.0, mover)
        cost += words[number, count, DURATION]
        count += 1
    way, speed = 0.0, v0
    for k in range(3):
        length = abs(parts[k, 0])
        if length < 1e-9:
            continue
        way += length
        left = max(total - way, 0.0)
        after = min(peak, math.sqrt(v0 * v0 + 2.0 * a * way))
        after = min(after, math.sqrt(v1 * v1 + 2.0 * a * left))
        if left < 1e-9:
            after = v1
        if not make_move(words[number, count], parts[k, 0], parts[k, 1], speed, after, peak, mover):
            return number
        cost += words[number, count, DURATION]
        speed = after
        count += 1
    if abs(last) > 1e-9:
        make_move(words[number, count], 0.0, last, 0.0, 0.0, 0.0, mover)
        cost += words[number, count, DURATION]
        count += 1
    counts[number], costs[number] = count, cost
    return number + 1


@njit(cache=True)
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


@njit(cache=True)
def _dubins(word, dx, dy, yaw0, yaw1, radius, parts):
    """The arc-straight-arc word 0 LSL, 1 RSR, 2 LSR, 3 RSL as `parts`; False if there is none."""
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


@njit(cache=True)
def connect(a, v0, b, v1, mover, price, words, counts, costs):
    """All words from state `a` (x, y, yaw) at speed v0 to `b` at v1; how many there are.

    Moving states go forwards.

    Args:
        price: Cost of a metre; that of a second is 1.
        words: `(MOST_WORDS, MOST_MOVES, 6)` to fill; `counts`, `costs` `(MOST_WORDS,)`.
    """
    number = 0
    dx, dy = b[0] - a[0], b[1] - a[1]
    distance = math.sqrt(dx * dx + dy * dy)
    parts = np.zeros((3, 2))
    if v0 == 0.0 and v1 == 0.0:
        bearing = math.atan2(dy, dx) if distance > 1e-9 else a[2]
        parts[1, 0] = distance
        last = _wrapped(b[2] - bearing)
        first = _wrapped(bearing - a[2])
        number = _lay(words, counts, costs, number, first, parts, last, v0, v1, mover, price)
        if mover[BACKWARDS] >= distance > 1e-9:
            parts[1, 0] = -distance
            first, last = _wrapped(bearing + math.pi - a[2]), _wrapped(b[2] - bearing - math.pi)
            number = _lay(words, counts, costs, number, first, parts, last, v0, v1, mover, price)
    radius = mover[RADIUS]
    if mover[FREE] > 0.0 or radius <= 0.0 or distance < 1e-9:
        return number
    for word in range(4):
        if _dubins(word, dx, dy, a[2], b[2], radius, parts):
            number = _lay(words, counts, costs, number, 0.0, parts, 0.0, v0, v1, mover, price)
    for side in (1, -1):
        if v1 == 0.0:
            turn, straight = _arc_then_straight(dx, dy, a[2], radius, side)
            if straight >= 0.0:
                parts[:] = 0.0
                parts[0, 0], parts[0, 1], parts[1, 0] = abs(turn) * radius, turn, straight
                last = _wrapped(b[2] - a[2] - turn)
                number = _lay(words, counts, costs, number, 0.0, parts, last, v0, v1, mover, price)
        if v0 == 0.0:
            turn, straight = _arc_then_straight(-dx, -dy, b[2] + math.pi, radius, side)
            if straight >= 0.0:
                parts[:] = 0.0
                parts[1, 0], parts[2, 0], parts[2, 1] = straight, abs(turn) * radius, -turn
                first = _wrapped(b[2] + turn - a[2])
                number = _lay(words, counts, costs, number, first, parts, 0.0, v0, v1, mover, price)
    if mover[BACKWARDS] == math.inf and v0 == 0.0 and v1 == 0.0:
        for word in range(4):
            if _dubins(word, dx, dy, a[2] + math.pi, b[2] + math.pi, radius, parts):
                parts[:, 0] *= -1.0
                number = _lay(words, counts, costs, number, 0.0, parts, 0.0, v0, v1, mover, price)
    return number
