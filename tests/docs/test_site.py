"""The site has every page, and its reference every public name, key, command and option."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from types import ModuleType

import pytest

import cavalcade as cv
from cavalcade.scenario import scenario_schema

from .pages import DOCS, PAGES, ROOT


@pytest.fixture(scope="module")
def hook() -> Iterator[ModuleType]:
    folder = str(ROOT / "tools" / "site")
    sys.path.insert(0, folder)
    yield importlib.import_module("hook")
    sys.path.remove(folder)


def test_every_page_is_in_the_navigation() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text("utf-8").partition("\nnav:\n")[2]
    listed = re.findall(r": ([\w/-]+\.md)$", navigation, re.MULTILINE)
    assert sorted(listed) == sorted(page.relative_to(DOCS).as_posix() for page in PAGES[1:])


def test_every_public_name_is_in_the_reference_once() -> None:
    pages = (DOCS / "reference" / "api").glob("*.md")
    named = [
        name
        for page in pages
        for name in re.findall(r"^::: ([\w.]+)$", page.read_text("utf-8"), re.M)
    ]
    assert len(named) == len(set(named))
    assert set(cv.__all__) - {"__version__"} <= {name.rpartition(".")[2] for name in named}


def test_a_function_in_a_module_of_its_name_is_named_in_full() -> None:
    """Else the site describes the module."""
    text = "".join(page.read_text("utf-8") for page in (DOCS / "reference" / "api").glob("*.md"))
    for name in cv.__all__:
        module = getattr(getattr(cv, name), "__module__", "")
        if module.endswith(f".{name}"):
            assert f"::: {module}.{name}\n" in text


def test_every_generated_part_is_on_a_page_and_known(hook: ModuleType) -> None:
    text = "\n".join(page.read_text("utf-8") for page in PAGES)
    said = re.findall(r"^<!-- generated: (.+?) -->$", text, re.MULTILINE)
    assert sorted(said) == sorted(hook.PARTS)


def test_the_reference_of_scenarios_has_every_key(hook: ModuleType) -> None:
    text = hook.PARTS["scenario keys"]()
    schema = scenario_schema()
    for part in (schema, *schema["$defs"].values()):
        for key in part.get("properties", {}):
            assert f"\n| `{key}` | " in text
    links, anchors = re.findall(r"\]\(#(.+?)\)", text), re.findall(r"\{ #(.+?) \}", text)
    assert set(links) <= {*anchors, "generated"}
    assert len(anchors) == len(set(anchors))


def test_the_reference_of_teams_has_every_key(hook: ModuleType) -> None:
    text = hook.PARTS["team keys"]()
    for key in ("robots", "geofence", "max_age", "velocity", "interface", "use_sim_time"):
        assert f"\n| `{key}` | " in text
    assert "[mapping](scenario.md#planner)" in text


@pytest.mark.parametrize(
    "row",
    [
        "| `radius` | number > 0 | m | needed | Its radius. |",
        "| `rate` | number ≥ 1, ≤ 1000 | Hz | 20.0 | How often the planner is asked. |",
        "| `d_safe_a` | number > 0 | m | 0.8, `published` 1.5 |",
        "| `backend` | `ideal`, `mujoco`, `ros2`, `unitree` |  | `ideal` |",
        "| `start` | [number, number, number] | m, m, rad | needed |",
        "| `resolution` | number ≥ 0.001 | m | 0.05 |",
    ],
)
def test_a_row_says_value_unit_default_and_meaning(hook: ModuleType, row: str) -> None:
    assert row in hook.PARTS["scenario keys"]()


def test_the_reference_of_commands_has_every_option(hook: ModuleType) -> None:
    text = hook.PARTS["commands"]()
    for command in (
        "run",
        "plan",
        "check",
        "show",
        "schema",
        "campaign",
        "trial",
        "import",
        "ros2 navigate",
    ):
        assert f"## `{command}`" in text
    for option in ("--out DIR", "--seed N", "--method NAME", "--resume", "--force"):
        assert f"`{option}`" in text


def test_names_described_together_are_listed_apart() -> None:
    pytest.importorskip("griffe")
    sys.path.insert(0, str(ROOT / "tools" / "site"))
    try:
        from grouped_names import apart
    finally:
        sys.path.pop(0)
    text = (
        "A thing.\n\nArgs:\n    x, y: Metres,\n        in the map.\n    z: Height.\n\nIn a, b: no."
    )
    assert apart(text) == (
        "A thing.\n\nArgs:\n    x: Metres,\n        in the map.\n    y: Metres,\n"
        "        in the map.\n    z: Height.\n\nIn a, b: no.\n"
    )
