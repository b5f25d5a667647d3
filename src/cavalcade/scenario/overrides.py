"""Values given over those of the file: `planner.variant=published`."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from cavalcade.errors import ScenarioError
from cavalcade.values import instances_of
from cavalcade.yaml_text import parse_yaml

Overrides = Sequence[str] | Mapping[str, Any]

_STEP = re.compile(r"([\w-]+)|\[(\d{1,6})\]|^\*$|\[\*\]")

_EVERY = "*"


def apply_overrides(data: dict[str, Any], overrides: Overrides, file: str | None) -> None:
    """Set values of a scenario's plain data in place.

    Args:
        data: The file's mapping.
        overrides: `"dotted.path=YAML value"` texts, or dotted paths with plain values. A step
            into a list is its index, or `*` for all of them: `robots[0].start`, `robots.0.start`,
            `robots.*.model`.
        file: Named in errors.

    Raises:
        ScenarioError: Malformed, or the path leads through something that has no such part.
    """
    if isinstance(overrides, str):
        overrides = [overrides]
    for key, value in _pairs(overrides):
        _put(data, _steps(key), value, key, file)


def _pairs(overrides: Overrides) -> Iterator[tuple[str, Any]]:
    if isinstance(overrides, Mapping):
        yield from overrides.items()
        return
    for text in instances_of(overrides, str, "--set", "a list of KEY=VALUE"):
        key, separator, value = str(text).partition("=")
        if not separator or not key.strip():
            raise ScenarioError(f"expected KEY=VALUE, got {ascii(text)[:60]}", key="--set")
        yield key.strip(), parse_yaml(value, key=f"--set {key.strip()[:60]}")


def _steps(key: str) -> list[str | int]:
    steps: list[str | int] = []
    for part in str(key).split("."):
        found = list(_STEP.finditer(part))
        if not part or "".join(match.group() for match in found) != part:
            raise ScenarioError(
                f"expected a dotted path such as planner.variant, got {ascii(key)[:60]}",
                key="--set",
            )
        for match in found:
            name, index = match.groups()
            if index is None and name is None:
                steps.append(_EVERY)
            else:
                steps.append(int(index) if index else int(name) if name.isdecimal() else name)
    return steps


def _put(data: Any, steps: list[str | int], value: Any, key: str, file: str | None) -> None:
    here = data
    for position, step in enumerate(steps):
        last = position == len(steps) - 1
        if step == _EVERY:
            if not isinstance(here, list):
                raise ScenarioError("* stands for the elements of a list", file=file, key=key)
            for index in range(len(here)):
                # What is set for several is no part that they share.
                _put(here, [index, *steps[position + 1 :]], copy.deepcopy(value), key, file)
            return
        if isinstance(here, dict):
            name = str(step)
            if last:
                here[name] = value
            elif here.get(name) is None:
                here[name] = {}
            here = here[name]
        elif isinstance(here, list) and isinstance(step, int) and step < len(here):
            if last:
                here[step] = value
            here = here[step]
        elif isinstance(here, list):
            raise ScenarioError(
                f"expected an index below {len(here)} or * for a list, got {step}",
                file=file,
                key=key,
            )
        else:
            raise ScenarioError(f"there is nothing below {steps[position - 1]}", file=file, key=key)
