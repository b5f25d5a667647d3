"""A user's own MuJoCo model of a quadruped: reading it and finding its legs.

What such a file must have: one body with a free joint, the trunk; below it four legs of three
hinge joints each, hip about x, thigh and calf about y when all angles are zero, with no more
turns between their frames; and a ball as each foot. Legs are told apart by where their hips are:
in front x > 0, left y > 0. A foot is the geom of a leg named `foot`, `FL_foot` or `FL`, or with
one of these names and more after an underscore, in capitals or not; where none is so named, the
lowest sphere of the calf. Actuators and sensors of the file are replaced, as is what else stands
in its world.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.locomotion.parameters import AXES
from cavalcade.robots.description import JOINTS, LEGS

_SAME = 1e-3


@dataclass(frozen=True)
class RobotSpec:
    """A robot as a fresh `MjSpec`, and names: the free joint, the 12 hinges, the feet's geoms."""

    spec: Any
    root: str
    joints: tuple[str, ...]
    feet: tuple[str, ...]


@dataclass(frozen=True)
class OwnModel(RobotSpec):
    """A model of the user, without actuators, sensors, keyframes and other things in its world.

    Attributes:
        model: Its `spec`, compiled.
        torques: Largest torques of the joints, N m.
    """

    model: Any
    torques: tuple[float, ...]


def read_own_model(file: str | Path) -> OwnModel:
    """Read a file and find trunk, legs and feet in it."""
    mujoco = load_mujoco()
    path = Path(file)
    if not path.is_file():
        raise InputError("there is no such MuJoCo model", file=path)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _name_everything(spec)
        for key in spec.keys:
            spec.delete(key)
        with_motors = spec.compile()
    except ValueError as error:
        raise InputError(f"not a MuJoCo model that can be used: {error}", file=path) from None
    root = _root(with_motors, path)
    joints = _legs(with_motors, root, path)
    feet = tuple(_foot(with_motors, joint, leg, path) for leg, joint in enumerate(joints[2::3]))
    torques = tuple(_torque(with_motors, joint, path) for joint in joints)
    for thing in (*spec.actuators, *spec.sensors):
        spec.delete(thing)
    world, trunk = spec.worldbody, spec.joint(root).parent.name
    others = (body for body in world.bodies if body.name != trunk)
    for thing in (*world.geoms, *world.sites, *world.lights, *others):
        spec.delete(thing)
    return OwnModel(spec, root, joints, feet, spec.compile(), torques)


def zero_state(model: Any) -> Any:
    """An `MjData` with all joint angles zero and the trunk upright at the origin."""
    mujoco = load_mujoco()
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    data.qpos[3] = 1.0
    mujoco.mj_kinematics(model, data)
    return data


def _name_everything(spec: Any) -> None:
    """Names for bodies, joints and geoms without one: nothing refers to these."""
    for kind, things in (("body", spec.bodies), ("joint", spec.joints), ("geom", spec.geoms)):
        for number, thing in enumerate(things):
            if not thing.name:
                thing.name = f"unnamed_{kind}_{number}"


def _root(model: Any, path: Path) -> str:
    kinds = load_mujoco().mjtJoint
    free = [k for k in range(model.njnt) if model.jnt_type[k] == kinds.mjJNT_FREE]
    if len(free) != 1:
        raise InputError(
            f"expected one body with a free joint, the trunk; found {len(free)}", file=path
        )
    hinges = int((model.jnt_type == kinds.mjJNT_HINGE).sum())
    if hinges != 12 or model.njnt != 13:
        raise InputError(
            f"expected 12 hinge joints besides the free one; found {hinges} and "
            f"{model.njnt - 1 - hinges} of other kinds",
            file=path,
        )
    return str(model.joint(free[0]).name)


