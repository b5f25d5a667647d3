"""Robots that stand, worked out by hand, and robots that are simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cavalcade.checking.physics import Floor, RobotRecord, Touch, judge_robots
from cavalcade.checking.physics.joints import holding_torques
from cavalcade.checking.physics.kinematics import posture
from cavalcade.checking.report import Violation
from cavalcade.robots import robot_model

GO1 = robot_model("go1").description
GRAVITY = 9.81
STEP = 0.02
PARTS = ("trunk", "hip", "thigh", "calf", "foot")


def still(seconds: float = 3.0, robot: int = 0, place: tuple[float, float] = (0.0, 0.0)):
    """A record without forces and torques of a robot that stands as it is made to stand."""
    time = STEP * np.arange(round(seconds / STEP) + 1)
    base = np.zeros((len(time), 7))
    base[:, :3] = (*place, GO1.stand_height)
    base[:, 3] = 1.0
    joints = np.tile(GO1.standing, (len(time), 1))
    nothing = np.zeros_like(joints)
    return RobotRecord(robot, time, base, joints, nothing, nothing, np.zeros((len(time), 4, 3)))


def carried(record: RobotRecord) -> RobotRecord:
    """With forces on the feet that account for the motion, and torques that hold them.

    Quasi-static: the forces' sum is weight plus mass times acceleration, their moment about the
    centre of mass vanishes.
    """
    links = posture(record, GO1)
    mass, step = links.weight, np.diff(record.time)[:, None]
    speed = np.zeros((len(record.time) + 1, 3))
    speed[1:-1] = np.diff(links.center, axis=0) / step
    wanted = mass * np.diff(speed, axis=0) / STEP + (0.0, 0.0, mass * GRAVITY)
    forces = np.zeros((len(record.time), 4, 3))
    for k in range(1, len(record.time)):
        # A force recorded with a sample is the mean over the interval before it.
        total = 0.5 * (wanted[k] + wanted[k - 1])
        center = 0.5 * (links.center[k] + links.center[k - 1])
        soles = 0.5 * (links.feet[k] + links.feet[k - 1]) - (0.0, 0.0, links.radius) - center
        rows = np.zeros((6, 12))
        for leg, (x, y, z) in enumerate(soles):
            columns = slice(3 * leg, 3 * leg + 3)
            rows[:3, columns] = np.eye(3)
            rows[3:, columns] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        forces[k] = (np.linalg.pinv(rows) @ np.concatenate((total, np.zeros(3)))).reshape(4, 3)
    forces[0] = forces[1]
    loaded = replace(record, forces=forces)
    held = holding_torques(loaded, posture(loaded, GO1))
    return replace(loaded, torques=np.vstack((held[:1], held)))


def with_rates(record: RobotRecord) -> RobotRecord:
    """With rates that are the angles' change."""
    return replace(record, rates=np.gradient(record.joints, record.time, axis=0))


@pytest.fixture
def standing() -> RobotRecord:
    """A robot that stands for 3 s."""
    return carried(still())


@pytest.fixture
def verdict() -> Callable[..., list[Violation]]:
    """Judge Go1s on level ground."""

    def give(*records: RobotRecord, **more: Any) -> list[Violation]:
        return judge_robots(records, [GO1] * len(records), Floor(), **more)

    return give


class Recorder:
    """What a simulation leaves, read from MuJoCo's own data: nothing of the project's recorders."""

    def __init__(self, simulator: Any, every: int = 10) -> None:
        self.simulator, self.every = simulator, every
        robots = simulator.size
        self.rows: list[tuple[Any, ...]] = []
        self.touches: list[list[Touch]] = [[] for _ in range(robots)]
        self.forces = np.zeros((robots, 4, 3))
        self.torques = np.zeros((robots, 12))
        self.count = 0
        self._told: set[Any] = set()
        self._sample()

    def step(self, torques: Any) -> None:
        self.simulator.step(torques)
        given = self.simulator.torques
        self.torques = np.where(np.abs(given) > np.abs(self.torques), given, self.torques)
        self._read_contacts()
        self.count += 1
        if self.count % self.every == 0:
            self.forces /= self.every
            self._sample()

    def _sample(self) -> None:
        state, rates = self.simulator.qpos, self.simulator.qvel
        self.rows.append(
            (self.simulator.time, state, rates, self.torques.copy(), self.forces.copy())
        )
        self.forces[:] = 0.0
        self.torques[:] = 0.0
        self._told.clear()

    def _read_contacts(self) -> None:
        import mujoco

        team, data = self.simulator.team, self.simulator.data
        force, now = np.zeros(6), set()
        for k in range(data.ncon):
            contact = data.contact[k]
            if contact.efc_address < 0:
                continue
            mujoco.mj_contactForce(team.model, data, k, force)
            # From the first geom to the second, in the map frame.
            world = contact.frame.reshape(3, 3).T @ force[:3]
            for geom, other, sign in ((*contact.geom, -1.0), (*contact.geom[::-1], 1.0)):
                robot, part = team.geom_robot[geom], team.geom_part[geom]
                if robot < 0:
                    continue
                if PARTS[part] == "foot" and team.geom_robot[other] < 0:
                    self.forces[robot, team.geom_leg[geom]] += sign * world
                if (
                    PARTS[part] == "foot"
                    and team.geom_robot[other] < 0
                    and not team.geom_part[other]
                ):
                    continue
                what = "ground" if team.geom_part[other] == 0 else "obstacle"
                if team.geom_robot[other] >= 0:
                    what = f"robot {team.geom_robot[other]}"
                now.add((int(robot), PARTS[part], what))
        # Once in every interval between samples, at the first moment.
        for robot, part, what in sorted(now - self._told):
            self.touches[robot].append(Touch(self.simulator.time, part, what))
        self._told |= now

    def records(self) -> list[RobotRecord]:
        time = np.array([row[0] for row in self.rows])
        state, rates, torques, forces = (
            np.array([row[k] for row in self.rows]) for k in range(1, 5)
        )
        return [
            RobotRecord(
                k,
                time,
                state[:, k, :7],
                state[:, k, 7:],
                rates[:, k, 6:],
                torques[:, k],
                forces[:, k],
                tuple(self.touches[k]),
            )
            for k in range(self.simulator.size)
        ]
