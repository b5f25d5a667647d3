"""Formation planning: shapes, roles, goals, springs, avoidance, limits and the safety filter."""

from cavalcade.formation.dynamic_obstacles import DynamicObstacle
from cavalcade.formation.estimation import Imperfections
from cavalcade.formation.planner import FormationPlanner
from cavalcade.formation.safety_filter import SafetyFilter, SafetyInputs
from cavalcade.formation.settings import (
    IMPROVED,
    LABORATORY,
    LABORATORY_SPRINGS,
    PRESETS,
    SIMULATION,
    SIMULATION_SPRINGS,
    VARIANTS,
    FormationSettings,
    SpringLaw,
    Springs,
    Variant,
    default_settings,
)
from cavalcade.formation.shapes import Connection, Formation
from cavalcade.recording.status import PlannerStatus

__all__ = [
    "IMPROVED",
    "LABORATORY",
    "LABORATORY_SPRINGS",
    "PRESETS",
    "SIMULATION",
    "SIMULATION_SPRINGS",
    "VARIANTS",
    "Connection",
    "DynamicObstacle",
    "Formation",
    "FormationPlanner",
    "FormationSettings",
    "Imperfections",
    "PlannerStatus",
    "SafetyFilter",
    "SafetyInputs",
    "SpringLaw",
    "Springs",
    "Variant",
    "default_settings",
]
