"""Random numbers whose state is passed in: SplitMix64 (Steele, Lea and Flood 2014)."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import subroutine

_STEP = np.uint64(0x9E3779B97F4A7C15)
_MIX1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX2 = np.uint64(0x94D049BB133111EB)


@subroutine
def uniform(rng):
    """The next number in [0, 1); `rng` is the state, uint64 `(1,)`, and moves on."""
    rng[0] += _STEP
    z = rng[0]
    z = (z ^ (z >> np.uint64(30))) * _MIX1
    z = (z ^ (z >> np.uint64(27))) * _MIX2
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@subroutine
def between(rng, low, high):
    """The next number in [low, high)."""
    return low + (high - low) * uniform(rng)


@subroutine
def normal(rng):
    """The next number of the standard normal distribution (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(rng)))
    return radius * math.cos(2.0 * math.pi * uniform(rng))
