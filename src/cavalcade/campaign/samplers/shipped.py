"""One of the shipped scenarios, or any scenario file, seed by seed."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Self

from pydantic import PrivateAttr, ValidationInfo, field_validator, model_validator

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.individual_goals import Legged
from cavalcade.campaign.samplers.sampler import DataFolder, Instance, Sampler
from cavalcade.geometry import transform_points
from cavalcade.scenario.fields import expected
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.settings import FORMATION_KEYS, Budget
from cavalcade.scenario.shipped import scenario_names
from cavalcade.scenario.task import INDIVIDUAL


class ShippedSampler(Sampler):
    """The scenario as it is; the seed is that of its execution, so only disturbances differ.

    `scenario` is a shipped one's name or a file. Feasible means that every goal in turn can be
    reached from the one before with what stands at the start; events are not looked at. Of goals
    of single robots each one has to be reached by its robot alone. `budget` is set over the
    scenario's, `model` takes the places of its robots.
    """

    sampler: Literal["shipped"]
    scenario: str
    budget: Budget = Budget()
    model: Legged | None = None

    _own_goals: bool = PrivateAttr(default=False)

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

    @model_validator(mode="after")
    def _kind(self) -> Self:
        self._own_goals = bool(self._loaded(0).goals)
        return self

    @property
    def individual_goals(self) -> bool:
        """As the scenario says."""
        return self._own_goals

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """The scenario with that seed."""
        scenario = self._loaded(seed)
        values: dict[str, Any] = scenario.model_dump(mode="json", exclude_none=True)
        budget = self.budget.model_dump(mode="json", exclude_none=True)
        values["planner"]["budget"] = {**values["planner"].get("budget", {}), **budget}
        for source in ("map", "terrain", "movingai", "barn"):
            if source in values["world"]:
                values["world"][source] = _absolute(values["world"][source])
        if not self.individual_goals:
            return Instance(values, _feasible(scenario))
        values["task"] = {"goals": INDIVIDUAL}
        values["planner"] = {k: v for k, v in values["planner"].items() if k not in FORMATION_KEYS}
        _without_defaults(values["planner"])
        return Instance(values, _each_feasible(scenario))

    def _loaded(self, seed: int) -> Scenario:
        from cavalcade.scenario import load_scenario

        over = {} if self.model is None else {"robots.*.model": self.model}
        return load_scenario(self.scenario, over, seed=seed)


def _without_defaults(planner: dict[str, Any]) -> None:
    """Take out what the file's own variant means, so that another one can mean other things."""
    published = planner.get("variant") == "published"
    for key, default in (
        ("constraints", "static" if published else "timed"),
        ("conflict", "first" if published else "costly"),
    ):
        if planner.get(key) == default:
            del planner[key]


def _absolute(source: Any) -> Any:
    if isinstance(source, dict):
        return {**source, "file": _absolute(source["file"])}
    return str(Path(source).resolve())


def _each_feasible(scenario: Scenario) -> bool:
    """Whether a disc of half its body's width gets each robot to its goal, past what is solid."""
    from cavalcade.scenario import build_world

    world = build_world(scenario)
    if world.terrain is not None:  # the shipped ones can be crossed, by their construction
        return True
    return all(
        DiscRegions(world.base, world.shapes, radius=model.width / 2.0).connect(
            [start[:2]], [goal[:2]]
        )
        for model, start, goal in zip(scenario.models, scenario.starts, scenario.goals, strict=True)
    )


def _feasible(scenario: Scenario) -> bool:
    """Whether a disc gets from every start to every slot at every goal."""
    from cavalcade.execution.formation_policy import formation_of
    from cavalcade.scenario import build_world

    world = build_world(scenario)
    ground = DiscRegions(world.base, world.shapes)
    formation = formation_of(scenario.task.the_formation, len(scenario.robots), scenario.planner)
    starts = [start[:2] for start in scenario.starts]
    return all(
        ground.connect(starts, transform_points(goal, formation.slots))
        for goal in scenario.task.goals
    )
