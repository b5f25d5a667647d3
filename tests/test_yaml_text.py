"""YAML in: plain values only, whatever the text."""

from __future__ import annotations

import math

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import ScenarioError
from cavalcade.yaml_text import parse_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None),
        ("~", None),
        ("a: 1", {"a": 1}),
        ("[1, -2.5, +3, 0x1F, 1_000]", [1, -2.5, 3, 31, 1000]),
        ("[yes, no, true, False]", [True, False, True, False]),
        ("on: 1", {"on": 1}),
        ("1: a", {"1": "a"}),
        ("date: 2024-13-45", {"date": "2024-13-45"}),
        ("date: 2024-01-02", {"date": "2024-01-02"}),
        ("time: 12:30", {"time": "12:30"}),
        ("a: &x [1, 2]\nb: *x", {"a": [1, 2], "b": [1, 2]}),
        ("-.inf", -math.inf),
    ],
)
def test_plain_values(text: str, value: object) -> None:
    assert parse_yaml(text) == value


def test_nan_is_read_as_nan_so_that_the_schema_can_refuse_it() -> None:
    assert math.isnan(parse_yaml(".nan"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1, 2", "not valid YAML: while parsing a flow sequence"),
        ("a: 1\na: 2", "'a' stands here twice (line 2, column 1)"),
        ("base: &b {x: 1}\nc: {<<: *b}", "merge keys"),
        ("!!python/object:os.system x", "has a place here"),
        ("a: !!binary aGk=", "binary"),
        ("a: !!int abc", "expected a number"),
        ("a: !!bool perhaps", "'perhaps'"),
        ("a: !!set {b}", "set"),
        ("[1, 2]: x", "expected a name"),
        ("--- 1\n--- 2", "not valid YAML"),
        ("a: \x00", "not valid YAML"),
        ("&a [*a]", "alias 'a' has no value to repeat (line 1, column 5)"),
        ("[*a]", "alias 'a' has no value"),
        ("[&a 1, &a 2]", "anchor 'a' stands here twice"),
        ("[" * 200_000, "nested too deeply"),
        ("- " * 60, "nested too deeply"),
        ("- " * 9000, "nested too deeply"),
        ("[" * 60 + "]" * 60, "nested too deeply"),
        ("a: " + "9" * 5000, "expected a number"),
    ],
)
def test_what_has_no_place_is_one_clear_line(text: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_yaml(text, file="x.yaml", key="somewhere")
    assert message in str(caught.value)
    assert str(caught.value).startswith("x.yaml: somewhere: ")
    assert "\n" not in str(caught.value)


def test_aliases_that_unfold_without_end_are_refused_quickly() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 12)]
    with pytest.raises(ScenarioError, match="aliases unfold"):
        parse_yaml("\n".join(lines))


_TEXT = st.text(st.characters(codec="utf-8").filter(str.isprintable), max_size=20)
_PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**30), 10**30) | st.floats(allow_nan=False) | _TEXT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_TEXT, inner),
    max_leaves=12,
)


@given(_PLAIN)
@settings(max_examples=150, deadline=None)
def test_what_is_written_is_read_back(value: object) -> None:
    assert parse_yaml(yaml.safe_dump(value, allow_unicode=True)) == value


@given(
    st.text(alphabet=st.characters(codec="utf-8")) | st.text(alphabet="{}[]&*!<>:-?|'\"#%@ \nab1.")
)
@settings(max_examples=300, deadline=None)
def test_no_text_raises_anything_else(text: str) -> None:
    said = ""
    try:
        parse_yaml(text)
    except ScenarioError as error:
        said = str(error)
    assert "\n" not in said


def test_what_an_alias_repeats_is_a_value_of_its_own() -> None:
    value = parse_yaml("a: &x {b: [1]}\nc: *x")
    value["a"]["b"].append(2)
    assert value["c"] == {"b": [1]}


def test_nesting_by_aliases_is_counted_too() -> None:
    lines = ["a0: &a0 [x]", *(f"a{k}: &a{k} [*a{k - 1}]" for k in range(1, 60))]
    with pytest.raises(ScenarioError, match="nested too deeply"):
        parse_yaml("\n".join(lines))
