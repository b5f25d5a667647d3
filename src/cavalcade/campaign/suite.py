"""Suites: what a campaign runs, as their YAML files say it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, Field, Strict, ValidationError, model_validator

from cavalcade.campaign.methods import VARIANTS, check_variant
from cavalcade.campaign.samplers import SAMPLERS, DataFolder, Sampler
from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario.fields import Positive, Section, Seed, expected
from cavalcade.scenario.messages import scenario_error, short
from cavalcade.scenario.settings import Delay, Noise, PhysicsSection
from cavalcade.scenario.shipped import read_text
from cavalcade.scenario.spellings import current_value
from cavalcade.values import did_you_mean
from cavalcade.yaml_text import parse_yaml

SUITES = Path(__file__).parent / "suites"
"""The files of those that come with the package."""

LONGEST_NAME = 60
Name = Annotated[str, Field(pattern=rf"^[A-Za-z0-9][A-Za-z0-9_-]{{0,{LONGEST_NAME - 1}}}$")]
"""Of suites, groups and disturbances: they become parts of trials' IDs, which dots separate."""

Backend = Literal["ideal", "mujoco"]
"""Who moves robots."""


def _each_once(variants: tuple[str, ...]) -> tuple[str, ...]:
    """The variants by their current names."""
    variants = tuple(current_value("planner.variant", name) for name in variants)
    if len(set(variants)) < len(variants):
        raise expected("a variant stands here twice")
    return variants


Variants = Annotated[tuple[str, ...], Field(min_length=1), AfterValidator(_each_once)]
"""Of formation planners, or methods for individual goals; see `methods`."""

UNDISTURBED = "none"

MOST_SEEDS = 1_000_000
"""Of one group: a campaign holds the list of its trials in memory."""


class Disturbance(Section):
    """What is set over every scenario's `execution`; null leaves the scenario's own."""

    noise: Noise | None = None
    delay: Delay | None = None
    physics: PhysicsSection | None = None


class _Settings(Section):
    """What a suite says beside its worlds.

    Attributes:
        suite: Its name.
        about: One line.
        time_limit: Of wall clock for one trial, s.
        seed: The first seed of every group.
        backend: Who moves the robots of every world; None leaves it to the worlds.
        variants: All that there are, in the order of the report.
        references: What a variant is compared with; for those that are not in it the first one.
        disturbances: By name; empty where the suite names none.
    """

    version: Literal[1]
    suite: Name
    about: Annotated[str, Field(max_length=2000)] = ""
    time_limit: Positive = 120.0
    seed: Seed = 0
    backend: Backend | None = None
    variants: Variants | None = None
    references: dict[str, str] = Field(default_factory=dict)
    disturbances: dict[Name, Disturbance] = Field(default_factory=dict)


