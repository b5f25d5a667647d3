"""What robots keep from each other, as the planner of a scenario has it."""

from __future__ import annotations

from cavalcade.execution.formation_policy import expected_of, settings_of
from cavalcade.formation import SafetyFilter
from cavalcade.formation.settings import variant_named
from cavalcade.scenario import ResolvedScenario


def clearance_of(scenario: ResolvedScenario | None) -> float:
    """Half of what centres of a formation's robots keep from each other, m; 0 for nothing.

    With the safety filter its gap between centres; else the inflation radius.
    """
    if scenario is None or scenario.task.formation is None:
        return 0.0
    if not variant_named(scenario.planner.variant).filter:
        return settings_of(scenario.planner).r_max
    model = max(scenario.models, key=lambda one: one.length * one.width)
    period = 1.0 / scenario.execution.rate
    safety = SafetyFilter(model, period, expected_of(scenario))
    return safety.parameters.insisted.centres / 2.0
