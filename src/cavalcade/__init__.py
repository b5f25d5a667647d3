"""Motion planning and control for teams of quadruped robots.

The names below are imported when first used, so `import cavalcade` is quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from cavalcade.checking import Report, Violation, check
    from cavalcade.coordination.result import TeamPlan
    from cavalcade.eikonal import arrival_times
    from cavalcade.errors import (
        CavalcadeError,
        InputError,
        MapError,
        OutputError,
        RecordingError,
        ScenarioError,
    )
    from cavalcade.fleet.physics import MujocoFleet
    from cavalcade.formation import (
        Connection,
        Formation,
        FormationPlanner,
        FormationSettings,
        Imperfections,
        MovingObstacle,
    )
    from cavalcade.geometry.trajectory import Trajectory
    from cavalcade.jobs.planning import plan
    from cavalcade.jobs.running import RunResult, run
    from cavalcade.metrics.plan_result import PlanResult
    from cavalcade.recording.mcap_reader import read_recording
    from cavalcade.robots import RobotModel, robot_model
    from cavalcade.scenario import (
        Scenario,
        build_world,
        dump_scenario,
        load_scenario,
        parse_scenario,
        scenario_names,
    )
    from cavalcade.world import (
        Box,
        Circle,
        OccupancyMap,
        Polygon,
        Terrain,
        generate,
        generate_terrain,
        load_map,
        load_terrain,
        save_map,
    )

_HOME = {
    "Box": "world",
    "CavalcadeError": "errors",
    "Circle": "world",
    "Connection": "formation",
    "Formation": "formation",
    "FormationPlanner": "formation",
    "FormationSettings": "formation",
    "Imperfections": "formation",
    "InputError": "errors",
    "MapError": "errors",
    "MovingObstacle": "formation",
    "MujocoFleet": "fleet.physics",
    "OccupancyMap": "world",
    "OutputError": "errors",
    "PlanResult": "metrics.plan_result",
    "Polygon": "world",
    "RecordingError": "errors",
    "Report": "checking",
    "RobotModel": "robots",
    "RunResult": "jobs",
    "Scenario": "scenario",
    "ScenarioError": "errors",
    "TeamPlan": "coordination.result",
    "Terrain": "world",
    "Trajectory": "geometry.trajectory",
    "Violation": "checking",
    "arrival_times": "eikonal",
    "build_world": "scenario",
    "check": "checking",
    "dump_scenario": "scenario",
    "generate": "world",
    "generate_terrain": "world",
    "load_map": "world",
    "load_scenario": "scenario",
    "load_terrain": "world",
    "parse_scenario": "scenario",
    "plan": "jobs",
    "read_recording": "recording",
    "robot_model": "robots",
    "run": "jobs",
    "save_map": "world",
    "scenario_names": "scenario",
}

__all__ = [
    "Box",
    "CavalcadeError",
    "Circle",
    "Connection",
    "Formation",
    "FormationPlanner",
    "FormationSettings",
    "Imperfections",
    "InputError",
    "MapError",
    "MovingObstacle",
    "MujocoFleet",
    "OccupancyMap",
    "OutputError",
    "PlanResult",
    "Polygon",
    "RecordingError",
    "Report",
    "RobotModel",
    "RunResult",
    "Scenario",
    "ScenarioError",
    "TeamPlan",
    "Terrain",
    "Trajectory",
    "Violation",
    "__version__",
    "arrival_times",
    "build_world",
    "check",
    "dump_scenario",
    "generate",
    "generate_terrain",
    "load_map",
    "load_scenario",
    "load_terrain",
    "parse_scenario",
    "plan",
    "read_recording",
    "robot_model",
    "run",
    "save_map",
    "scenario_names",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
