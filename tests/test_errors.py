"""Messages are one line that names file, key and choices."""

from __future__ import annotations

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
    "kind", [errors.InputError, errors.MapError, errors.ScenarioError, errors.RecordingError]
)
def test_all_are_bad_input_of_the_project(kind):
    assert issubclass(kind, errors.InputError)
    assert issubclass(kind, errors.CavalcadeError)
