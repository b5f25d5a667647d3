"""One trial: which one it is, and the scenario that it runs."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from cavalcade.campaign.draws import DataFolder, Draw, Drawn, unplanned
from cavalcade.campaign.methods import planner_words
from cavalcade.campaign.suite import UNDISTURBED, Backend, Disturbance, Suite
from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario import Scenario, parse_scenario
from cavalcade.scenario.overrides import apply_overrides


@dataclass(frozen=True)
class Trial:
    """What one worker needs to carry one trial out; it can travel between processes.

    Attributes:
        id: Unique within the campaign.
        suite: The suite's name.
        group: The group's name; the line's `scenario`.
        variant: Of the planner, or the method for goals of single robots.
        disturbance: Its name, `none` where the suite names none.
        seed: Of the world, and of the run's noise.
        draw: Where the world comes from.
        disturbed: What the disturbance sets.
        backend: Who moves the robots; None leaves it to the world.
        overrides: `KEY=VALUE` texts over the scenario.
        data: Where other projects' files are.
    """

    id: str
    suite: str
    group: str
    variant: str
    disturbance: str
    seed: int
    draw: Draw
    disturbed: Disturbance
    backend: Backend | None
    overrides: tuple[str, ...]
    data: DataFolder

    def drawn(self) -> Drawn:
        """Its world, team and task."""
        return self.draw.draw_world(self.seed, self.data)

    def scenario(self, drawn: Drawn) -> Scenario:
        """The scenario to run: the drawn one with variant, disturbance and overrides.

        Raises:
            ScenarioError: The overrides do not fit, or make it another trial than its line says.
        """
        data: dict[str, Any] = copy.deepcopy(dict(drawn.scenario))
        words = planner_words(self.variant, self.draw.own_goals)
        data["planner"] = {**data.get("planner", {}), **words}
        data["execution"] = self.disturbed.over({"seed": self.seed, **data.get("execution", {})})
        if self.backend is not None:
            data["execution"]["backend"] = self.backend
        apply_overrides(data, self.overrides, None)
        scenario = parse_scenario(data)
        for word, said in words.items():
            if getattr(scenario.planner, word) != said:
                key = f"planner.{word}"
                raise ScenarioError(f"give it by itself: {key}=NAME", key=key)
        if scenario.seed != self.seed:
            raise ScenarioError("every world has its own; use --seed", key="execution.seed")
        return scenario


def trials_of(suite: Suite, overrides: tuple[str, ...], data: DataFolder) -> Iterator[Trial]:
    """All trials of a suite in their order: by group, seed, disturbance and variant."""
    disturbances: Mapping[str, Disturbance] = suite.disturbances or {UNDISTURBED: Disturbance()}
    for group in suite.worlds:
        for seed in group.numbers(suite.seed, data):
            for name, disturbance in disturbances.items():
                for variant in group.variants:
                    words = [group.name, f"{seed:04d}", variant]
                    if suite.disturbances:
                        words.append(name)
                    yield Trial(
                        id=".".join(words),
                        suite=suite.suite,
                        group=group.name,
                        variant=variant,
                        disturbance=name,
                        seed=seed,
                        draw=group.draw,
                        disturbed=disturbance,
                        backend=suite.backend,
                        overrides=overrides,
                        data=data,
                    )


def check_worlds(suite: Suite, overrides: tuple[str, ...], data: DataFolder) -> None:
    """See that worlds can be drawn and that the overrides fit them, before any trial is run.

    The first world of each group is tried.

    Raises:
        InputError: One cannot be drawn, or an override does not fit.
    """
    for index, group in enumerate(suite.worlds):
        first = replace(suite, worlds=(replace(group, seeds=1, draw=unplanned(group.draw)),))
        drawn: Drawn | None = None
        for trial in trials_of(first, (), data):
            try:
                drawn = drawn or trial.drawn()
                trial.scenario(drawn)
            except InputError as error:
                raise ScenarioError(str(error), key=f"worlds[{index}]") from None
            if overrides:
                _check_overrides(replace(trial, overrides=overrides), drawn)


def _check_overrides(trial: Trial, drawn: Drawn) -> None:
    try:
        trial.scenario(drawn)
    except InputError as error:
        key = error.key or ""
        place = key if key.startswith("--set") else f"--set {key}".strip()
        raise ScenarioError(error.message, key=place, choices=error.choices) from None
