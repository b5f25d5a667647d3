"""Which shapes may touch: robots each other and the world, never themselves.

MuJoCo lets two shapes touch if the `contype` bits of one meet the `conaffinity` bits of the other.
Bit 0 is the world's. Robots get sets of equally many of the other bits, no two the same, and ask
for all bits but their own: two different sets of one size never lie in each other, so two robots
always meet, and one never meets itself. Sets of one bit serve 30 robots, of two 435, and so on.
"""

from __future__ import annotations

import itertools
import math

BITS = 30
"""Bits for robots; the 32nd is the sign."""

WORLD_TYPE, WORLD_AFFINITY = 1, 0
"""Of the ground and obstacles, which do not touch each other."""


def robot_bits(robots: int) -> list[tuple[int, int]]:
    """`contype` and `conaffinity` of each of so many robots."""
    size = next(size for size in range(1, BITS) if math.comb(BITS, size) >= robots)
    everything = 2 ** (BITS + 1) - 1
    sets = itertools.islice(itertools.combinations(range(1, BITS + 1), size), robots)
    codes = [sum(1 << bit for bit in chosen) for chosen in sets]
    return [(code, everything & ~code) for code in codes]
