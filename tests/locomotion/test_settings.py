"""Settings of the gait that make no sense are refused by their name."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.locomotion.settings import GaitSettings

BAD = {
    "period": [0.0, -0.3, float("nan"), float("inf")],
    "duty": [0.0, 1.0, -0.1, float("nan")],
    "height": [0.0, -0.2, float("nan")],
    "clearance": [-0.01, float("nan")],
    "capture": [-0.01],
    "acceleration": [0.0, -1.0],
    "turning": [0.0, float("inf")],
    "silence": [0.0],
    "weights": [(1.0,) * 11, (1.0,) * 11 + (-1.0,), (1.0,) * 11 + (float("nan"),)],
    "force_weight": [0.0, -1e-5],
    "mu": [0.0, -0.5],
    "max_force": [0.0],
    "step": [0.0, -0.04],
    "interval": [0.0],
    "stiffness": [-1.0],
    "joint_damping": [-1.0],
    "touch": [0.0, float("nan")],
    "leash": [-0.1],
    "turn_leash": [-0.1],
}


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in BAD.items() for v in values])
def test_values_that_make_no_sense_are_refused(name, value):
    with pytest.raises(InputError) as error:
        GaitSettings(**{name: value})
    assert error.value.key == name
    assert str(error.value).startswith(f"{name}: expected ")


def test_every_setting_is_checked():
    assert set(BAD) == set(GaitSettings.__dataclass_fields__)


def test_a_row_has_the_settings_and_what_a_robot_adds():
    settings = GaitSettings(period=0.4, mu=0.5, max_force=1.2)
    row = settings.row(12.0, 0.28)
    assert (row["period"], row["mu"], row["height"]) == (0.4, 0.5, 0.28)
    assert row["max_force"] == pytest.approx(1.2 * 12.0 * 9.81)
    np.testing.assert_array_equal(row["weights"], settings.weights)
    assert GaitSettings(height=0.25).row(12.0, 0.28)["height"] == 0.25
