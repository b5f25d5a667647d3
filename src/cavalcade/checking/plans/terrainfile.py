"""Where raw heights come from."""

from __future__ import annotations

from cavalcade.checking.plans.heights import HOLE, Heights, disc
from cavalcade.errors import InputError, RecordingError
from cavalcade.scenario import Scenario, build_world


def read_heights(scenario: Scenario) -> Heights | None:
    """The raw heights of a scenario's ground; None where it is level.

    Of the world that the scenario makes only the heights are used, and where it has none:
    smoothing, slopes, pits and traversability are the checker's own.

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
    from scipy.ndimage import binary_erosion

    # The world tells holes with the margin that feet keep from them; here that is taken off.
    margin = disc(HOLE / terrain.resolution)
    holes = binary_erosion(terrain.traversability <= 0.0, margin, border_value=1)
    return Heights(terrain.height, terrain.resolution, terrain.origin, holes)
