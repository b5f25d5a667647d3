"""Where raw heights come from."""

from __future__ import annotations

from cavalcade.checking.plans.heights import Heights
from cavalcade.errors import InputError, RecordingError
from cavalcade.scenario import Scenario, build_world


def read_heights(scenario: Scenario) -> Heights | None:
    """The raw heights of a scenario's ground; None where it is level.

    Of the world that the scenario makes only the heights are used: smoothing, slopes and
    traversability are the checker's own.

    Raises:
        RecordingError: They cannot be made.
    """
    if not scenario.world.has_heights:
        return None
    try:
        terrain = build_world(scenario).terrain
    except InputError as error:
        raise RecordingError(str(error)) from error
    if terrain is None:
        return None
    return Heights(terrain.height, terrain.resolution, terrain.origin)
