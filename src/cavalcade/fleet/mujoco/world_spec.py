"""Robots and ground in one MuJoCo model, and which of its shapes is what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.ground import PhysicsGround
from cavalcade.fleet.mujoco.ground_spec import add_ground
from cavalcade.fleet.mujoco.own_model import RobotSpec
from cavalcade.fleet.mujoco.robot_spec import TOUCH_SENSORS, robot_bits, robot_spec
from cavalcade.fleet.mujoco.settings import PhysicsSettings
from cavalcade.geometry import Array
from cavalcade.robots.description import PARTS, QuadrupedDescription

GROUND, OBSTACLE = 0, 1
"""What a shape of the world is."""

PREFIX = "robot_{}/"
"""Of the names of a robot's things."""


@dataclass(frozen=True)
class TeamModel:
    """The compiled model of a team and where the robots' things are in it.

    Attributes:
        model: The `MjModel`.
        trunks: `(N,)` bodies of the trunks.
        qpos: `(N, 19)` places in `qpos`: position, quaternion w, x, y, z, joints.
        qvel: `(N, 18)` places in `qvel`: velocity in the world, rates in the body, joints' rates.
        motors: `(N, 12)` actuators.
        touch: `(N, 4)` places in `sensordata`.
        obstacles: `(M,)` rows of the movable obstacles in `mocap_pos`.
        geom_robot: `(G,)` the robot that a shape belongs to; -1 for the world's.
        geom_part: `(G,)` index in `PARTS` of a robot's shape; `GROUND` or `OBSTACLE` of the
            world's.
        geom_leg: `(G,)` leg of a robot's shape; -1 for trunks and the world's.
    """

    model: Any
    trunks: NDArray[np.int64]
    qpos: NDArray[np.int64]
    qvel: NDArray[np.int64]
    motors: NDArray[np.int64]
    touch: NDArray[np.int64]
    obstacles: NDArray[np.int64]
    geom_robot: NDArray[np.int64]
    geom_part: NDArray[np.int64]
    geom_leg: NDArray[np.int64]


def build_team(
    descriptions: Sequence[QuadrupedDescription], ground: PhysicsGround, settings: PhysicsSettings
) -> TeamModel:
    """Compile the world of a team."""
    mujoco = load_mujoco()
    size = len(descriptions)
    friction, scales = settings.sample(size)
    spec = mujoco.MjSpec()
    _set_options(spec, settings)
    add_ground(spec, ground)
    robots = []
    for number, bits in enumerate(robot_bits(size)):
        robot = robot_spec(descriptions[number], bits, float(friction[number]), settings.looks)
        _copy_options(spec, robot.spec)
        spec.attach(robot.spec, prefix=PREFIX.format(number), frame=spec.worldbody.add_frame())
        robots.append(robot)
    team = _indexed(spec.compile(), robots, len(ground.movable))
    _scale_masses(team, scales)
    return team


def _set_options(spec: Any, settings: PhysicsSettings) -> None:
    """Options count on the parent alone: those of attached specs are dropped."""
    mujoco = load_mujoco()
    option = spec.option
    option.timestep = settings.step
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 100.0
    # Separate solutions of robots that do not touch: the same result, measured 10 to 15 % slower.
    option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ISLAND)


def _copy_options(parent: Any, child: Any) -> None:
    """MuJoCo warns of every option of an attached specification that it drops."""
    for name in dir(parent.option):
        if not name.startswith("_"):
            setattr(child.option, name, getattr(parent.option, name))


def _indexed(model: Any, robots: Sequence[RobotSpec], movable: int) -> TeamModel:
    size = len(robots)
    trunks = np.zeros(size, dtype=np.int64)
    qpos, qvel = np.zeros((size, 19), dtype=np.int64), np.zeros((size, 18), dtype=np.int64)
    motors, touch = np.zeros((size, 12), dtype=np.int64), np.zeros((size, 4), dtype=np.int64)
    # Robot, part and leg.
    kinds = np.tile((-1, OBSTACLE, -1), (model.ngeom, 1))
    for robot, names in enumerate(robots):
        prefix = PREFIX.format(robot)
        joints = [model.joint(prefix + name) for name in names.joints]
        root = model.joint(prefix + names.root)
        trunks[robot] = root.bodyid[0]
        start, rate = int(root.qposadr[0]), int(root.dofadr[0])
        qpos[robot] = [*range(start, start + 7), *(int(joint.qposadr[0]) for joint in joints)]
        qvel[robot] = [*range(rate, rate + 6), *(int(joint.dofadr[0]) for joint in joints)]
        motors[robot] = [model.actuator(f"{prefix}motor_{k}").id for k in range(12)]
        touch[robot] = [model.sensor(prefix + name).adr[0] for name in TOUCH_SENSORS]
        links = {int(trunks[robot]): (robot, 0, -1)}
        for number, joint in enumerate(joints):
            links[int(joint.bodyid[0])] = (robot, 1 + number % 3, number // 3)
        for geom in range(model.ngeom):
            # Shapes of bodies that are welded to a link are that link's.
            link = links.get(int(model.body_weldid[model.geom_bodyid[geom]]))
            if link is not None:
                kinds[geom] = link
        for leg, name in enumerate(names.feet):
            kinds[model.geom(prefix + name).id] = robot, PARTS.index("foot"), leg
    kinds[model.geom("ground").id, 1] = GROUND
    bodies = [model.body(f"obstacle_{number}") for number in range(movable)]
    obstacles = np.array([int(body.mocapid[0]) for body in bodies], dtype=np.int64)
    return TeamModel(model, trunks, qpos, qvel, motors, touch, obstacles, *kinds.T.copy())


def _scale_masses(team: TeamModel, scales: Array) -> None:
    """Scale masses and inertias of each robot's bodies, and what the model derives from them."""
    if np.all(scales == 1.0):
        return
    mujoco = load_mujoco()
    model = team.model
    for trunk, scale in zip(team.trunks, scales, strict=True):
        bodies = model.body_rootid == model.body_rootid[trunk]
        model.body_mass[bodies] *= scale
        model.body_inertia[bodies] *= scale
    mujoco.mj_setConst(model, mujoco.MjData(model))
