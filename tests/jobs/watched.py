"""A program that says, as JSON, which kernels jobs compile or load after their warm-up.

Each job is in a process of its own, forked before any kernel is there: what one loads another has
to load again, but all share the imports.
"""

from __future__ import annotations

import json
import os
import traceback
from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numba.core import event

import cavalcade as cv
from cavalcade.execution.individual_navigator import AtOnce, IndividualNavigator
from cavalcade.fleet import IdealFleet
from cavalcade.formation.settings import VARIANTS
from cavalcade.jobs.warming import all_needs
from cavalcade.kernels.cache import LOADED
from cavalcade.robots import robot_model

DELAY = "execution={delay: {mean: 0.1}, noise: {position: 0.02}}"
EVENTS = """execution.events=[
    {at: 2, move: {circle: {center: [9, 4], radius: 0.3}, to: [2, 4], speed: 0.5}},
    {at: 4, lose: 2},
    {at: 9, rejoin: 2},
]"""

RUNS: list[tuple[str, str, float, list[str]]] = [
    ("cone", "ideal", 30, []),
    ("office", "ideal", 90, []),
    ("square-clutter", "ideal", 60, [DELAY]),
    ("triangle-corridor", "ideal", 60, []),
    ("triangle-lab", "ideal", 30, ["planner.variant=published"]),
    ("cone", "ideal", 30, [EVENTS]),
    ("head-on", "ideal", 60, []),
    ("alcove", "ideal", 60, []),
    ("cone", "mujoco", 4, []),
    ("gap", "mujoco", 30, ["robots.*.model=go1"]),
]
"""Scenario, backend, timeout in s and overrides of each run."""


class Seen(event.Listener):
    """Keeps the names of kernels that are compiled or loaded while it listens."""

    def __init__(self) -> None:
        self.names: set[str] = set()

    def on_start(self, event: event.Event) -> None:
        """What begins is told of again when it ends."""

    def on_end(self, event: event.Event) -> None:
        """One more is ready."""
        function = event.data["dispatcher"].py_func if isinstance(event.data, dict) else event.data
        if function.__module__.startswith("cavalcade."):
            self.names.add(function.__qualname__)

    def listen(self) -> None:
        event.register("numba:compile", self)
        event.register(LOADED, self)

    def rest(self) -> None:
        event.unregister("numba:compile", self)
        event.unregister(LOADED, self)


def run(name: str, backend: str, timeout: float, overrides: list[str]) -> set[str]:
    """What a run takes after its warm-up, up to its last cycle."""
    seen = Seen()
    listens = True

    def cycle(frame: Any) -> None:
        nonlocal listens
        if listens and frame.status.state in ("arrived", "stuck", "infeasible"):
            seen.rest()
            listens = False

    overrides = [*overrides, f"execution.timeout={timeout}"]
    scenario = cv.load_scenario(name, overrides=overrides).with_backend(backend)
    cv.warm_up(scenario)
    seen.listen()
    cv.run(scenario, sinks=[cycle])
    # The summary is made after the last cycle; it is what looks at cells of a map.
    return seen.names - {"cells_clearance"}


def own_loop() -> set[str]:
    """What loops of one's own take after the warm-up, for each variant, with news on the way."""
    empty = cv.OccupancyMap.empty((9.0, 5.0))
    wall = empty.with_shapes([cv.Box((3.4, 1.9), (0.2, 2.6))])
    closed = empty.with_shapes([cv.Box((4.0, 2.5), (0.2, 5.0))])
    mover = cv.DynamicObstacle(cv.Circle((3.0, 4.0), 0.2), (-0.5, -0.4))
    news: dict[int, Callable[[cv.FormationPlanner], None]] = {
        5: lambda planner: planner.update_map(wall),
        10: lambda planner: planner.set_dynamic_obstacles([mover]),
        30: lambda planner: planner.set_dynamic_obstacles([]),
        35: lambda planner: planner.lose(1),
        50: lambda planner: planner.rejoin(1),
        55: lambda planner: planner.set_formation(cv.Formation.column(3, 0.9)),
        80: lambda planner: planner.update_map(closed),
    }
    seen = Seen()
    for variant in VARIANTS:
        for expected in (None, cv.Imperfections(position=0.01, delay=0.1)):
            shape = cv.Formation.triangle(1.0)
            planner = cv.FormationPlanner(empty, shape, variant=variant, expected=expected)
            cv.warm_up(planner)
            seen.listen()
            starts = np.column_stack([shape.placed((1.2, 2.5, 0.0)), np.zeros(3)])
            planner.set_goal((7.5, 2.5, 0.0))
            robots = IdealFleet([planner.model] * 3, starts)
            for cycle in range(100):
                if cycle in news:
                    news[cycle](planner)
                now = robots.observe()
                robots.send(planner.step(now.poses, now.time, now.stamps))
                robots.advance(0.05)
            seen.rest()
    return seen.names


def single_goals() -> set[str]:
    """What live goals of single robots take after the warm-up: a swap, a lost robot, a wall."""
    starts = [(1.0, y, 0.0) for y in (1.0, 2.0, 3.0)] + [(5.0, y, 3.14) for y in (1.0, 2.0, 3.0)]
    empty = cv.OccupancyMap.empty((6.0, 4.0))
    navigator = IndividualNavigator(["go1"] * 6, empty, 20.0, executor=AtOnce())
    cv.warm_up(navigator)
    seen = Seen()
    seen.listen()
    robots = IdealFleet([robot_model("go1")] * 6, starts)
    for cycle in range(240):
        if cycle == 0:
            for k in range(6):
                navigator.set_goal(k, (*starts[(k + 3) % 6][:2], starts[k][2]))
        elif cycle == 80:
            navigator.lose(1)
        elif cycle == 120:
            navigator.set_map(empty.with_shapes([cv.Box((3.0, 0.5), (0.1, 0.6))]))
        elif cycle == 160:
            navigator.set_goal(0, (3.0, 3.5, 0.0))
        now = robots.observe()
        robots.send(navigator.step(now.poses, now.time, now.stamps))
        robots.advance(0.05)
    seen.rest()
    return seen.names


def forked(job: Callable[[], set[str]]) -> list[str]:
    """What the job gives, from a process of its own; why it failed, if it did."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        try:
            found = sorted(job())
        except BaseException:
            found = [traceback.format_exc()]
        with os.fdopen(writer, "w") as pipe:
            json.dump(found, pipe)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return json.loads(text) if text else ["the process died"]


def main() -> None:
    """Import what the jobs will, and carry them out."""
    physics = find_spec("mujoco") is not None
    for needs in all_needs(everything=True):
        for module in needs.modules:
            import_module(module)
    import_module("cavalcade.jobs.running")
    found = {"own loop": forked(own_loop), "single goals": forked(single_goals)}
    for words in RUNS:
        if physics or words[1] != "mujoco":
            found[str(words)] = forked(partial(run, *words))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
