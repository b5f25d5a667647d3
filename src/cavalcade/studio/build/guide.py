"""What a draft comes to, and what to do next, in a few words."""

from __future__ import annotations

from collections import Counter
from typing import Literal, NamedTuple

from cavalcade.studio.build.draft import Checked
from cavalcade.studio.build.edits import is_individual, slots_at
from cavalcade.studio.build.placing import is_free

QUICK = "Team of 4 go1 in a square"
"""The shortest way to a scenario that runs."""

TOOLS = {
    "Select": "Click a robot or an obstacle to select it; drag its handles to move and turn it.",
    "Box": "Click one corner of the box, then the opposite one.",
    "Circle": "Click the circle's centre, then a point on its rim.",
    "Wall": "Click one end of the wall, then the other.",
    "Robot": "Click where a robot is to stand.",
    "Goal": "Click where the team is to go; further clicks add waypoints.",
}
"""What clicks on the ground do, by tool."""

OWN_GOALS = "Click where the selected robot is to go."

SECOND = {
    "Box": "Now click the opposite corner.",
    "Circle": "Now click a point on the rim.",
    "Wall": "Now click the other end.",
}


class Advice(NamedTuple):
    """What is said at the top of the page: `ready`, or what to do `next`."""

    tone: Literal["ready", "next"]
    text: str


def advice(state: Checked) -> Advice:
    """What a draft comes to, or what it needs next."""
    data = state.data
    if not state.robots:
        return Advice("next", f"Next: add robots. “{QUICK}” makes a team ready to run.")
    individual = is_individual(data)
    if not individual and not state.goals and not (data.get("task") or {}).get("commands"):
        return Advice("next", "Next: set a goal. Choose Goal above and click on the ground.")
    if state.missing is not None:
        return Advice("next", f"Still to do: {state.missing}")
    return Advice("ready", f"Ready to run: {summary(state)}. Open Drive to start.")


def summary(state: Checked) -> str:
    """The team and its task in a line."""
    count = Counter(model.name for model, _ in state.robots)
    team = ", ".join(f"{many} {name}" for name, many in count.items())
    goals = "" if is_individual(state.data) else f", {_many(len(state.goals), 'goal')}"
    return f"{team}, {state.shown.task.headline}{goals}, {state.shown.execution.backend}"


def notes(state: Checked) -> list[str]:
    """What is probably not meant, in words."""
    said = list(state.notes)
    section = state.shown.task.formation
    if section is None or state.missing is not None:
        return said
    formation = section.model_dump(exclude_none=True)
    for index, goal in enumerate(state.goals):
        slots = [slot[:2] for slot in slots_at(formation, len(state.robots), goal)]
        if not is_free(state.world.map, slots).all():
            said.append(f"Goal {index}: the team does not fit; it will go to the nearest place.")
    return said


def ground(state: Checked) -> str:
    """The ground in a line."""
    base, source = state.world.base, state.data["world"]
    width, height = base.size
    kind = next((key for key in ("map", "terrain") if key in source), None)
    names = [source.get("movingai", {}).get("file"), source.get("barn", {}).get("file")]
    name = source[kind] if kind else next(filter(None, names), None)
    what = str(name).rpartition("/")[2] if name else state.shown.world.kind
    if "generate" in source:
        what = f"generated {source['generate']['kind']}"
    obstacles = _many(len(state.shown.world.obstacles), "obstacle")
    return f"{what}, {width:g} × {height:g} m, cells of {base.resolution:g} m, {obstacles}"


def _many(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
