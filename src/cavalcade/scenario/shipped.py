"""The scenarios that come with the package: the YAML files in `library/`.

Apart from reading scenarios, so that they are listed without numpy and pydantic.
"""

from __future__ import annotations

from pathlib import Path

from cavalcade.errors import ScenarioError
from cavalcade.files import read_head
from cavalcade.yaml_text import parse_yaml

LIBRARY = Path(__file__).parent / "library"

MAX_BYTES = 8_000_000
"""Largest scenario file that is read: some 50,000 obstacles."""


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
    from cavalcade.values import did_you_mean

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
