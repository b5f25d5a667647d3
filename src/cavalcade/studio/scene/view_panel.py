"""What is shown of the scene: layers, and the view on the whole team."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cavalcade.studio.session import Session

_WORDS = {
    "footprints": "Footprints",
    "slots": "Goals and slots",
    "springs": "Springs (blue short, red long)",
    "paths": "Paths",
    "velocities": "Commanded velocities",
    "clearances": "Clearances between robots",
    "names": "Numbers of robots",
    "velocity map": "Velocity map of the leader",
    "arrival times": "Arrival times at the goal",
    "trajectories": "Planned trajectories",
    "footholds": "Planned footholds",
}


class ViewPanel:
    """A folder with a box to tick per layer; it belongs to no tab."""

    def __init__(self, session: Session) -> None:
        gui, stage, handle = session.server.gui, session.stage, session.handle
        self._stage = stage
        with gui.add_folder("View", expand_by_default=False, order=900.0):
            whole = gui.add_button("Whole team", icon="focus-centered")
            whole.on_click(handle(lambda _: stage.frame_team()))
            for name, visible in stage.layers.items():
                box = gui.add_checkbox(_WORDS.get(name, name), visible)
                box.on_update(handle(self._switch(name)))

    def _switch(self, name: str) -> Callable[[Any], None]:
        return lambda event: self._stage.set_layer(name, event.target.value)
