"""Who leads, who takes which slot (Norén et al., section 2.3)."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from cavalcade.geometry import Array, wrap_angle

_SAME_ANGLE = 0.1  # rad between two slots, seen from the leader, below which order is ambiguous
_SAME_RING = 0.1  # of the shape's spacing: difference of distances within one group


def choose_leader(eta: Array, leader: int, lead: float) -> int:
    """The robot with the least ETA; the present `leader` stays unless beaten by `lead` seconds.

    `eta` `(N,)` is inf for robots that cannot lead, -1 stands for no leader, and `lead` is the
    paper's D_switch.
    """
    best = int(np.argmin(eta))
    if not np.isfinite(eta[best]):
        return -1
    if 0 <= leader < len(eta) and np.isfinite(eta[leader]) and eta[best] >= eta[leader] - lead:
        return leader
    return best


def follower_rings(slots: Array) -> list[NDArray[np.int64]]:
    """Follower slots in groups from the leader's slot outwards.

    One group if the angular order around the leader's slot is unambiguous; else slots of about
    the same distance form a group.
    """
    followers = np.arange(1, len(slots))
    if len(followers) < 2:
        return [followers] if len(followers) else []
    offset = slots[1:] - slots[0]
    angles = sorted(math.atan2(y, x) for x, y in offset.tolist())
    angles.append(angles[0] + 2.0 * math.pi)
    if min(after - before for before, after in pairwise(angles)) >= _SAME_ANGLE:
        return [followers]
    distance = np.hypot(offset[:, 0], offset[:, 1])
    spacing = float(
        np.hypot(*(slots[:, None] - slots[None]).T)[np.triu_indices(len(slots), 1)].min()
    )
    order = np.argsort(distance, kind="stable")
    rings: list[list[int]] = []
    for k in order:
        if rings and distance[k] <= distance[rings[-1][0] - 1] + _SAME_RING * spacing:
            rings[-1].append(int(k) + 1)
        else:
            rings.append([int(k) + 1])
    return [np.array(ring) for ring in rings]


def assign_followers(
    points: Array, leader: int, heading: float, slots: Array, active: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Give each follower a slot, keeping the slots' angular order around the leader.

    Angles are counted from straight behind the leader, which travels in the direction `heading`,
    rad, so that the order is cut ahead of it. Slots `(S, 2)` are in the formation's frame, the
    leader's first; the S robots `active` take part. Returns the slot of each robot `(N,)`: 0 for
    the leader, -1 for robots that take no part.
    """
    roles = np.full(len(points), -1, dtype=np.int64)
    roles[leader] = 0
    offset = points - points[leader]
    away = np.hypot(offset[:, 0], offset[:, 1])
    behind = wrap_angle(np.arctan2(offset[:, 1], offset[:, 0]) - heading - np.pi)
    rest = active[active != leader]
    rest = rest[np.argsort(away[rest], kind="stable")]
    taken = 0
    for places in _ordered_rings(np.asarray(slots, dtype=float).tobytes()):
        group = rest[taken : taken + len(places)]
        taken += len(places)
        roles[group[np.argsort(behind[group], kind="stable")]] = places
    return roles


@lru_cache(maxsize=64)
def _ordered_rings(slots: bytes) -> tuple[NDArray[np.int64], ...]:
    """Each ring's slots in their angular order; shapes change far less often than cycles go by."""
    places = np.frombuffer(slots).reshape(-1, 2)
    offset = places - places[0]
    behind = wrap_angle(np.arctan2(offset[:, 1], offset[:, 0]) - np.pi)
    rings = follower_rings(places)
    return tuple(ring[np.argsort(behind[ring], kind="stable")] for ring in rings)


def assign_goals(points: Array, goals: Array, active: NDArray[np.int64]) -> NDArray[np.int64]:
    """The bijection with the least sum of squared distances (section 2.4.2).

    Of robots at `points` `(N, 2)`, of which S are `active`, to the slots' final `goals` `(S, 2)`,
    m. Returns the slot of each robot `(N,)`, -1 for robots that take no part.
    """
    offset = points[active][:, None] - goals[None]
    return least_cost((offset**2).sum(axis=-1), len(points), active)


def least_cost(cost: Array, robots: int, active: NDArray[np.int64]) -> NDArray[np.int64]:
    """Slots `(N,)` of all robots by the cheapest bijection, costs `(A, S)` of the active ones."""
    roles = np.full(robots, -1, dtype=np.int64)
    rows, slots = linear_sum_assignment(cost)
    roles[active[rows]] = slots
    return roles
