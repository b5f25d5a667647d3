"""Plans of one robot's body: RRT-Connect with stance and flight.

After Norby and Johnson, "Fast global motion planning for dynamic legged robots" (IROS 2020), the
planner below the coordinators of "Multi-Robot Motion Planning for Quadruped Robots".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.kinodynamic._primitives import path_length
from cavalcade.kinodynamic._rrt_connect import FULL, SOLVED, Sampler, search, solution
from cavalcade.kinodynamic._shortening import pull_string, round_corners, shortcut, shorten
from cavalcade.kinodynamic._trajectory_sampling import sample_path
from cavalcade.kinodynamic._tree import Tree, enlarged, make_tree
from cavalcade.kinodynamic._tree_extension import PLACES, walk_ahead
from cavalcade.kinodynamic._validity import rest_at
from cavalcade.kinodynamic.obstruction import Pose, find_path, obstruction, roomy_path
from cavalcade.kinodynamic.parameters import SIZE, make_body, make_space
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.deadline import Deadline
from cavalcade.lattice.ground import Ground, check_ground
from cavalcade.robots import RobotModel
from cavalcade.values import instance_of, pose_of, whole_number

Trees = tuple[Tree, Tree]
"""That of the start and that of the goal."""

_FIRST_LOOK = 200
"""Iterations after which it is asked whether there is a path at all."""

_SHORTCUTS = 40
"""Tries to shorten a first plan of several primitives."""

_TRIES_EACH = 10
"""The same for each primitive beyond the first."""

_ROUND = 250
"""Iterations of each new search while a plan is being improved."""


@dataclass(frozen=True, eq=False)
class BodyPlan:
    """The answer of `plan_body`; "no plan" is an answer, too.

    Attributes:
        trajectory: In the ground's frame; None without a plan.
        reason: `solved`; `infeasible`: there is none, and `detail` says why; `budget`: none was
            found before the budget was spent.
        detail: One line, empty where there is nothing to add.
        iterations: Spent in all, on the first plan and on better ones.
        history: `(K, 2)` iterations and length in m: of the first plan as it was found, after
            shortening, and of each better one.
        planning_time: Wall time, s.
    """

    trajectory: Trajectory | None
    reason: str
    detail: str
    iterations: int
    history: Array
    planning_time: float

    @property
    def solved(self) -> bool:
        """Whether there is a trajectory."""
        return self.trajectory is not None


def plan_body(
    ground: Ground,
    model: RobotModel,
    start: Sequence[float],
    goal: Sequence[float],
    settings: BodySettings | None = None,
    seed: int = 0,
) -> BodyPlan:
    """Plan the motion of one robot with legs from rest at one pose to rest at another one.

    The plan depends on the arguments alone, but for `settings.seconds`.

    Args:
        ground: What it walks on; its frame is that of the poses and of the plan.
        model: A robot with legs.
        start, goal: x and y in m, yaw in rad.
        settings: `BodySettings()` by default.
        seed: Of the random numbers.

    Raises:
        InputError: A robot without legs, or poses that are not three finite numbers.
    """
    settings = BodySettings() if settings is None else settings
    begin, end = pose_of(start, "start"), pose_of(goal, "goal")
    instance_of(settings, BodySettings, "settings")
    check_ground(ground)
    instance_of(model, RobotModel, "model")
    seed = whole_number(seed, "seed", 0, 2**64 - 1)
    problem = _Problem(ground, model, begin, end, settings, seed)
    return problem.solve()


class _Problem:
    """One call of `plan_body`."""

    def __init__(
        self,
        ground: Ground,
        model: RobotModel,
        start: Pose,
        goal: Pose,
        settings: BodySettings,
        seed: int,
    ) -> None:
        self.deadline = Deadline(settings.seconds)
        body = make_body(model, settings.variant == "published", settings.margin, settings.leaps)
        self.space = make_space(ground, body, settings.discs)
        self.settings, self.start, self.goal = settings, start, goal
        self.rng = np.array([seed % 2**64], dtype=np.uint64)
        self.yaw = np.array([start[2], goal[2]])
        self.rest: tuple[Array, Array]
        self.guide = np.zeros((0, 2))
        self.iterations = 0
        self.history: list[tuple[int, float]] = []

    def solve(self) -> BodyPlan:
        for name, pose in (("start", self.start), ("goal", self.goal)):
            why = self._obstruction(pose)
            if why:
                return self._answer("infeasible", f"the {name} {why}")
        if self.settings.iterations == 0 or self.deadline.late:
            return self._answer("budget", "no iterations were allowed")
        self.rest = (self._rest(self.start), self._rest(self.goal))
        if self.start[:2] == self.goal[:2]:
            return self._answer("solved", "", self._trajectory(np.zeros((0, SIZE))))
        edges, why = self._first()
        if edges is None:
            if why:
                return self._answer("infeasible", why)
            return self._answer("budget", "none was found within the budget")
        self._note(edges)
        if len(edges) > 1:
            edges = self._shortened(edges)
            self._note(edges)
        if self.settings.improve:
            edges = self._improved(edges)
        return self._answer("solved", "", self._trajectory(edges))

    def _obstruction(self, pose: Pose) -> str:
        """Why the robot cannot stand at a pose; without its margin if that alone is in the way."""
        why = obstruction(self.space, pose)
        if why and self.space.body.margin > 0.0:
            bare = self.space._replace(body=self.space.body._replace(margin=0.0))
            why = obstruction(bare, pose)
            if not why:
                self.space = bare
        return why

    def _rest(self, pose: Pose) -> Array:
        state = np.empty(6)
        rest_at(self.space, pose[0], pose[1], state)
        return state

    def _roots(self) -> Trees:
        return (
            make_tree(8 * PLACES, False, self.rest[0], self.start[2]),
            make_tree(8 * PLACES, True, self.rest[1], self.goal[2]),
        )

    def _first(self) -> tuple[Array | None, str]:
        """The first solution, or why there is none, empty if that is not known."""
        published = self.space.body.published
        straight = min(2, self.settings.iterations)
        edges, trees = self._search(self._roots(), 0, straight, math.inf)
        if edges is None and not published:
            # Where the grid shows a path with room to turn everywhere, its string is pulled.
            points = roomy_path(self.space, self.start, self.goal)
            if points is not None and len(points):
                pulled: Array = pull_string(self.space, points, self.yaw)
                edges = pulled if len(pulled) else None
        look = min(_FIRST_LOOK, self.settings.iterations)
        if edges is None:
            if not published:
                for tree in trees:
                    walk_ahead(self.space, tree)
            edges, trees = self._search(trees, straight, look, math.inf)
        if edges is None and not self.deadline.late:
            why, guide = find_path(self.space, self.start, self.goal)
            if why:
                return None, why
            if not published:
                self.guide = guide
            edges, trees = self._search(trees, look, self.settings.iterations, math.inf)
        return edges, ""

    def _search(
        self, trees: Trees, begin: int, end: int, bound: float
    ) -> tuple[Array | None, Trees]:
        """Search on from iteration `begin` to `end`: the solution, if any, and the trees."""
        sampler = Sampler(self.rng, self.guide, bound)
        at = begin
        for until in self.deadline.slices(begin, end):
            while at < until:
                status, reached, first, second = search(self.space, trees, sampler, at, until)
                self.iterations += reached - at
                at = reached
                if status == SOLVED:
                    return solution(trees, first, second), trees
                if status == FULL:
                    trees = (enlarged(trees[0]), enlarged(trees[1]))
        return None, trees

    def _shortened(self, edges: Array) -> Array:
        edges = shorten(self.space, edges, self.yaw)
        if self.space.body.published:
            return edges
        for _ in range(min(_SHORTCUTS, _TRIES_EACH * (len(edges) - 1))):
            if self.deadline.late:
                break
            edges, _ = shortcut(self.space, self.rng, edges, self.yaw)
        edges = shorten(self.space, edges, self.yaw)
        round_corners(self.space, edges, self.yaw)
        return edges

    def _improved(self, edges: Array) -> Array:
        """Shortcuts, and new searches where a path can still be shorter (Gammell et al. 2014)."""
        best = self._length(edges)
        straight = math.dist(self.rest[0][:3], self.rest[1][:3])
        end = self.iterations + self.settings.improve
        while self.iterations < end and not self.deadline.late:
            if best <= straight * (1.0 + 1e-6):
                break
            for _ in range(min(_SHORTCUTS, end - self.iterations)):
                self.iterations += 1
                edges, _ = shortcut(self.space, self.rng, edges, self.yaw)
            if self._length(edges) < best - 1e-6:
                best = self._length(edges)
                self._note(edges)
            rest = min(_ROUND, end - self.iterations)
            if rest <= 0:
                break
            # From iteration 2 on, so that the straight line is not tried again.
            other, _ = self._search(self._roots(), 2, 2 + rest, best)
            if other is None:
                continue
            other = self._shortened(other)
            if self._length(other) < best - 1e-6:
                edges, best = other, self._length(other)
                self._note(edges)
        return edges

    def _length(self, edges: Array) -> float:
        return float(path_length(self.space, edges))

    def _note(self, edges: Array) -> None:
        self.history.append((self.iterations, self._length(edges)))

    def _trajectory(self, edges: Array) -> Trajectory:
        times, states, yaws, phases = sample_path(self.space, edges, self.rest[0], self.yaw)
        phase: NDArray[np.int8] = phases
        return Trajectory(times, states[:, :3].copy(), states[:, 3:].copy(), yaws, phase)

    def _answer(self, reason: str, detail: str, trajectory: Trajectory | None = None) -> BodyPlan:
        history = np.array(self.history, dtype=float).reshape(-1, 2)
        time = self.deadline.elapsed
        return BodyPlan(trajectory, reason, detail, self.iterations, history, time)
