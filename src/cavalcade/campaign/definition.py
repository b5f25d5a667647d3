"""What a campaign is: a suite with everything said over it. Kept in `campaign.json`."""

from __future__ import annotations

import difflib
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from cavalcade.campaign.methods import changed, check_variant
from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.suite import (
    MOST_SEEDS,
    Suite,
    find_suite,
    load_suite,
    parse_suite,
    with_current_names,
)
from cavalcade.campaign.trial import Trial, check_worlds, trials_of
from cavalcade.errors import InputError, RecordingError, ScenarioError
from cavalcade.scenario.rules import LIVE, SIMULATED
from cavalcade.scenario.spellings import current_value
from cavalcade.yaml_text import parse_yaml

FILE = "campaign.json"
_VARIANT, _METHOD, _BACKEND = "planner.variant", "planner.method", "execution.backend"


@dataclass(frozen=True)
class Definition:
    """A suite with what the command line says over it.

    Attributes:
        suite: Its seeds and variants as they will be run.
        overrides: `KEY=VALUE` texts over every scenario.
        version: Of the package.
        data: Where other projects' files are.
        named_data: That folder as the user named it, None if nobody did.
    """

    suite: Suite
    overrides: tuple[str, ...]
    version: str
    data: DataFolder
    named_data: str | None = None

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """All trials in their order."""
        return tuple(trials_of(self.suite, self.overrides, self.data))

    def trial(self, trial_id: str) -> Trial:
        """The one of that ID; InputError if there is none."""
        for trial in self.trials:
            if trial.id == trial_id:
                return trial
        near = _nearest(trial_id, [trial.id for trial in self.trials])
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise InputError(f"no such trial: {ascii(trial_id)[:80]}{hint}", key="ID")

    @property
    def fingerprint(self) -> str:
        """Of suite, overrides and version: the same for the same campaign, on every machine."""
        identity = {"suite": self.suite.to_dict(), "overrides": list(self.overrides)}
        text = json.dumps({**identity, "version": self.version}, sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def to_dict(self) -> dict[str, Any]:
        """The content of `campaign.json`."""
        return {
            "fingerprint": self.fingerprint,
            "version": self.version,
            "overrides": list(self.overrides),
            "data": self.named_data,
            "suite": self.suite.to_dict(),
        }


def define_campaign(
    suite: str | Path,
    *,
    overrides: Sequence[str] = (),
    seed: int | None = None,
    seeds: int | None = None,
    data: str | Path | None = None,
) -> Definition:
    """The definition of a campaign.

    Args:
        suite: A shipped suite's name, or a file.
        overrides: `KEY=VALUE` texts over every scenario; `planner.variant` and, for goals of
            single robots, `planner.method` take the place of the suite's; so does
            `execution.backend`.
        seed: The first seed of every group, over the suite's.
        seeds: How many worlds of each group at most, over the suite's.
        data: The folder with the data of other projects.

    Raises:
        InputError: Something does not fit.
    """
    from cavalcade import __version__

    found = _changed(load_suite(suite), seed, seeds)
    found, rest = _with_overrides(found, overrides)
    folder = DataFolder.find(data)
    for index, group in enumerate(found.worlds):
        if group.seeds is None and group.sampler.limit(folder) is None:
            text = "missing; expected how many worlds are sampled"
            raise ScenarioError(text, file=find_suite(suite), key=f"worlds[{index}].seeds")
    return Definition(found, rest, __version__, folder, None if data is None else str(data))


def check_definition(definition: Definition) -> None:
    """Refuse what has nothing to run, or worlds and overrides that do not fit.

    The suite's data must be there.
    """
    if not definition.trials:
        raise InputError(
            f"suite {definition.suite.name} has no world from seed {definition.suite.seed} on",
            key="--seed",
        )
    check_worlds(definition.suite, definition.overrides, definition.data)


def read_definition(folder: Path, data: str | Path | None = None) -> Definition:
    """The definition of the campaign in a folder; None stands for the data that were used.

    Raises:
        RecordingError: There is none, or it cannot be read.
    """
    said = read_definition_file(folder)
    try:
        suite = parse_suite(said["suite"], None)
        overrides = tuple(str(text) for text in said["overrides"])
        version = str(said["version"])
        named = None if said["data"] is None else str(said["data"])
    except (KeyError, TypeError, ValueError, InputError) as error:
        text = f"not a campaign of this version: {error}"
        raise RecordingError(text, file=folder / FILE) from None
    named = str(data) if data is not None else named
    return Definition(suite, overrides, version, DataFolder.find(named), named)


def read_definition_file(folder: Path) -> dict[str, Any]:
    """The content of `campaign.json`; raises as `read_definition`."""
    file = folder / FILE
    if not file.is_file():
        raise RecordingError(f"expected the folder of a campaign; it has no {FILE}", file=folder)
    try:
        said = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=file) from None
    except (ValueError, RecursionError):
        raise RecordingError("expected JSON", file=file) from None
    if not isinstance(said, dict):
        raise RecordingError("expected a mapping", file=file)
    return said


