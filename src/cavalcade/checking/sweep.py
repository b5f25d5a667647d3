"""Contact and closest approach over time, without a step size.

Of two moving bodies nothing is known here but their distance at any moment and a bound on how far
that distance can change over an interval. If the distance in the middle of an interval exceeds
half of the bound, the interval is clear; otherwise it is halved. So contact is found however
short it is and however fast the bodies move.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array

TOUCH = 1e-6
"""Bodies seen at most this far apart count as in contact, m. Any that come closer than half of it
are seen."""

GAP_ERROR = 1e-4
"""The smallest gap is reported at most this much too large, m."""

_CHUNK = 4096

Rows = NDArray[np.int64]
Distance = Callable[[Rows, Array], Array]
"""Distances `(M,)` in m, 0 in contact, of candidates `(M,)` at fractions `(M,)` of their
intervals."""


@dataclass(frozen=True)
class Approach:
    """How close the candidates came.

    Attributes:
        contact: `(K,)` candidates in contact at some time of their interval.
        fraction: `(K,)` when: the fraction of the interval at which it was seen.
        gap: Smallest distance of all candidates, m; inf without any.
    """

    contact: Rows
    fraction: Array
    gap: float


def closest_approach(distance: Distance, reach: Array, lower: Array, gap: float) -> Approach:
    """Find every candidate in contact, and the smallest gap below one known from elsewhere, m.

    The distance changes by at most `reach` `(M,)` over a whole interval, m; `lower` `(M,)` is a
    quick lower bound of it there.
    """
    order = np.argsort(lower, kind="stable")
    contacts, fractions = [np.empty(0, dtype=np.int64)], [np.empty(0)]
    for first in range(0, len(order), _CHUNK):
        rows = order[first : first + _CHUNK]
        if lower[rows[0]] > max(gap, TOUCH):
            break
        contact, fraction, gap = _subdivide(distance, reach, rows, gap)
        contacts.append(contact)
        fractions.append(fraction)
    return Approach(np.concatenate(contacts), np.concatenate(fractions), gap)


def first_contact(distance: Distance, reach: float, row: int, seen: float) -> float:
    """Fraction of the interval at which candidate `row` comes into contact first.

    Moves forward by as much as the distance surely allows, to at most `seen`, a fraction at
    which there is contact.
    """
    rows = np.array([row])
    fraction = 0.0
    for _ in range(1000):
        gap = float(distance(rows, np.array([fraction]))[0])
        if gap <= TOUCH or reach <= 0.0:
            break
        fraction += gap / reach
        if fraction >= seen:
            return seen
    return fraction


def _subdivide(
    distance: Distance, reach: Array, rows: Rows, gap: float
) -> tuple[Rows, Array, float]:
    begin = np.zeros(len(rows))
    size = 1.0
    contacts, fractions = [np.empty(0, dtype=np.int64)], [np.empty(0)]
    while len(rows):
        middle = begin + 0.5 * size
        far = distance(rows, middle)
        slack = 0.5 * size * reach[rows]
        gap = min(gap, float(far.min()))
        touching = settled = far <= TOUCH
        if touching.any():
            contacts.append(rows[touching])
            fractions.append(middle[touching])
            # One contact per candidate is enough: its first moment is looked for separately.
            settled = np.isin(rows, rows[touching])
        low = far - slack
        again = ~settled & ((low <= 0.5 * TOUCH) | (low < gap - GAP_ERROR))
        rows, begin = rows[again], begin[again]
        size *= 0.5
        rows = np.concatenate((rows, rows))
        begin = np.concatenate((begin, begin + size))
    found, where = np.unique(np.concatenate(contacts), return_index=True)
    return found, np.concatenate(fractions)[where], gap
