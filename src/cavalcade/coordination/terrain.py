"""Robots with legs on uneven ground: on foot where that goes, else by leaps that wait their turn.

On foot means space-time A* over the ground that feet may stand on. Where it finds no path, or a
dearer one, trajectories of the body planner's trees count, each begun as late as the others'
bodies ask for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cavalcade.coordination.budget import Budget
from cavalcade.coordination.conflicts import first_conflict
from cavalcade.coordination.problem import PlanSettings
from cavalcade.coordination.robot_planner import (
    EFFORT,
    FlatPlanner,
    RobotPlanner,
    Span,
    others_among,
    planned_by_trees,
)
from cavalcade.coordination.solution import RobotPath
from cavalcade.eikonal import surface_distance
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import STEP, WALK, Trajectory
from cavalcade.kinodynamic.obstruction import obstruction
from cavalcade.kinodynamic.parameters import LEAST_TRAVERSABILITY, make_body, make_space
from cavalcade.kinodynamic.planner import BodyPlan
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground
from cavalcade.lattice.motion_limits import footprint, metre_cost, motion_limits
from cavalcade.lattice.planner import TRACK_STEP, SpaceTimePlanner
from cavalcade.robots import RobotModel

_POOL = 12
"""Trajectories of the trees that are kept for each robot."""

_LATER = 3000
"""Iterations for each of them but the first."""

_MARGIN, _LOOK = 0.05, 0.025
"""How far to keep off others, m, and how often to look, s."""

_WAITS = tuple(0.5 * k for k in range(13)) + tuple(7.0 + k for k in range(14))
"""How long to wait at the start, s."""


@dataclass(frozen=True, eq=False)
class TerrainPlanner(RobotPlanner):
    """Robots with legs on uneven ground: the cheaper of a walk and a trajectory of the trees.

    Attributes:
        walking: Over the ground that feet may stand on; by the model.
        trees: Answers of the body planner so far, by robot.
    """

    settings: PlanSettings
    seed: int
    walking: dict[RobotModel, FlatPlanner] = field(default_factory=dict)
    trees: dict[int, list[BodyPlan]] = field(default_factory=dict)

    def plan(
        self, robot: int, spans: Sequence[Span], budget: Budget, effort: int = EFFORT
    ) -> RobotPath | None:
        """See `RobotPlanner`."""
        paths = [self._by_trees(robot, spans, budget, 0.0)]
        if self.refusal(robot):
            return None
        if paths[0] is not None:
            effort = min(effort, EFFORT // 4)
        paths.append(self._walking(robot).plan(robot, spans, budget, effort))
        return _cheapest(paths)

    def delayed(
        self, robot: int, spans: Sequence[Span], delay: float, budget: Budget
    ) -> RobotPath | None:
        """See `RobotPlanner`."""
        paths = [self._walking(robot).delayed(robot, spans, delay, budget)]
        paths.append(self._by_trees(robot, spans, budget, delay))
        return _cheapest(paths)

    def refusal(self, robot: int) -> str:
        """Why the robot has no path even alone, as far as its poses or its trees prove it."""
        pool = self.trees.get(robot)
        if pool:
            return pool[0].detail if pool[0].reason == "infeasible" else ""
        problem = self.problem
        space = make_space(problem.ground, make_body(problem.models[robot]))
        for name, pose in (("start", problem.starts[robot]), ("goal", problem.goals[robot])):
            why = obstruction(space, pose)
            if why:
                return f"the {name} {why}"
        return ""

    def _walking(self, robot: int) -> FlatPlanner:
        model = self.problem.models[robot]
        if model not in self.walking:
            ground = walkable(self.problem.ground, model)
            self.walking[model] = FlatPlanner(
                replace(self.problem, ground=ground), SpaceTimePlanner(ground)
            )
        return self.walking[model]

    def _by_trees(
        self, robot: int, spans: Sequence[Span], budget: Budget, delay: float
    ) -> RobotPath | None:
        """The cheapest of the trees' trajectories and waits that meets nobody."""
        model = self.problem.models[robot]
        of_metre = metre_cost(motion_limits(model).speed)
        others = others_among(self.problem, spans)
        pool = self.trees.setdefault(robot, [])
        best: RobotPath | None = None
        met: list[float] = []
        for number in range(_POOL):
            if number == len(pool):
                if budget.spent or best is not None:
                    break
                settings = BodySettings(
                    iterations=budget.most(_LATER if number else BodySettings.iterations),
                    leaps=self.settings.leaps,
                    seconds=budget.deadline.left,
                    discs=self._keep_off(robot, spans, met) if number else np.zeros((0, 3)),
                )
                seed = (self.seed * 1_000_003 + robot) * 1_000 + number
                pool.append(planned_by_trees(self.problem, robot, settings, seed, budget))
            trajectory = pool[number].trajectory
            if trajectory is None:
                if not number and pool[number].reason == "infeasible":
                    break
                continue
            path = RobotPath(trajectory, trajectory.duration + of_metre * trajectory.length)
            for wait in _WAITS:
                late = delay + wait
                if best is not None and path.cost + late >= best.cost:
                    break
                conflict = first_conflict(
                    others, footprint(model), path.track, late, _MARGIN, _LOOK
                )
                if conflict < 0.0:
                    best = RobotPath(delayed(trajectory, late), path.cost + late)
                    break
                if wait == 0.0:
                    met.append(conflict)
                if conflict <= late:  # it cannot even wait
                    break
        return best

    def _keep_off(self, robot: int, spans: Sequence[Span], met: Sequence[float]) -> Array:
        """Discs `(K, 3)` where others begin, end, and were when earlier trajectories met them.

        They are smaller where the robot's own start or goal is near, and left out where it would
        have to touch the other one anyway.
        """
        own = np.array([self.problem.starts[robot][:2], self.problem.goals[robot][:2]])
        model = self.problem.models[robot]
        discs = []
        for span in spans:
            last = len(span.track) - 1
            at = [0, last, *(min(int(time / TRACK_STEP), last) for time in met)]
            for x, y in span.track[at, :2]:
                free = float(np.hypot(*(own - (x, y)).T).min()) - 0.02
                if free > model.width:
                    discs.append((x, y, min(model.length + 0.05, free)))
        return np.array(discs).reshape(-1, 3)


