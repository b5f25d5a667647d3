"""Random poses of a team on free ground."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cavalcade.campaign.draws.areas import Area
from cavalcade.campaign.draws.feasibility import DiscRegions
from cavalcade.campaign.draws.teams import BODY, placed
from cavalcade.geometry import Array

Pose = tuple[float, float, float]
TRIES = 300


def fits(ground: DiscRegions, pose: Sequence[float], slots: Array, area: Area | None) -> bool:
    """Whether every robot can stand in its slot at any yaw, within the area if there is one."""
    places = placed(pose, slots)
    if area is not None:
        low, high = np.array(area[:2]) + BODY, np.array(area[2:]) - BODY
        if (places < low).any() or (places > high).any():
            return False
    return bool((ground.clearance(places) >= BODY).all())


def draw_pose(
    rng: np.random.Generator,
    ground: DiscRegions,
    slots: Array,
    area: Area,
    yaw: float | None = None,
) -> Pose | None:
    """A pose in the area at which the team fits; None if none is found.

    Args:
        rng: Source of all randomness.
        ground: What stands.
        slots: `(N, 2)` in the formation's frame, m.
        area: Where every robot has to stand.
        yaw: Of the formation, rad; None draws it too.
    """
    for _ in range(TRIES):
        x, y = rng.uniform(area[0], area[2]), rng.uniform(area[1], area[3])
        turned = rng.uniform(-math.pi, math.pi) if yaw is None else yaw
        pose = (round(float(x), 4), round(float(y), 4), round(float(turned), 4))
        if fits(ground, pose, slots, area):
            return pose
    return None
