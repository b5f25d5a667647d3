"""Scenario files in: from a name or a file to a validated `Scenario`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cavalcade.errors import ScenarioError
from cavalcade.files import read_head
from cavalcade.scenario.messages import did_you_mean, scenario_error
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.overrides import Overrides, apply_overrides
from cavalcade.scenario.spellings import with_current_spelling
from cavalcade.yaml_text import parse_yaml

LIBRARY = Path(__file__).parent / "library"
"""Of the scenarios that come with the package."""

MAX_BYTES = 8_000_000
"""Largest scenario file that is read: some 50,000 obstacles."""


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
    """
    base = Path.cwd() if file is None else Path(file).resolve().parent
    try:
        data = with_current_spelling(data, file)
        scenario = Scenario.model_validate(data, context={"base": base})
    except ValidationError as error:
        raise scenario_error(error, Scenario, file) from None
    return scenario.with_file(None if file is None else Path(file))


def scenario_schema() -> dict[str, Any]:
    """The JSON Schema of scenario files."""
    schema = Scenario.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def scenario_names() -> tuple[str, ...]:
    """The shipped scenarios' names, sorted."""
    return tuple(sorted(path.stem for path in LIBRARY.glob("*.yaml")))


def scenario_descriptions() -> dict[str, str]:
    """What each shipped scenario says of itself, by name."""
    found = {}
    for name in scenario_names():
        data = parse_yaml(read_text(LIBRARY / f"{name}.yaml"))
        found[name] = str(data.get("description", "")) if isinstance(data, dict) else ""
    return found


def find_scenario(name_or_path: str | Path) -> Path:
    """The file of a shipped scenario, or the file itself; of a run's folder, its `scenario.yaml`.

    Raises:
        ScenarioError: There is neither.
    """
    name = str(name_or_path)
    names = scenario_names()
    if name in names:
        return LIBRARY / f"{name}.yaml"
    path = Path(name)
    if not name.strip() or not name.isprintable():
        raise ScenarioError(f"no file can be named {ascii(name)[:60]}", choices=names)
    try:
        if path.is_dir() and (path / "scenario.yaml").is_file():
            return path / "scenario.yaml"
        if path.is_file():
            return path
        folder = path.is_dir()
    except OSError:  # such as a name that is too long
        raise ScenarioError(f"no file can be named {ascii(name)[:60]}", choices=names) from None
    if folder:
        raise ScenarioError("a folder without scenario.yaml; expected a scenario file", file=name)
    text = "no such file or shipped scenario" + did_you_mean(name, names)
    raise ScenarioError(text, file=name, choices=names)


def read_text(path: Path) -> str:
    """The text of a scenario file.

    Raises:
        ScenarioError: It cannot be read, is too large or is no UTF-8 text.
    """
    raw = read_head(path, MAX_BYTES + 1, ScenarioError)
    if len(raw) > MAX_BYTES:
        raise ScenarioError(f"larger than {MAX_BYTES // 1_000_000} MB", file=path)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ScenarioError("not a text file; expected YAML in UTF-8", file=path) from None
