"""The JSON Schema says of every key what it means, in which unit, and within which bounds."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from cavalcade.scenario import scenario_names, scenario_schema
from cavalcade.scenario.fields import Section, _described
from cavalcade.scenario.shipped import find_scenario

SCHEMA = scenario_schema()
SECTIONS = {"Scenario": SCHEMA, **SCHEMA["$defs"]}
KEYS = [(section, key) for section, part in SECTIONS.items() for key in part.get("properties", {})]
LENGTHS = ["Box.center", "Circle.radius", "Noise.position", "PlannerSection.r_max"]


def prop(name: str) -> dict[str, Any]:
    section, key = name.split(".")
    return SECTIONS[section]["properties"][key]


@pytest.mark.parametrize(("section", "key"), KEYS)
def test_every_key_has_a_meaning(section: str, key: str) -> None:
    said = SECTIONS[section]["properties"][key]["description"]
    assert said[0].isupper() or said[0] in "`["
    assert said.endswith(".")


@pytest.mark.parametrize("name", LENGTHS)
def test_lengths_are_in_metres(name: str) -> None:
    assert prop(name)["unit"] == "m"


def test_units_of_several_numbers_and_of_none() -> None:
    assert prop("RobotSection.start")["unit"] == "m, m, rad"
    assert prop("ConnectionSection.k_rep")["unit"] == "1/(m s)"
    assert "unit" not in prop("PhysicsSection.friction")


def test_keys_of_a_shape_are_described_where_it_moves_too() -> None:
    assert prop("Move.box")["description"] == prop("Obstacle.box")["description"]


def test_descriptions_of_sections_leave_the_keys_to_themselves() -> None:
    assert SECTIONS["Box"]["description"] == "A rectangle, turned about its centre."
    assert not any("Attributes:" in part.get("description", "") for part in SECTIONS.values())


def sections_of(cls: type[Section]) -> list[type[Section]]:
    return [cls, *(below for child in cls.__subclasses__() for below in sections_of(child))]


def test_no_docstring_describes_a_key_that_is_not_there() -> None:
    for section in sections_of(Section):
        described = set(_described(section)[1]) - {"kinds", "wanted"}
        assert described <= set(section.model_fields), section


def test_bounds_have_the_names_that_json_schema_gives_them() -> None:
    assert prop("ExecutionSection.timeout")["exclusiveMinimum"] == 0
    assert prop("ExecutionSection.timeout")["maximum"] == 86_400
    assert prop("Circle.center")["prefixItems"][0]["minimum"] == -1e6
    assert not any(f"'{name}'" in str(SCHEMA) for name in ("ge", "gt", "le", "lt"))


@pytest.mark.parametrize("name", scenario_names())
def test_shipped_scenarios_fit_the_schema(name: str) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    data = yaml.safe_load(find_scenario(name).read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(SCHEMA).validate(data)


@pytest.mark.parametrize(("timeout", "fits"), [(0.0, False), (1e-3, True), (86_401, False)])
def test_bounds_have_an_effect_in_editors(timeout: float, fits: bool) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    data = yaml.safe_load(find_scenario("cone").read_text(encoding="utf-8"))
    data.setdefault("execution", {})["timeout"] = timeout
    assert jsonschema.Draft202012Validator(SCHEMA).is_valid(data) is fits
