"""All kernels that a job takes, compiled or loaded before it begins, by a rehearsal.

A rehearsal is a small job of the same kind that lasts a moment. Nothing is compiled within a
control cycle or a time budget then, and what is compiled is seen.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.execution.individual_navigator import AtOnce, IndividualNavigator
from cavalcade.execution.loop import carry_out
from cavalcade.fleet import IdealFleet
from cavalcade.formation import FormationPlanner
from cavalcade.formation.settings import VARIANTS
from cavalcade.jobs.planning import make_plan
from cavalcade.jobs.reporter import JobReporter, Reporter
from cavalcade.jobs.tasks import TASKS
from cavalcade.robots import robot_model
from cavalcade.scenario import (
    Scenario,
    build_world,
    load_scenario,
    parse_scenario,
    resolve_scenario,
)
from cavalcade.scenario.rules import LIVE
from cavalcade.values import described
from cavalcade.world import OccupancyMap

# Where the kernels of jobs are, for the estimate of what there is to do.
_MEASURED = (
    "cavalcade.geometry.string_pulling",
    "cavalcade.geometry.distances",
)
_FORMATION = ("cavalcade.eikonal", "cavalcade.formation", "cavalcade.robots.motion")
_PLANS = (
    "cavalcade.coordination",
    "cavalcade.eikonal.field",
    "cavalcade.lattice",
    "cavalcade.locomotion.footholds",
)
_UNEVEN = ("cavalcade.kinodynamic", "cavalcade.world.terrain.filters")
_PHYSICS = ("cavalcade.locomotion.control", "cavalcade.fleet.mujoco")

# Those of them that few jobs take: compiled when they are.
_JOINT = ("cavalcade.coordination._joint",)
_RARE = (
    "cavalcade.geometry.distances.cells_clearance",
    "cavalcade.geometry.distances.nearest_gaps",
    "cavalcade.geometry.string_pulling.string_pulled_length",
)
_SURFACE = ("cavalcade.lattice.surface", "cavalcade.coordination.conflicts.first_conflict")
_MOVING = ("cavalcade.formation._evasive_motion",)


@dataclass(frozen=True)
class Needs:
    """What decides which kernels a job takes.

    Attributes:
        kind: Of the task: `formation`, `individual` or `commands`.
        backend: That carries it out; None where nothing is carried out.
        variant, method: The planner's.
        uneven: Its ground has heights.
        moving: Something may move on the way.
        live: Goals of its own that each robot has may change at any time.
    """

    kind: str
    backend: str | None = "ideal"
    variant: str = "cavalcade"
    method: str = "auto"
    uneven: bool = False
    moving: bool = False
    live: bool = False

    @property
    def modules(self) -> tuple[str, ...]:
        """Where its kernels are."""
        kinds: dict[str, tuple[str, ...]] = {"formation": _FORMATION, "individual": _PLANS}
        found = kinds.get(self.kind, ())
        if self.uneven:
            found += _UNEVEN
        if self.live:
            found += ("cavalcade.execution",)
        if self.backend is not None:
            found += _PHYSICS if self.backend == "mujoco" else ("cavalcade.fleet.ideal",)
        return found + _MEASURED

    @property
    def unused(self) -> tuple[str, ...]:
        """What it does not take of these."""
        surface = () if self.uneven else _SURFACE
        rare = _RARE + surface if self.live else _RARE + surface + _JOINT
        return rare if self.moving else rare + _MOVING


def needs_of(scenario: Scenario, backend: str | None) -> Needs:
    """What a job of the scenario takes, carried out by a backend or, if None, only planned.

    Robots that live in a time of their own are rehearsed with ideal ones.
    """
    return Needs(
        scenario.task.kind,
        "ideal" if backend in LIVE else backend,
        scenario.planner.variant,
        scenario.planner.method if scenario.goals else "auto",
        scenario.world.has_heights,
        bool(scenario.execution.events),
    )


def warm_up(
    *whats: Scenario | str | Path | FormationPlanner | IndividualNavigator, quiet: bool = True
) -> None:
    """Compile or load the kernels that jobs or a control loop of your own will call.

    The first time on a machine this takes from some seconds to a minute. Call it before a loop
    that has to keep a rate.

    Args:
        whats: Scenarios, loaded or by name or file, for runs and plans of them; a
            `FormationPlanner` or an `IndividualNavigator` for loops around it; nothing for all that
            formations take.
        quiet: Print nothing; otherwise the progress.

    Raises:
        InputError: A scenario cannot be read.
    """
    wanted = [needs for what in whats for needs in _needs(what)]
    with Reporter(quiet) as reporter:
        warm(wanted or [Needs("formation", moving=True)], reporter)


def warm(wanted: Iterable[Needs], reporter: Reporter) -> None:
    """The same for needs, each of them once in a process, with the progress said."""
    wanted = list(dict.fromkeys(wanted))
    modules = dict.fromkeys(module for needs in wanted for module in needs.modules)
    unused = set.intersection(*(set(needs.unused) for needs in wanted)) if wanted else ()
    with reporter.compiling(modules, unused):
        for needs in wanted:
            _rehearse(needs)


def all_needs(everything: bool) -> list[Needs]:
    """What formations and plans on even ground take; with `everything`, what any job does."""
    formation = Needs("formation", moving=True)
    found = [formation, Needs("individual")]
    if not everything:
        return found
    found += [replace(formation, variant=name) for name in VARIANTS]
    found += [Needs("individual", None, live=True), Needs("individual", None, uneven=True)]
    found += [Needs("individual", None, "published", method) for method in ("cbs", "joint")]
    try:
        from cavalcade.fleet.mujoco.engine import load_mujoco

        load_mujoco()
    except InputError:  # an extra that not everybody has
        return found
    found += [Needs(kind, "mujoco") for kind in TASKS]
    return [*found, Needs("individual", "mujoco", uneven=True)]


def _needs(
    what: Scenario | str | Path | FormationPlanner | IndividualNavigator,
) -> list[Needs]:
    if isinstance(what, FormationPlanner):
        return [Needs("formation", None, what.variant.name, moving=True)]
    if isinstance(what, IndividualNavigator):
        return [Needs("individual", None, live=True)]
    wanted = "a scenario, its name or file, a FormationPlanner or an IndividualNavigator"
    if not isinstance(what, Scenario | str | Path):
        raise InputError(f"expected {wanted}, got {described(what)}", key="whats")
    scenario = what if isinstance(what, Scenario) else load_scenario(what)
    needs = needs_of(scenario, scenario.execution.backend)
    return [needs, replace(needs, backend=None)] if scenario.goals else [needs]


@cache
def _rehearse(needs: Needs) -> None:
    """Do a job that takes the same kernels, once in a process."""
    if needs.live:
        for method in ("auto", "joint"):
            _rehearse(replace(needs, method=method, live=False))
        _drive_live()
        return
    scenario = resolve_scenario(parse_scenario(_rehearsal(needs)))
    world = build_world(scenario)
    if needs.backend is None and scenario.goals:
        make_plan(scenario, world)
        return
    task = TASKS[needs.kind](scenario, world, JobReporter(scenario.name, quiet=True))
    robots = task.make_fleet()
    policy = task.make_policy(robots)
    done = carry_out(scenario, world, policy, robots, budget=task.budget)
    if needs.backend is not None:
        task.summarise(policy, done)


def _drive_live() -> None:
    """Robots on their way to goals that change, of which one is lost."""
    room = OccupancyMap.empty((6.0, 4.0))
    starts = ((1.0, 1.0, 0.0), (1.0, 2.0, 0.0), (5.0, 3.5, 0.0))
    navigator = IndividualNavigator(("spirit",) * 3, room, 20.0, executor=AtOnce())
    fleet = IdealFleet([robot_model("spirit")] * 3, starts)
    for cycle in range(60):
        if cycle == 0:
            navigator.set_goal(0, (3.0, 2.0, 0.0))
            navigator.set_goal(1, (3.0, 1.0, 0.0))
        elif cycle == 30:
            navigator.lose(2)
        seen = fleet.observe()
        fleet.send(navigator.step(seen.poses, seen.time, seen.stamps))
        fleet.advance(0.05)


def _rehearsal(needs: Needs) -> dict[str, Any]:
    """The scenario of a rehearsal, as its file would say it."""
    said: dict[str, Any] = {
        "version": 1,
        "name": "rehearsal",
        "world": {"empty": {"size": [6.0, 4.0]}},
        "execution": {"backend": needs.backend or "ideal", "timeout": 0.5},
    }
    return said | _REHEARSALS[needs.kind](needs, said["execution"])


def _formation(needs: Needs, execution: dict[str, Any]) -> dict[str, Any]:
    # The goal is beyond the look-ahead and one box in the way: robots look for paths round it. The
    # other one is so near to a robot that it has to leave the inflated zone first.
    boxes = [
        {"center": [2.2, 2.0], "size": [0.2, 1.2]},
        {"center": [1.0, 2.78], "size": [0.2, 0.2]},
    ]
    execution |= {"noise": {"position": 0.01}, "delay": {"mean": 0.1}}
    if needs.moving:
        moving = {"center": [3.5, 0.6], "radius": 0.2}
        move = {"circle": moving, "to": [0.5, 0.6], "speed": 1.0}
        execution["events"] = [{"at": 0.1, "move": move}]
    return {
        "world": {"empty": {"size": [12.0, 4.0]}, "obstacles": [{"box": box} for box in boxes]},
        "robots": [{"model": "go1", "start": [1.0, y, 0.0]} for y in (1.6, 2.4)],
        "task": {"formation": {"shape": "line", "spacing": 0.8}, "goals": [[10.5, 2.0, 0.0]]},
        "planner": {"variant": needs.variant},
    }


def _individual(needs: Needs, execution: dict[str, Any]) -> dict[str, Any]:
    model, turned = "go1" if needs.backend == "mujoco" else "spirit", 3.14159
    found: dict[str, Any] = {
        "robots": [
            {"model": model, "start": [1.0, 2.0, 0.0], "goal": [5.0, 2.0, 0.0]},
            {"model": model, "start": [5.0, 2.0, turned], "goal": [1.0, 2.0, turned]},
        ],
        "task": {"goals": "individual"},
        "planner": {
            "variant": needs.variant,
            "method": needs.method,
            "budget": {"iterations": 20_000},
        },
    }
    # With an obstacle, so that the way is looked for on the grid.
    box = {"center": [3.0, 0.4], "size": [0.2, 0.2]}
    found["world"] = {"empty": {"size": [6.0, 4.0]}, "obstacles": [{"box": box}]}
    if needs.uneven:
        found["world"] = {"generate": {"kind": "step", "size": [6.0, 4.0], "height": 0.1}}
    return found


def _commands(needs: Needs, execution: dict[str, Any]) -> dict[str, Any]:
    execution["timeout"] = 2.0
    return {
        "robots": [{"model": "go1", "start": [1.0, 2.0, 0.0]}],
        "task": {"commands": [{"at": 0.0, "velocity": [0.2, 0.0, 0.0]}]},
    }


_REHEARSALS = {"formation": _formation, "individual": _individual, "commands": _commands}
