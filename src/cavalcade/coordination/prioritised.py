"""Prioritised planning: each robot avoids, in time, the paths of those before it.

After Erdmann & Lozano-Pérez, Algorithmica 2, 1987; orders are mended when they fail, as in
Bennewitz et al., ICRA 2001: who finds no path goes first, and then those before it start later.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cavalcade.coordination.cbs import conflict_search
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.robot_planner import EFFORT, Span, TeamSearch, spans_of
from cavalcade.coordination.solution import Paths, RobotPath, Solution

_DELAYS = (2.0, 4.0, 8.0, 16.0)
"""s that robots wait at their starts where no order helps."""

_CORE = 0.3
"""Of a body's size: what shy robots keep off."""

LEAVE = 3.0
"""s that robots are given to leave their starts before others come past, once that is needed."""


def in_order(
    search: TeamSearch,
    order: Sequence[int],
    delays: Mapping[int, float] | None = None,
    leave: float = 0.0,
    shy: bool = False,
    effort: int = EFFORT,
) -> tuple[dict[int, RobotPath], int | None]:
    """Plan robots one after the other, each past the paths of those before it.

    Args:
        order: All robots, the most important one first.
        delays: Robots that stand at their starts first, s.
        leave: For so long the starts of those who are still to be planned are taken, s.
        shy: Robots keep off the middle of the paths that later ones have alone, so that both give
            way where there is space for two, but not beside one that keeps to the middle.
        effort: Iterations that each robot may take.

    Returns:
        The paths, and the robot that found none or None.
    """
    planner, alone, budget = search.planner, search.alone, search.budget
    paths: dict[int, RobotPath] = {}
    for place, robot in enumerate(order):
        spans = spans_of(paths.items())
        if leave > 0.0:
            spans += [Span(k, planner.standing(k), 0.0, leave) for k in order[place + 1 :]]
        if shy:
            spans += [Span(k, alone[k].track, scale=_CORE) for k in order[place + 1 :]]
        delay = (delays or {}).get(robot, 0.0)
        path: RobotPath | None
        if delay > 0.0:
            path = planner.delayed(robot, spans, delay, budget)
        elif not spans:
            path = alone[robot]
        else:
            path = planner.plan(robot, spans, budget, effort)
        if path is None:
            return paths, robot
        paths[robot] = path
    return paths, None


def solve_sequential(search: TeamSearch) -> Solution:
    """One robot after the other, in the order of the problem (the paper's Algorithm 2).

    Each avoids the paths of all before it; conflicts that are left become constraints.
    """
    settings, order = search.settings, range(len(search.alone))
    paths: dict[int, RobotPath] = {}
    for leave in (0.0,) if settings.constraints == "static" else (0.0, LEAVE):
        paths, failed = in_order(search, order, leave=leave)
        if failed is None:
            break
    root = tuple(paths.get(k, search.alone[k]) for k in order)
    tracks = [path.track for path in root]
    if not conflicts_of(tracks, search.planner.problem.models, 1, settings.distance):
        return Solution(root, True, "sequential")
    # Somebody found no path past those before, or the trees' paths still meet.
    outcome = conflict_search(search, root)
    return Solution(outcome.paths, outcome.solved, "sequential", outcome.counts)


def mended_orders(search: TeamSearch, attempts: int, effort: int = EFFORT) -> Paths | None:
    """Paths of all robots by the first order that works, mended after each failure.

    Delays and orders are drawn once mending goes round in circles.
    """
    alone, rng = search.alone, search.rng
    order = sorted(range(len(alone)), key=lambda robot: (-round(alone[robot].cost, 3), robot))
    tried: set[tuple[tuple[int, ...], tuple[tuple[int, float], ...]]] = set()
    delays: dict[int, float] = {}
    leave, shy = 0.0, False
    for attempt in range(attempts):
        tried.add((tuple(order), tuple(sorted(delays.items()))))
        paths, failed = in_order(search, order, delays, leave, shy, effort)
        if failed is None:
            return tuple(paths[k] for k in range(len(alone)))
        if search.budget.spent:
            return None
        # In turn: the robot goes first; the others leave it time to get away; all are shy.
        leave, shy = (0.0, False) if attempt % 3 == 0 else (LEAVE, attempt % 3 == 2)
        if attempt % 3:
            continue
        order = [failed, *(robot for robot in order if robot != failed)]
        delays.pop(failed, None)
        while (tuple(order), tuple(sorted(delays.items()))) in tried:
            order = [int(robot) for robot in rng.permutation(order)]
            late = rng.integers(1, len(order) + 1)
            chosen = rng.permutation(order)[:late]
            delays = {int(robot): float(rng.choice(_DELAYS)) for robot in chosen}
    return None


def improved(search: TeamSearch, paths: Paths, rounds: int = 2) -> Paths:
    """The same with robots planned anew among all others, one at a time, while that is cheaper.

    Those that lose most by the others come first; robots that lose less than a hundredth stay.
    """
    best = list(paths)
    for _ in range(rounds):
        changed = False
        losses = [path.cost - own.cost for path, own in zip(best, search.alone, strict=True)]
        for robot in sorted(range(len(best)), key=lambda k: (-losses[k], k)):
            if losses[robot] < 0.01 * search.alone[robot].cost or search.budget.spent:
                break
            spans = spans_of((k, path) for k, path in enumerate(best) if k != robot)
            path = search.planner.plan(robot, spans, search.budget, EFFORT // 4)
            if path is not None and path.cost < best[robot].cost - 1e-6:
                best[robot] = path
                changed = True
        if not changed:
            break
    return tuple(best)
