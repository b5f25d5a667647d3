"""The paper's numbers, and values that make no sense."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.formation import (
    LABORATORY_SPRINGS,
    PRESETS,
    SIMULATION_SPRINGS,
    FormationSettings,
    SpringLaw,
)

BOTH = {
    "r_max": 0.30,
    "d_safe_a": 1.50,
    "d_safe_b": 0.50,
    "d_switch": 0.05,
    "w_min_partial": 0.70,
    "w_min_avoid": 0.50,
    "v_max_x": 0.50,
    "v_max_y": 0.20,
    "v_min": 0.50,
    "d_slowdown": 0.40,
}


@pytest.mark.parametrize(("name", "lookahead"), [("simulation", 5.0), ("laboratory", 2.5)])
def test_the_presets_are_the_papers(name, lookahead):
    settings, _ = PRESETS[name]
    for key, value in BOTH.items():
        assert getattr(settings, key) == value, key
    assert settings.lookahead == lookahead


def test_the_papers_springs():
    assert SIMULATION_SPRINGS.sides == SpringLaw(4.5, 1.25, 0.40, 0.10, 0.04)
    assert SIMULATION_SPRINGS.diagonals == SpringLaw(3.0, 0.90, 0.30, 0.10, 0.04)
    assert LABORATORY_SPRINGS.sides == SpringLaw(4.0, 2.0, 0.50, 0.10, 0.10)
    assert PRESETS["simulation"][1] is SIMULATION_SPRINGS
    assert PRESETS["laboratory"][1] is LABORATORY_SPRINGS


def test_defaults_are_the_papers_but_for_a_v_min_that_acts():
    default = FormationSettings()
    for key, value in BOTH.items():
        if key != "v_min":
            assert getattr(default, key) == value, key
    assert 0.0 < default.v_min < default.v_max_x


def test_some_values_over_the_others():
    settings = FormationSettings().with_values(r_max=0.4, lookahead=None)
    assert settings == FormationSettings(r_max=0.4)


@pytest.mark.parametrize("key", [*BOTH, "lookahead"])
@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf, "0.3", None])
def test_malformed_values_are_named(key, value):
    with pytest.raises(InputError, match=f"^{key}: expected a number"):
        FormationSettings(**{key: value})


@pytest.mark.parametrize(
    "key", ["r_max", "d_safe_a", "d_safe_b", "lookahead", "v_max_x", "v_max_y", "d_slowdown"]
)
def test_zero_makes_no_sense_for_these(key):
    with pytest.raises(InputError, match=f"^{key}: expected a number above 0"):
        FormationSettings(**{key: 0.0})


def test_w_min_avoid_must_leave_room_below_one():
    with pytest.raises(InputError, match=r"^w_min_avoid: expected a number below 1"):
        FormationSettings(w_min_avoid=1.0)
