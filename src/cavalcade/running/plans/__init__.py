"""Plans for robots with goals of their own: made, drawn, written, and carried out."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.running.plans.planfile import read_plan, write_plan
    from cavalcade.running.plans.planning import PlanResult, plan

_HOME = {
    "PlanResult": "planning",
    "plan": "planning",
    "read_plan": "planfile",
    "write_plan": "planfile",
}

__all__ = ["PlanResult", "plan", "read_plan", "write_plan"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
