"""Settings of the physics."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco import PhysicsSettings


def test_one_value_for_all_or_one_per_robot():
    friction, scale = PhysicsSettings(friction=0.5, mass_scale=(1.0, 1.1)).sample(2)
    np.testing.assert_array_equal(friction, [0.5, 0.5])
    np.testing.assert_array_equal(scale, [1.0, 1.1])


def test_variation_is_drawn_by_the_seed_and_within_its_bounds():
    first = PhysicsSettings(variation=0.05, seed=3).sample(200)
    again = PhysicsSettings(variation=0.05, seed=3).sample(200)
    other = PhysicsSettings(variation=0.05, seed=4).sample(200)
    for values, same, different, middle in zip(first, again, other, (0.8, 1.0), strict=True):
        np.testing.assert_array_equal(values, same)
        assert not np.array_equal(values, different)
        assert (np.abs(values / middle - 1.0) <= 0.05).all()
        assert np.ptp(values / middle) > 0.08


@pytest.mark.parametrize(
    ("said", "key"),
    [
        ({"step": 0.0}, "step"),
        ({"step": float("nan")}, "step"),
        ({"friction": -1.0}, "friction"),
        ({"friction": (0.5, float("inf"))}, "friction"),
        ({"mass_scale": 0.0}, "mass_scale"),
        ({"variation": 1.0}, "variation"),
    ],
)
def test_impossible_settings_are_named(said, key):
    with pytest.raises(InputError, match=key):
        PhysicsSettings(**said)


def test_values_for_another_number_of_robots():
    with pytest.raises(InputError, match="friction: expected one number or 3"):
        PhysicsSettings(friction=(0.5, 0.6)).sample(3)
