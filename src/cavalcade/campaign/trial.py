"""One trial: which one it is, the scenario that it runs, and the line that is kept of it."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from cavalcade.campaign.methods import planner_settings
from cavalcade.campaign.samplers import EXPECTED, DataFolder, Instance, Sampler, unplanned
from cavalcade.campaign.suite import UNDISTURBED, Backend, Disturbance, Suite
from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario import Scenario, parse_scenario
from cavalcade.scenario.overrides import apply_overrides

Line = dict[str, Any]
"""What is kept of a finished trial: one JSON object in `trials.jsonl`."""

UNKNOWN = Instance({}, feasible=True)
"""Of a trial that never got so far; a failure in an unknown world counts as one."""

CRASHED, REFUSED, OVERTIME = "crashed", "refused", "overtime"
"""Outcomes beside those of `summary.json` and the checker's `collision` and `invalid`."""

TIMES = (
    "wall_time_s",
    "planning_time_s",
    "cycle_ms",
    "real_time_factor",
    "versions",
    "single_time_ratio",
)
"""What differs in the summaries and measures of two runs of the same scenario."""


@dataclass(frozen=True)
class Trial:
    """What one worker needs to carry one trial out; it can travel between processes.

    Attributes:
        id: Unique within the campaign.
        suite: The suite's name.
        group: The group's name; the line's `scenario`.
        variant: Of the planner, or the method for individual goals.
        disturbance: Its name, `none` where the suite names none.
        seed: Of the world, and of the run's noise.
        sampler: Where the world comes from.
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
    sampler: Sampler
    disturbed: Disturbance
    backend: Backend | None
    overrides: tuple[str, ...]
    data: DataFolder

    def instance(self) -> Instance:
        """Its world, team and task."""
        return self.sampler.sample(self.seed, self.data)

    def scenario(self, instance: Instance) -> Scenario:
        """The scenario to run: the instance's with variant, disturbance and overrides.

        Raises:
            ScenarioError: The overrides do not fit, or make it another trial than its line says.
        """
        data: dict[str, Any] = copy.deepcopy(dict(instance.scenario))
        words = planner_settings(self.variant, self.sampler.individual_goals)
        data["planner"] = {**data.get("planner", {}), **words}
        disturbed = self.disturbed.model_dump(mode="json", exclude_none=True)
        data["execution"] = {"seed": self.seed, **data.get("execution", {}), **disturbed}
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
                        sampler=group.sampler,
                        disturbed=disturbance,
                        backend=suite.backend,
                        overrides=overrides,
                        data=data,
                    )


def check_worlds(suite: Suite, overrides: tuple[str, ...], data: DataFolder) -> None:
    """Refuse overrides that do not fit, and groups whose first world cannot be sampled."""
    for index, group in enumerate(suite.worlds):
        one = group.model_copy(update={"seeds": 1, "sampler": unplanned(group.sampler)})
        first = suite.model_copy(update={"worlds": (one,)})
        instance: Instance | None = None
        for trial in trials_of(first, (), data):
            try:
                instance = instance or trial.instance()
                trial.scenario(instance)
            except InputError as error:
                raise ScenarioError(str(error), key=f"worlds[{index}]") from None
            if overrides:
                _check_overrides(replace(trial, overrides=overrides), instance)


def _check_overrides(trial: Trial, instance: Instance) -> None:
    try:
        trial.scenario(instance)
    except InputError as error:
        key = error.key or ""
        place = key if key.startswith("--set") else f"--set {key}".strip()
        raise ScenarioError(error.message, key=place, choices=error.choices) from None


def failure_line(trial: Trial, outcome: str, detail: str, instance: Instance = UNKNOWN) -> Line:
    """The line of a trial without a run, for the reason `outcome`, with `detail` about it."""
    return {
        "trial": trial.id,
        "suite": trial.suite,
        "scenario": trial.group,
        "variant": trial.variant,
        "disturbance": trial.disturbance,
        "seed": trial.seed,
        "outcome": outcome,
        "detail": " ".join(detail.split()),
        "success": outcome in EXPECTED.get(instance.expected, ()),
        "feasible": bool(instance.feasible),
        "expected": instance.expected,
        "level": None if instance.level is None else float(instance.level),
        "level_name": trial.sampler.level_name,
        "contacts": 0,
        "avoidable": 0,
        "violations": [],
        "measured": {"time_ratio": None},
        "summary": {},
    }


def without_times(line: Mapping[str, Any]) -> Line:
    """The line without what differs when its trial is repeated."""
    summary = {key: value for key, value in line["summary"].items() if key not in TIMES}
    measured = {key: value for key, value in line["measured"].items() if key not in TIMES}
    return {**line, "summary": summary, "measured": measured}
