"""Arrays that are missing, malformed or out of order: named, never a traceback."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cavalcade.checking.plans.motion import read_motions
from cavalcade.robots import MODELS

NAMES = ["t", "position", "velocity", "yaw", "phase", "footholds"]


def only(report):
    (violation,) = report.violations
    return violation


@pytest.mark.parametrize("name", NAMES)
def test_a_missing_array(walker, name):
    del walker.arrays[f"{name}_0"]
    found = [v for v in walker.report().violations if v.kind == "plan"]
    assert f"there is no {name}_0" in found[0].message
    assert found[0].robots == (0,)


@pytest.mark.parametrize("name", NAMES)
def test_a_nan(walker, name):
    array = walker.arrays[f"{name}_0"].astype(float)
    array[len(array) // 2] = np.nan
    walker.arrays[f"{name}_0"] = array
    found = [v for v in walker.report().violations if v.kind == "plan"]
    assert f"{name}_0 is not finite" in found[0].message


@pytest.mark.parametrize("name", NAMES)
def test_a_wrong_shape(walker, name):
    walker.arrays[f"{name}_0"] = walker.arrays[f"{name}_0"][..., None]
    found = [v for v in walker.report().violations if v.kind == "plan"]
    assert f"{name}_0 has the shape" in found[0].message


@pytest.mark.parametrize("name", NAMES[:5])
def test_a_sample_too_few(walker, name):
    walker.arrays[f"{name}_0"] = walker.arrays[f"{name}_0"][:-1]
    assert walker.report().violations[0].kind == "plan"


def test_texts_are_no_numbers(walker):
    walker.arrays["yaw_0"] = walker.arrays["yaw_0"].astype(str)
    assert "holds no numbers" in walker.report().violations[0].message


def test_a_robot_that_the_scenario_does_not_have(walker):
    walker.arrays["t_7"] = walker.arrays["t_0"]
    violation = only(walker.report())
    assert violation.kind == "plan"
    assert violation.robots == (7,)


def test_other_arrays_are_of_no_interest(walker):
    walker.arrays["cost"] = np.array(["anything"])
    walker.arrays["torque_0"] = np.full((3, 3), np.nan)
    assert walker.report().ok


def test_times_that_go_back(walker):
    time = walker.arrays["t_0"]
    time[50] = time[49]
    violation = walker.report().violations[0]
    assert (violation.kind, violation.robots) == ("samples", (0,))
    assert violation.time == pytest.approx(time[49])


def test_a_plan_that_begins_later(walker):
    walker.arrays["t_0"] += 0.5
    violation = walker.report().violations[0]
    assert violation.kind == "samples"
    assert "begins at 0.500 s" in violation.message


def test_steps_that_are_too_long(maker, team):
    judged = team(maker((5.0, 5.0, 0.0), dt=0.04).walk(2.0))
    violation = only(judged.report())
    assert violation.kind == "samples"
    assert violation.value == pytest.approx(0.04, abs=1e-3)
    assert violation.limit == 0.03


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (1, 0, "from walk to flight"),
        (2, 1, "from take-off to landing"),
        (3, 0, "from flight to walk"),
        (3, 1, "from flight to take-off"),
    ],
)
def test_phases_out_of_order(leaper, before, after, words):
    phase = leaper.arrays["phase_0"]
    phase[phase == before] = after
    found = [v for v in leaper.report().violations if v.kind == "phase"]
    assert words in found[0].message


def test_phases_nobody_knows(leaper):
    leaper.arrays["phase_0"][10] = 4
    violation = leaper.report().violations[0]
    assert violation.kind == "phase"
    assert violation.time == leaper.arrays["t_0"][10]


@pytest.mark.parametrize(("place", "words"), [(0, "begins in flight"), (-1, "ends in flight")])
def test_a_plan_begins_and_ends_on_the_ground(walker, place, words):
    walker.arrays["phase_0"][place] = 2
    messages = [v.message for v in walker.report().violations if v.kind == "phase"]
    assert any(words in message for message in messages)


def test_a_robot_without_arrays_is_none(walker):
    motions, violations = read_motions(walker.arrays, (MODELS["go1"], MODELS["go2"]))
    assert motions[0] is not None
    assert motions[1] is None
    assert violations == []


NUMBERS = hnp.arrays(
    st.sampled_from([np.float64, np.float32, np.int8, np.bool_, np.complex128, "U3"]),
    hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=6),
)


@settings(max_examples=150, deadline=None)
@given(st.dictionaries(st.sampled_from([f"{n}_{k}" for n in NAMES for k in (0, 1)]), NUMBERS))
def test_any_arrays_are_judged(arrays):
    motions, violations = read_motions(arrays, (MODELS["go1"],))
    assert len(motions) == 1
    if any(name.endswith("_0") for name in arrays) and motions[0] is None:
        assert any(v.robots == (0,) for v in violations)
