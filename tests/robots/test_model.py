"""Robot models as data."""

from __future__ import annotations

import pytest

from cavalcade.errors import InputError
from cavalcade.robots import MODELS, robot_model


@pytest.mark.parametrize("name", MODELS)
def test_every_model_is_consistent(name):
    model = robot_model(name)
    assert model.name == name
    assert model.length >= model.width > 0.0
    assert model.max_speed_x >= model.max_speed_y > 0.0
    # Otherwise turning at full speed alone would break the acceleration limit.
    assert model.max_speed_x * model.max_yaw_rate <= model.max_acceleration
    assert model.source


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r"'go9'.*go1.*spirit"):
        robot_model("go9")