def difference(definition: Definition, other: Mapping[str, Any]) -> str | None:
    """How a definition differs from the content of a `campaign.json`; None if it is the same.

    Where the data lie is no difference.
    """
    if other.get("fingerprint") == definition.fingerprint:
        return None
    mine, theirs = definition.to_dict(), other
    suite = with_current_names(theirs["suite"]) if isinstance(theirs.get("suite"), dict) else {}
    name = suite.get("suite")
    if name != definition.suite.name:
        return f"holds a campaign of suite {name}, not {definition.suite.name}"
    if theirs.get("version") != definition.version:
        return f"was begun with version {theirs.get('version')}, this is {definition.version}"
    if theirs.get("overrides") != mine["overrides"]:
        said = " ".join(map(str, theirs.get("overrides") or ())) or "none"
        return f"was begun with other overrides (--set): {said}"
    all_keys = {**mine["suite"], **suite}
    keys = [key for key in all_keys if mine["suite"].get(key) != suite.get(key)]
    if not keys:  # begun when keys of suites had other names
        return None
    return f"was begun with other values in suite {name}: {', '.join(keys)}"


def _changed(suite: Suite, seed: int | None, seeds: int | None) -> Suite:
    bounds = (("--seed", seed, 0, 2**63 - 1), ("--seeds", seeds, 1, MOST_SEEDS))
    for key, value, least, most in bounds:
        if value is not None and not least <= value <= most:
            text = f"expected a whole number from {least} to {most}, got {value}"
            raise InputError(text, key=key)
    if seeds is not None:
        groups = tuple(group.model_copy(update={"seeds": seeds}) for group in suite.worlds)
        suite = suite.model_copy(update={"worlds": groups})
    return suite if seed is None else suite.model_copy(update={"seed": seed})


def _with_overrides(suite: Suite, overrides: Sequence[str]) -> tuple[Suite, tuple[str, ...]]:
    """The suite with the backend, variant and method that overrides name, and the other ones.

    A method is named so only for individual goals; it is left to scenarios otherwise.
    """
    said: dict[str, Any] = {}
    rest = []
    methods = any(group.sampler.individual_goals for group in suite.worlds)
    for text in map(str, overrides):
        key, separator, value = (part.strip() for part in text.partition("="))
        if key == _BACKEND and value in LIVE:
            text = f"{value} robots cannot be set back to a start, as campaigns do"
            raise InputError(text, key=_BACKEND, choices=SIMULATED)
        if key == _BACKEND and value in SIMULATED:
            suite = suite.model_copy(update={"backend": value})
        elif separator and (key == _VARIANT or (key == _METHOD and methods)):
            said[key] = parse_yaml(value, key=f"--set {key}")
        else:
            rest.append(text)
    if not said:
        return suite, tuple(rest)
    method, variant = said.get(_METHOD), said.get(_VARIANT)
    groups = []
    for group in suite.worlds:
        names = group.variants
        if group.sampler.individual_goals:
            names = changed(names, method, variant)
        elif variant is not None:
            variant = current_value(_VARIANT, variant)
            check_variant(str(variant), False, f"--set {_VARIANT}")
            names = (str(variant),)
        groups.append(group.model_copy(update={"variants": names}))
    variants = tuple(dict.fromkeys(name for group in groups for name in group.variants))
    update = {"worlds": tuple(groups), "variants": variants, "references": {}}
    return suite.model_copy(update=update), tuple(rest)


def _nearest(word: str, ids: Sequence[str]) -> list[str]:
    # Comparing with tens of thousands would take long; those that begin alike come first.
    alike = [one for one in ids if one.startswith(word[:4])] or list(ids)
    return difflib.get_close_matches(word[:120], alike[:5000], n=3)
