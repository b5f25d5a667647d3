"""Scenario files: their schema, how they are read and written, and the shipped ones.

The names are looked up when first used: listing the shipped scenarios needs no schema, and
reading a file no maps.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.scenario.dumping import dump_scenario
    from cavalcade.scenario.importing import import_problem
    from cavalcade.scenario.loading import load_scenario, parse_scenario, scenario_schema
    from cavalcade.scenario.model import (
        Event,
        FormationSection,
        Move,
        Obstacle,
        PlannerSection,
        ResolvedScenario,
        Scenario,
    )
    from cavalcade.scenario.shipped import scenario_descriptions, scenario_names
    from cavalcade.scenario.timeline import ObstacleSpan, obstacle_spans
    from cavalcade.scenario.worlds import World, build_world, resolve_scenario

_HOME = {
    "Event": "model",
    "FormationSection": "model",
    "Move": "model",
    "Obstacle": "model",
    "PlannerSection": "model",
    "ResolvedScenario": "model",
    "Scenario": "model",
    "ObstacleSpan": "timeline",
    "World": "worlds",
    "build_world": "worlds",
    "dump_scenario": "dumping",
    "import_problem": "importing",
    "load_scenario": "loading",
    "obstacle_spans": "timeline",
    "parse_scenario": "loading",
    "resolve_scenario": "worlds",
    "scenario_descriptions": "shipped",
    "scenario_names": "shipped",
    "scenario_schema": "loading",
}

__all__ = [
    "Event",
    "FormationSection",
    "Move",
    "Obstacle",
    "ObstacleSpan",
    "PlannerSection",
    "ResolvedScenario",
    "Scenario",
    "World",
    "build_world",
    "dump_scenario",
    "import_problem",
    "load_scenario",
    "obstacle_spans",
    "parse_scenario",
    "resolve_scenario",
    "scenario_descriptions",
    "scenario_names",
    "scenario_schema",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
