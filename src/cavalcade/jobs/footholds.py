"""Footholds of a whole team."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion import leg_lengths, plan_footholds
from cavalcade.scenario import Scenario, World


def plan_feet(
    scenario: Scenario, world: World, trajectories: Sequence[Trajectory | None]
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Footholds `(M, 6)` of each robot, and how far its legs stretch to them `(M,)`, m."""
    ground = make_ground(world.map, world.terrain)
    origin = world.map.origin
    footholds: list[Array] = []
    stretches: list[Array] = []
    for model, trajectory in zip(scenario.models, trajectories, strict=True):
        feet, stretch = np.zeros((0, 6)), np.zeros(0)
        if trajectory is not None and model.legs is not None:
            feet = plan_footholds(trajectory, model, ground, origin)
            stretch = leg_lengths(feet, trajectory, model, ground, origin)
        footholds.append(feet)
        stretches.append(stretch)
    return tuple(footholds), tuple(stretches)
