"""The fields of the page against the schema of scenario files."""

from __future__ import annotations

import pytest

from cavalcade.formation import FormationSettings, default_settings
from cavalcade.scenario import PlannerSection
from cavalcade.studio.build.parameters import default_of, hint, parameters, text_of_value
from cavalcade.yaml_text import parse_yaml


def test_every_key_of_the_planner_has_a_field() -> None:
    found = {one.key.partition(".")[0] for one in parameters("planner")}
    assert found == set(PlannerSection.model_fields)


def test_every_parameter_says_its_unit_default_source_and_range() -> None:
    known = {one.path: one for one in parameters("planner")}
    pace = known["planner.v_max_x"]
    assert pace.label == "v_max_x (m/s)"
    assert hint(pace, {}) == (
        "Largest speed along the body. Default 0.5 m/s (Norén et al.). Range: > 0, ≤ 100."
    )
    ours = hint(known["planner.d_safe_a"], {})
    assert "Default 0.8 m (ours; Norén et al.: 1.5)." in ours
    assert all(one.meaning for one in (*parameters("planner"), *parameters("execution")))


@pytest.mark.parametrize("variant", ["cavalcade", "published", "no-springs"])
def test_defaults_are_those_of_the_variant(variant: str) -> None:
    for one in parameters("planner"):
        if hasattr(FormationSettings(), one.key):
            default, _ = default_of(one, {"variant": variant})
            assert default == getattr(default_settings(variant), one.key)


def test_defaults_are_those_of_the_preset() -> None:
    known = {one.path: one for one in parameters("planner")}
    default, source = default_of(known["planner.lookahead"], {"preset": "laboratory"})
    assert (default, source) == (2.5, "laboratory experiment of Norén et al.")


def test_values_that_depend_on_others_have_no_default_of_their_own() -> None:
    known = {one.path: one for one in parameters("planner")}
    assert known["planner.expect.noise.position"].default is None
    assert known["planner.leaps"].default is None


@pytest.mark.parametrize(
    "value",
    [1, 0.1, 1e-9, float("inf"), True, "published", [1.0, 2], {"at": 3.0, "add": {"lose": [1]}}],
)
def test_values_are_written_as_they_are_read(value: object) -> None:
    assert parse_yaml(text_of_value(value)) == value
