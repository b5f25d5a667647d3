"""What each backend can carry out."""

from __future__ import annotations

from cavalcade.robots import MODELS
from cavalcade.scenario.fields import expected
from cavalcade.scenario.parts import Parts

BACKENDS = ("ideal", "mujoco")
"""Who can move robots."""

SLOWEST, FASTEST = 2.5, 500.0
"""How often a planner is asked, Hz: robots stop 0.5 s after their last command, and there are 500
steps of physics a second."""


def check_backend(scenario: Parts) -> None:
    """Refuse what the backend cannot do.

    Raises:
        PydanticCustomError: One line with the key and what was expected.
    """
    ideal = scenario.execution.backend != "mujoco"
    for index, command in enumerate(scenario.task.commands or ()):
        if ideal and command.leap is not None:
            raise expected(
                "ideal robots do not leap when they are told to; expected backend mujoco",
                key=f"task.commands[{index}].leap",
            )
    for index, event in enumerate(scenario.execution.events):
        key, last = f"execution.events[{index}].push", len(scenario.robots) - 1
        if ideal and event.push is not None:
            raise expected("ideal robots cannot be pushed; expected backend mujoco", key=key)
        if event.push is not None and event.push.robot > last:
            text = f"there is no robot {event.push.robot}; expected 0 to {last}"
            raise expected(text, key=f"{key}.robot")
    if ideal:
        return
    for index, (robot, model) in enumerate(zip(scenario.robots, scenario.models, strict=True)):
        if model.description is None and (robot.mjcf is None or model.legs is None):
            raise expected(
                f"physics has no masses and joints of a {model.name}; expected a robot with them, "
                "such as with --set 'robots.*.model=go1'",
                key=f"robots[{index}].model",
                choices=(name for name, known in MODELS.items() if known.description is not None),
            )
    if not SLOWEST <= scenario.execution.rate <= FASTEST:
        raise expected(
            f"expected {SLOWEST:g} to {FASTEST:g} in physics: robots stop 0.5 s after a command",
            key="execution.rate",
        )
