"""The suites that come with the package: the YAML files in `suites/`."""

from __future__ import annotations

import warnings
from pathlib import Path

from cavalcade.campaign.suite import Suite, parse_suite, with_current_names
from cavalcade.errors import ScenarioError
from cavalcade.scenario.messages import did_you_mean
from cavalcade.scenario.shipped import read_text
from cavalcade.yaml_text import parse_yaml

SUITES = Path(__file__).parent / "suites"


def suite_names() -> tuple[str, ...]:
    """The shipped suites' names, sorted."""
    return tuple(sorted(path.stem for path in SUITES.glob("*.yaml")))


def load_suite(name_or_path: str | Path) -> Suite:
    """Read a suite.

    Args:
        name_or_path: A shipped suite's name, or a file.

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
    """The file of a shipped suite, or the file itself.

    Raises:
        ScenarioError: There is neither.
    """
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
