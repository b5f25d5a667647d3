"""A scenario in which one more thing happens, checked as the file would be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario.messages import scenario_error
from cavalcade.scenario.model import ResolvedScenario, Scenario
from cavalcade.scenario.settings import Event
from cavalcade.scenario.timeline import obstacle_spans
from cavalcade.scenario.worlds import resolve_scenario
from cavalcade.world import shape_from_mapping


def scenario_with_event(
    scenario: Scenario, event: Mapping[str, Any]
) -> tuple[ResolvedScenario, Event]:
    """The scenario with one event more, after all others of that time, and that event.

    Args:
        scenario: Best a resolved one.
        event: As in a file's `execution.events`.

    Raises:
        ScenarioError: The event does not fit the schema, or cannot happen then.
    """
    resolved = resolve_scenario(scenario)
    events = resolved.execution.events
    place = f"execution.events[{len(events)}]"
    try:
        added = Event.model_validate(dict(event))
    except ValidationError as error:
        raise _at(scenario_error(error, Event, scenario.file), place) from None
    execution = resolved.execution.model_copy(update={"events": (*events, added)})
    said = {name: getattr(resolved, name) for name in Scenario.model_fields}
    try:
        checked = Scenario.model_validate({**said, "execution": execution.model_dump()})
    except ValidationError as error:
        raise scenario_error(error, Scenario, scenario.file) from None
    changed = resolved.model_copy(update={"execution": checked.execution})
    try:
        for obstacle in (added.add, added.remove, added.move):
            if obstacle is not None:
                shape_from_mapping(obstacle.to_dict())
    except InputError as error:
        raise ScenarioError(error.message, file=scenario.file, key=place) from None
    obstacle_spans(changed)
    return changed, added


def _at(error: ScenarioError, place: str) -> ScenarioError:
    key = f"{place}.{error.key}" if error.key else place
    return ScenarioError(error.message, file=error.file, key=key, choices=error.choices)
