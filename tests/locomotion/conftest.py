from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, WALK, Trajectory
from cavalcade.robots import robot_model

STEP = 0.03
PIECES = ((WALK, None), (TAKE_OFF, 0.18), (FLIGHT, 0.3), (LANDING, 0.15), (WALK, None))


def _times(edges: list[float]) -> np.ndarray:
    parts = [
        np.linspace(a, b, max(2, int(np.ceil((b - a) / STEP)) + 1))[1:]
        for a, b in pairwise(edges)
        if b > a
    ]
    return np.concatenate([[0.0], *parts])


@pytest.fixture
def walk() -> Callable[..., Trajectory]:
    """Straight ahead at even speed, after `wait` s and before `rest` s of standing."""

    def make(
        length: float = 3.0,
        speed: float = 0.75,
        wait: float = 0.0,
        rest: float = 0.0,
        start: tuple[float, float, float] = (1.0, 1.0, 0.0),
    ) -> Trajectory:
        x, y, yaw = start
        moving = length / speed
        time = _times([0.0, wait, wait + moving, wait + moving + rest])
        along = speed * np.clip(time - wait, 0.0, moving)
        inner = (time > wait + 1e-9) & (time < wait + moving - 1e-9)
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        position = np.column_stack([(x, y) + along[:, None] * ahead, np.full(len(time), 0.3)])
        velocity = np.column_stack([np.where(inner, speed, 0.0)[:, None] * ahead, 0.0 * time])
        phase = np.zeros(len(time), dtype=np.int8)
        return Trajectory(time, position, velocity, np.full(len(time), yaw), phase)

    return make


@pytest.fixture
def leap() -> Callable[..., Trajectory]:
    """Along x at even speed with one leap after `before` s of walking and `after` s of it."""

    def make(before: float = 1.5, after: float = 1.5, speed: float = 1.2) -> Trajectory:
        lengths = [before, 0.18, 0.3, 0.15, after]
        edges = np.concatenate([[0.0], np.cumsum(lengths)]).tolist()
        time = _times(edges)
        middle = 0.5 * (time[:-1] + time[1:])
        kind = np.searchsorted(edges, middle) - 1
        phase = np.array([PIECES[k][0] for k in kind] + [WALK], dtype=np.int8)
        air = np.clip(time - edges[2], 0.0, 0.3)
        z = 0.3 + 9.81 * 0.5 * air * (0.3 - air)
        position = np.column_stack([1.0 + speed * time, np.full(len(time), 1.0), z])
        velocity = np.tile([speed, 0.0, 0.0], (len(time), 1))
        return Trajectory(time, position, velocity, np.zeros(len(time)), phase)

    return make


class Walkers:
    """Robots under leg control in physics.

    Args:
        names: Of the robots' models.
        poses: `(N, 3)` where they start; 1.5 m beside each other by default.
        ground: What physics has, and
        footing: what leg control knows of it.
        settings: Of the gait.
        physics: Further settings of physics.
    """

    def __init__(self, *names, poses=None, ground=None, footing=None, settings=None, physics=None):
        from cavalcade.fleet.mujoco import TeamSimulator
        from cavalcade.locomotion.control import LegControl

        models = [robot_model(name) for name in names or ("go1",)]
        if poses is None:
            poses = [[0.0, 1.5 * k, 0.0] for k in range(len(models))]
        self.simulator = TeamSimulator(models, poses, ground, physics)
        self.control = LegControl(models, footing, settings=settings)
        self.control.begin(0.0, self.simulator.qpos)
        self.torques = np.zeros((len(models), 12))

    def step(self) -> None:
        """One physics step."""
        s = self.simulator
        self.torques = self.control.step(s.time, s.qpos, s.qvel, s.foot_forces).copy()
        s.step(self.torques)

    def drive(self, command, seconds, after=None) -> None:
        """Command `(3,)` or `(N, 3)` 20 times a second, None for silence."""
        for k in range(round(seconds / self.simulator.settings.step)):
            if command is not None and k % 25 == 0:
                wanted = np.broadcast_to(np.array(command, dtype=float), (self.control.size, 3))
                self.control.command(wanted, self.simulator.time)
            self.step()
            if after is not None:
                after()

    def motion(self, command, seconds, robot=0):
        """Pose `(T, 3)` and body velocity `(T, 3)`, seen from above, while commanded so."""
        states = []
        simulator = self.simulator

        def note():
            states.append(np.append(simulator.qpos[robot, :7], simulator.qvel[robot, :6]))

        self.drive(command, seconds, note)
        states = np.array(states)
        w, x, y, z = states[:, 3:7].T
        yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        c, s, (vx, vy) = np.cos(yaw), np.sin(yaw), states[:, 7:9].T
        pose = np.column_stack([states[:, :2], yaw])
        return pose, np.column_stack([c * vx + s * vy, c * vy - s * vx, states[:, 12]])


@pytest.fixture(scope="session")
def walkers() -> type[Walkers]:
    """Makes robots under leg control in physics; skips the test without MuJoCo."""
    pytest.importorskip("mujoco")
    return Walkers
