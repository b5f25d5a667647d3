"""Robot models as data."""

from __future__ import annotations

import math

import pytest

from cavalcade.errors import InputError
from cavalcade.robots import MODELS, robot_model

LEGGED = [name for name, model in MODELS.items() if model.legs is not None]
OTHERS = [name for name in MODELS if name not in LEGGED]


@pytest.mark.parametrize("name", MODELS)
def test_every_model_is_consistent(name):
    model = robot_model(name)
    assert model.name == name
    assert model.length >= model.width > 0.0
    assert not model.round or model.length == model.width
    assert model.max_speed_x >= model.max_speed_y >= 0.0
    assert (model.legs is not None) == (model.drive == "legged")
    assert math.isinf(model.max_acceleration) == (model.drive in ("unicycle", "integrator"))
    assert model.source


@pytest.mark.parametrize("name", LEGGED)
def test_robots_with_legs_can_walk_in_formation(name):
    model = robot_model(name)
    assert model.max_speed_y > 0.0
    # Otherwise turning at full speed alone would break the acceleration limit.
    assert model.max_speed_x * model.max_yaw_rate <= model.max_acceleration


@pytest.mark.parametrize("name", LEGGED)
def test_legs_reach_and_fit_under_the_body(name):
    model = robot_model(name)
    legs = model.legs
    assert 0.0 < legs.h_min < legs.h_nom < legs.h_max
    assert 0.0 < legs.v_nom < legs.v_max
    assert 2.0 * legs.hip_x < model.length
    assert 2.0 * legs.hip_y < model.width
    assert legs.acceleration <= legs.mu * 9.81
    assert 0.0 < legs.duty < 1.0
    assert legs.grf_max > 1.0
    assert legs.source


@pytest.mark.parametrize(
    ("name", "size", "speed", "acceleration"),
    [
        ("unicycle", (0.5, 0.25), 0.5, math.inf),
        ("unicycle-sphere", (0.8, 0.8), 0.5, math.inf),
        ("unicycle-2", (0.5, 0.25), 0.5, 0.25),
        ("single-integrator", (0.2, 0.2), 0.5, math.inf),
        ("double-integrator", (0.3, 0.3), 0.5, 2.0),
    ],
)
def test_published_figures_of_other_drives(name, size, speed, acceleration):
    model = robot_model(name)
    assert (model.length, model.width) == size
    assert model.max_speed_x == speed
    assert model.max_acceleration == acceleration
    assert set(OTHERS) == {
        "unicycle",
        "unicycle-sphere",
        "unicycle-2",
        "single-integrator",
        "double-integrator",
    }


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r"'go9'.*go1.*spirit"):
        robot_model("go9")