def _legs(model: Any, root: str, path: Path) -> tuple[str, ...]:
    """Names of the hinges, ordered by leg; see that they stand and turn as they must."""
    trunk = int(model.joint(root).bodyid[0])
    below: dict[int, list[int]] = {}
    for joint in range(model.njnt):
        body = int(model.jnt_bodyid[joint])
        if body != trunk:
            below.setdefault(int(model.body_weldid[model.body_parentid[body]]), []).append(joint)
    data = zero_state(model)
    found: dict[int, list[int]] = {}
    for hip in below.get(trunk, []):
        chain = [hip]
        while len(following := below.get(int(model.jnt_bodyid[chain[-1]]), [])) == 1:
            chain += following
        x, y = data.xanchor[hip, :2]
        leg = (0 if x > 0.0 else 2) + (0 if y > 0.0 else 1)
        if len(chain) != 3 or leg in found:
            break
        found[leg] = chain
    if len(found) != 4:
        raise InputError(
            "expected four legs of three joints below the trunk, with their hips front left, "
            "front right, rear left and rear right of its origin",
            file=path,
        )
    ordered = [joint for leg in range(4) for joint in found[leg]]
    for number, joint in enumerate(ordered):
        _check_joint(model, data, joint, number, path)
    return tuple(str(model.joint(joint).name) for joint in ordered)


def _check_joint(model: Any, data: Any, joint: int, number: int, path: Path) -> None:
    name = str(model.joint(joint).name)
    part, axis = JOINTS[number % 3], AXES[number % 3]
    if np.abs(data.xaxis[joint] - axis).max() > _SAME:
        letter = "x" if number % 3 == 0 else "y"
        raise InputError(
            f"joint {name!r} is the {part} of leg {LEGS[number // 3]}; expected it to turn about "
            f"+{letter} when all angles are zero",
            file=path,
        )
    if abs(model.qpos0[model.jnt_qposadr[joint]]) > _SAME:
        raise InputError(f"joint {name!r} has a `ref`; expected none", file=path)
    if not model.jnt_limited[joint]:
        raise InputError(f"joint {name!r} has no `range`", file=path)


def _foot(model: Any, calf: str, leg: int, path: Path) -> str:
    """Name of the geom that is the foot below a calf's joint."""
    body = int(model.joint(calf).bodyid[0])
    sphere = load_mujoco().mjtGeom.mjGEOM_SPHERE
    geoms = [
        geom
        for geom in range(model.ngeom)
        if int(model.body_weldid[model.geom_bodyid[geom]]) == body
        and model.geom_type[geom] == sphere
        and (model.geom_contype[geom] or model.geom_conaffinity[geom])
    ]
    if not geoms:
        raise InputError(
            f"no foot on leg {LEGS[leg]}: expected a sphere that can touch on the link of joint "
            f"{calf!r}, best named '{LEGS[leg]}_foot'",
            file=path,
        )
    short = LEGS[leg].lower()
    for wanted in (f"{short}_foot", "foot", short):
        for geom in geoms:
            name = str(model.geom(geom).name)
            if name.lower() == wanted or name.lower().startswith(f"{wanted}_"):
                return name
    height = zero_state(model).geom_xpos[:, 2]
    return str(model.geom(min(geoms, key=lambda geom: height[geom])).name)


def _torque(model: Any, name: str, path: Path) -> float:
    """The largest torque of a joint: its actuator's force or control range, or its own."""
    joint = model.joint(name).id
    torque = float(model.jnt_actfrcrange[joint, 1]) if model.jnt_actfrclimited[joint] else None
    for actuator in range(model.nu):
        if torque is not None or model.actuator_trnid[actuator, 0] != joint:
            continue
        gear = abs(float(model.actuator_gear[actuator, 0]))
        is_motor = model.actuator_biastype[actuator] == 0
        if model.actuator_forcelimited[actuator]:
            torque = gear * float(model.actuator_forcerange[actuator, 1])
        elif is_motor and model.actuator_ctrllimited[actuator]:
            gain = float(model.actuator_gainprm[actuator, 0])
            torque = gear * gain * float(model.actuator_ctrlrange[actuator, 1])
    if torque is None:
        raise InputError(
            f"joint {name!r} has no torque limit: expected `actuatorfrcrange` of the joint, or an "
            "actuator of it with `forcerange`",
            file=path,
        )
    if not torque > 0.0:
        raise InputError(
            f"joint {name!r} has a largest torque of {torque:g} N m; expected a positive one",
            file=path,
        )
    return torque
