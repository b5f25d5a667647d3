"""What each backend can carry out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cavalcade.robots import MODELS
from cavalcade.scenario.fields import expected

if TYPE_CHECKING:
    from cavalcade.scenario.model import Scenario

PHYSICS_RATE = 500.0
"""Of the steps of physics, Hz; a planner is asked at most so often."""


def check_backend(scenario: Scenario) -> None:
    """Refuse what the backend cannot do.

    Raises:
        PydanticCustomError: One line with the key and what was expected.
    """
    if scenario.execution.backend != "mujoco":
        return
    for index, model in enumerate(scenario.models):
        if model.description is None:
            raise expected(
                f"physics has no masses and joints of a {model.name}; expected a robot with them",
                key=f"robots[{index}].model",
                choices=(name for name, known in MODELS.items() if known.description is not None),
            )
    if scenario.execution.rate > PHYSICS_RATE:
        raise expected(
            f"expected at most {PHYSICS_RATE:g}, the rate of the physics", key="execution.rate"
        )