class _File(_Settings):
    """A suite's file but for the insides of its worlds, which depend on their `sampler`."""

    worlds: Annotated[tuple[dict[str, Any], ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _groups(self) -> Self:
        names = [group.get("name") for group in self.worlds]
        for index, name in enumerate(names):
            if name is not None and name in names[:index]:
                raise expected(f"{short(name)} is there already", key=f"worlds[{index}].name")
        return self


class _GroupHead(Section):
    name: Name
    seeds: Annotated[int, Strict(), Field(gt=0, le=MOST_SEEDS)] | None = None
    variants: Variants | None = None


class Group(_GroupHead):
    """Worlds of one kind.

    Attributes:
        name: What the trials' lines call `scenario`.
        seeds: How many worlds are sampled; None for all that there are, which must have an end.
        variants: Every world is run with each.
        sampler: Where they come from.
    """

    variants: tuple[str, ...]
    sampler: Sampler

    def numbers(self, first: int, data: DataFolder) -> range:
        """The seeds of its worlds, beginning with `first`."""
        limit = self.sampler.limit(data)
        last = None if self.seeds is None else first + self.seeds
        ends = [end for end in (limit, last) if end is not None]
        return range(first, max(min(ends, default=first), first))


class Suite(_Settings):
    """A validated suite; immutable."""

    variants: tuple[str, ...]
    worlds: tuple[Group, ...]

    @property
    def name(self) -> str:
        """The same as `suite`."""
        return self.suite

    def missing(self, data: DataFolder) -> str | None:
        """What data or packages are absent, one line; None when all are there."""
        found = [group.sampler.missing(data) for group in self.worlds]
        if self.backend == "mujoco":
            found.append(_missing_physics())
        return next((line for line in found if line is not None), None)

    def to_dict(self) -> dict[str, Any]:
        """The same as its file would say it, with all defaults; `parse_suite` reads it."""
        worlds = []
        for group in self.worlds:
            head: dict[str, Any] = {"name": group.name, "seeds": group.seeds}
            if group.variants != self.variants:
                head["variants"] = list(group.variants)
            worlds.append({**head, **group.sampler.model_dump(mode="json")})
        said = self.model_dump(mode="json", exclude={"worlds"}, exclude_none=True)
        return {**said, "worlds": worlds}


def _missing_physics() -> str | None:
    from cavalcade.fleet.mujoco.engine import load_mujoco

    try:
        load_mujoco()
    except InputError as error:
        return str(error)
    return None


_FORMER_KEY, _FORMER_KINDS = "draw", {"hopeless": "infeasible"}
"""How `sampler` and samplers were once called."""


def with_current_names(data: Any) -> Any:
    """The plain data of a suite with today's keys in the place of former ones.

    What is no suite comes back as it is.
    """
    worlds = data.get("worlds") if isinstance(data, Mapping) else None
    if not isinstance(worlds, list | tuple):
        return data
    return {**data, "worlds": [_with_sampler(group) for group in worlds]}


def _with_sampler(group: Any) -> Any:
    if not isinstance(group, Mapping) or _FORMER_KEY not in group or "sampler" in group:
        return group
    rest = dict(group)
    kind = rest.pop(_FORMER_KEY)
    return {**rest, "sampler": _FORMER_KINDS.get(kind, kind) if isinstance(kind, str) else kind}


def parse_suite(data: Mapping[str, Any], file: str | Path | None = None) -> Suite:
    """A suite from the plain data of its file; file names in it are relative to it.

    Raises:
        ScenarioError: It does not fit the schema.
    """
    base = Path.cwd() if file is None else Path(file).resolve().parent
    try:
        return _parsed(with_current_names(data), base)
    except ScenarioError as error:
        raise error.at(file=file, key=error.key) from None


def _parsed(data: Mapping[str, Any], base: Path) -> Suite:
    """The suite; errors do not name its file. File names in it are relative to `base`."""
    head: _File = _validated(_File, data, base, "")
    references = {
        current_value("planner.variant", name): current_value("planner.variant", other)
        for name, other in head.references.items()
    }
    groups = tuple(
        _group(group, head.variants, base, f"worlds[{index}]")
        for index, group in enumerate(head.worlds)
    )
    every = [*(head.variants or ()), *(name for group in groups for name in group.variants)]
    variants = tuple(dict.fromkeys(every))
    for index, name in enumerate(head.variants or ()):
        if all(name not in VARIANTS[group.sampler.individual_goals] for group in groups):
            check_variant(name, groups[0].sampler.individual_goals, f"variants[{index}]")
    _check_references(references, variants)
    changed = {"variants": variants, "references": references, "worlds": groups}
    return Suite(**{**dict(head), **changed})


def _check_references(references: Mapping[str, str], variants: tuple[str, ...]) -> None:
    for variant, reference in references.items():
        key = f"references.{variant}"
        for name in (variant, reference):
            if name not in variants:
                text = f"{short(name)} is none of the suite's variants ({', '.join(variants)})"
                raise ScenarioError(text, key=key)
        if variant == reference:
            raise ScenarioError("a variant cannot be its own reference", key=key)


def _group(
    given: dict[str, Any], variants: tuple[str, ...] | None, base: Path, place: str
) -> Group:
    rest = dict(given)
    of_head = {key: rest.pop(key) for key in _GroupHead.model_fields if key in rest}
    head: _GroupHead = _validated(_GroupHead, of_head, base, place)
    kind = given.get("sampler")
    if not isinstance(kind, str) or kind not in SAMPLERS:
        text = f"unknown value {short(kind)}{did_you_mean(str(kind), SAMPLERS)}"
        if "sampler" not in given:
            text = "missing"
        raise ScenarioError(text, key=f"{place}.sampler", choices=SAMPLERS)
    sampler: Sampler = _validated(SAMPLERS[kind], rest, base, place)
    where, names = "variants", variants
    if head.variants is not None:
        where, names = f"{place}.variants", head.variants
    for index, name in enumerate(names or ()):
        check_variant(name, sampler.individual_goals, f"{where}[{index}]")
    names = names or (("auto",) if sampler.individual_goals else ("cavalcade",))
    return Group(name=head.name, seeds=head.seeds, variants=names, sampler=sampler)


def _validated(model: type[BaseModel], data: Mapping[str, Any], base: Path, place: str) -> Any:
    """The section, or an error that says where in the file and what was expected."""
    try:
        return model.model_validate(dict(data), context={"base": base})
    except ValidationError as error:
        found = scenario_error(error, model, None)
    except InputError as error:
        found = ScenarioError(str(error))
    key = ".".join(part for part in (place, found.key) if part)
    raise found.at(key=key or None)


def suite_names() -> tuple[str, ...]:
    """The shipped suites' names, sorted."""
    return tuple(sorted(path.stem for path in SUITES.glob("*.yaml")))


def load_suite(name_or_path: str | Path) -> Suite:
    """Read a suite by its name, if it is shipped, or from its file.

    Raises:
        ScenarioError: It does not exist or does not fit the schema.
    """
    file = find_suite(name_or_path)
    data = parse_yaml(read_text(file), file=str(file))
    if not isinstance(data, dict):
        raise ScenarioError("expected a mapping with version, suite, worlds, …", file=file)
    suite = parse_suite(data, file)
    if with_current_names(data) != data:
        text = "`draw` of worlds is called `sampler` now, and its value `hopeless` `infeasible`"
        warnings.warn(f"{file}: {text}", FutureWarning, stacklevel=2)
    return suite


def find_suite(name_or_path: str | Path) -> Path:
    """The file of a shipped suite, or the file itself."""
    name = str(name_or_path)
    names = suite_names()
    if name in names:
        return SUITES / f"{name}.yaml"
    try:
        if name.isprintable() and Path(name).is_file():
            return Path(name)
    except OSError:  # such as a name that is too long
        pass
    hint = did_you_mean(name, names)
    shown = name if name.isprintable() and 0 < len(name) <= 200 else ascii(name)[:60]
    raise ScenarioError(f"no such file or shipped suite{hint}", file=shown, choices=names)
