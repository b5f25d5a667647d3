"""Messages are one line that names file, key and choices."""

from __future__ import annotations

import copy
import pickle

import pytest

from cavalcade import errors


def test_the_whole_place_is_named():
    error = errors.ScenarioError("expected a number", file="a.yaml", key="robots[0].start")
    assert str(error) == "a.yaml: robots[0].start: expected a number"


def test_choices_are_listed():
    text = str(errors.InputError("unknown shape", key="shape", choices=iter(["line", "wedge"])))
    assert text == "shape: unknown shape (one of: line, wedge)"


def test_it_stays_one_line():
    assert "\n" not in str(errors.MapError("broken\n  in two\n", file="a.yaml"))


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda error: pickle.loads(pickle.dumps(error))]
)
@pytest.mark.parametrize("kind", [errors.MapError, errors.OutputError])
def test_copies_and_pickles_keep_every_part(copied, kind):
    error = kind("unknown", file="a.yaml", key="shape", choices=("line", "wedge"))
    other = copied(error)
    assert type(other) is kind
    assert str(other) == str(error) == "a.yaml: shape: unknown (one of: line, wedge)"
    assert (other.message, other.file, other.key, other.choices) == (
        "unknown", "a.yaml", "shape", ("line", "wedge"),
    )  # fmt: skip


def test_an_error_can_be_said_of_another_place():
    error = errors.MapError("unknown", key="shape", choices=("line",)).at(file="b.yaml", key="x")
    assert isinstance(error, errors.MapError)
    assert str(error) == "b.yaml: x: unknown (one of: line)"


@pytest.mark.parametrize(
    "kind", [errors.InputError, errors.MapError, errors.ScenarioError, errors.RecordingError]
)
def test_all_are_bad_input_of_the_project(kind):
    assert issubclass(kind, errors.InputError)
    assert issubclass(kind, errors.CavalcadeError)
