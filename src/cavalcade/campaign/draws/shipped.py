"""One of the shipped scenarios, or any scenario file, seed by seed."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationInfo, field_validator

from cavalcade.campaign.draws.data import DataFolder
from cavalcade.campaign.draws.feasibility import DiscRegions
from cavalcade.campaign.draws.model import Drawn
from cavalcade.geometry import transform_points
from cavalcade.scenario.fields import Section, expected
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.shipped import scenario_names


class ShippedDraw(Section):
    """The scenario as it is; the seed is that of its execution, so only disturbances differ.

    `scenario` is a shipped one's name or a file. Feasible means that every goal in turn can be
    reached from the one before with what stands at the start; events are not looked at.
    """

    draw: Literal["shipped"]
    scenario: str

    @field_validator("scenario")
    @classmethod
    def _found(cls, name: str, info: ValidationInfo) -> str:
        if name in scenario_names():
            return name
        base = (info.context or {}).get("base")
        file = Path(name) if base is None else Path(base) / name
        if not file.is_file():
            raise expected("expected a shipped scenario or a file", choices=scenario_names())
        return str(file.resolve())

    @property
    def level_name(self) -> str | None:
        """There is no curve."""
        return None

    def limit(self, data: DataFolder) -> int | None:
        """Any seed will do."""
        return None

    def missing(self, data: DataFolder) -> str | None:
        """No data are needed."""
        return None

    def draw_world(self, seed: int, data: DataFolder) -> Drawn:
        """The scenario with that seed.

        Raises:
            InputError: There is no such scenario, or it cannot be used.
        """
        from cavalcade.scenario import load_scenario

        scenario = load_scenario(self.scenario, seed=seed)
        said: dict[str, Any] = scenario.model_dump(mode="json", exclude_none=True)
        for source in ("map", "terrain", "movingai", "barn"):
            if source in said["world"]:
                said["world"][source] = _absolute(said["world"][source])
        return Drawn(said, _feasible(scenario))


def _absolute(source: Any) -> Any:
    if isinstance(source, dict):
        return {**source, "file": _absolute(source["file"])}
    return str(Path(source).resolve())


def _feasible(scenario: Scenario) -> bool:
    """Whether a disc gets from every start to every slot at every goal."""
    from cavalcade.running.team import formation_of
    from cavalcade.scenario import build_world

    world = build_world(scenario)
    ground = DiscRegions(world.base, world.shapes)
    formation = formation_of(scenario.task.the_formation, len(scenario.robots), scenario.planner)
    starts = [start[:2] for start in scenario.starts]
    return all(
        ground.connect(starts, transform_points(goal, formation.slots))
        for goal in scenario.task.goals
    )