def _cheapest(paths: Sequence[RobotPath | None]) -> RobotPath | None:
    return min((p for p in paths if p is not None), key=lambda p: p.cost, default=None)


def walkable(ground: Ground, model: RobotModel) -> Ground:
    """The ground with everything solid that a foot may not stand on or the belly would touch."""
    if ground.flat or model.legs is None:
        return ground
    legs = model.legs
    above = ground.smooth + legs.h_nom - ground.height
    bad = ground.traversability < LEAST_TRAVERSABILITY
    bad |= above > legs.h_max - 0.01
    bad |= above < legs.h_min + legs.trunk_height / 2.0 + 0.02
    solid = np.ascontiguousarray(ground.solid | bad)
    clearance = np.minimum(ground.clearance, surface_distance(bad, ground.cell, border=False))
    outlines = ground.outlines
    if outlines.part.size:
        outlines = outlines._replace(part=np.where(bad, np.int32(-1), outlines.part))
    return ground._replace(solid=solid, clearance=clearance, outlines=outlines)


def delayed(trajectory: Trajectory, delay: float) -> Trajectory:
    """The same after standing at the start for `delay` s."""
    if delay <= 0.0:
        return trajectory
    count = int(np.ceil(delay / STEP - 1e-9))
    times = np.arange(count) * (delay / count)

    def stood(first: Array) -> Array:
        return np.repeat(first[None], count, axis=0)

    return Trajectory(
        np.concatenate([times, trajectory.time + delay]),
        np.concatenate([stood(trajectory.position[0]), trajectory.position]),
        np.concatenate([np.zeros((count, 3)), trajectory.velocity]),
        np.concatenate([stood(trajectory.yaw[0]), trajectory.yaw]),
        np.concatenate([np.full(count, WALK, dtype=np.int8), trajectory.phase]),
    )
