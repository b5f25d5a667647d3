"""What a team is asked to do first, before any planner has said something."""

from __future__ import annotations

from typing import Any

import numpy as np

from cavalcade.execution.formation_policy import formation_of
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import ResolvedScenario


def first_intent(scenario: ResolvedScenario) -> PlannerStatus | None:
    """A status with the first goal, nobody having a place in it yet; None without goals."""
    count = len(scenario.robots)
    starts = np.array(scenario.starts, dtype=float).reshape(-1, 3)
    common: dict[str, Any] = {
        "state": "inactive",
        "goals": starts[:, :2],
        "paths": (np.zeros((0, 2)),) * count,
        "eta": np.full(count, np.inf),
    }
    if scenario.goals:
        targets = np.array(scenario.goals, dtype=float).reshape(-1, 3)
        return PlannerStatus(roles=np.arange(count), targets=targets, **common)
    if scenario.task.formation is not None and scenario.task.goals:
        formation = formation_of(scenario.task.formation, count, scenario.planner)
        goal = np.array(scenario.task.goals[0], dtype=float)
        nobody = np.full(count, -1, dtype=np.int64)
        return PlannerStatus(roles=nobody, slots=formation.slots, goal=goal, **common)
    return None
