"""Scenario files in: from a name or a file to a validated `Scenario`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from cavalcade.errors import ScenarioError
from cavalcade.scenario.advice import warn_of
from cavalcade.scenario.messages import scenario_error
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.overrides import Overrides, apply_overrides
from cavalcade.scenario.shipped import find_scenario, read_text
from cavalcade.scenario.spellings import with_current_spelling
from cavalcade.values import described, path_of
from cavalcade.yaml_text import parse_yaml


def load_scenario(
    name_or_path: str | Path, overrides: Overrides = (), seed: int | None = None
) -> Scenario:
    """Read a scenario.

    Args:
        name_or_path: A shipped scenario's name, a file, or the folder of a run.
        overrides: Values over the file's: `"planner.variant=published"` texts, or dotted paths
            with plain values.
        seed: Over the file's `execution.seed`.

    Raises:
        ScenarioError: It does not exist or does not fit the schema. The world itself is first
            looked at by `build_world`.
    """
    file = find_scenario(name_or_path)
    data = parse_yaml(read_text(file), file=str(file))
    if not isinstance(data, dict):
        raise ScenarioError("expected a mapping with version, name, world, …", file=file)
    apply_overrides(data, overrides, str(file))
    if seed is not None:
        apply_overrides(data, {"execution.seed": seed}, str(file))
    return parse_scenario(data, file)


def parse_scenario(data: Mapping[str, Any], file: str | Path | None = None) -> Scenario:
    """A scenario from the plain data of a file.

    Args:
        data: What the file holds; file names in it are relative to `file`.
        file: Where it comes from; None for data made in Python, relative to the working folder.

    Raises:
        ScenarioError: It does not fit the schema.

    Warns:
        ScenarioWarning: A value is probably not what was meant, or has no effect.
    """
    file = None if file is None else path_of(file, "file", ScenarioError)
    if not isinstance(data, Mapping):
        raise ScenarioError(f"expected a mapping, got {described(data)}", file=file, key="data")
    base = Path.cwd() if file is None else Path(file).resolve().parent
    try:
        data = with_current_spelling(data, file)
        scenario = Scenario.model_validate(data, context={"base": base})
    except ValidationError as error:
        raise scenario_error(error, Scenario, file) from None
    scenario = scenario.with_file(None if file is None else Path(file))
    warn_of(scenario)
    return scenario


def scenario_schema() -> dict[str, Any]:
    """The JSON Schema of scenario files; `unit` is the unit of a key's value."""
    return schema_of(Scenario)


def schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """The JSON Schema of files that a model describes."""
    schema = _with_bounds(model.model_json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


_BOUNDS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "lt": "exclusiveMaximum",
}


def _with_bounds(schema: Any) -> Any:
    """Bounds by their names in JSON Schema; pydantic leaves its own after a validator of ours."""
    if isinstance(schema, dict):
        return {_BOUNDS.get(key, key): _with_bounds(value) for key, value in schema.items()}
    return [_with_bounds(one) for one in schema] if isinstance(schema, list) else schema
