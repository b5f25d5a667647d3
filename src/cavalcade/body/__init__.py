"""Motion of one robot's body over ground: what coordinators build on.

The names below are imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.body.ground import Ground, make_ground
    from cavalcade.body.planner import BodyPlan, plan_body
    from cavalcade.body.settings import BodySettings
    from cavalcade.body.trajectory import Trajectory

_HOME = {
    "BodyPlan": "planner",
    "BodySettings": "settings",
    "Ground": "ground",
    "Trajectory": "trajectory",
    "make_ground": "ground",
    "plan_body": "planner",
}

__all__ = ["BodyPlan", "BodySettings", "Ground", "Trajectory", "make_ground", "plan_body"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value
