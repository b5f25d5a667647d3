"""A user's own MuJoCo model as a robot."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.own_model import OwnModel, read_own_model, zero_state
from cavalcade.locomotion.parameters import AXES
from cavalcade.robots.description import (
    PARTS,
    BodyShape,
    Inertial,
    JointDescription,
    LegDescription,
    QuadrupedDescription,
    ShapeKind,
    Vector,
    combined,
)
from cavalcade.robots.model import RobotModel

_LARGEST = {
    "body_mass": 1e4,
    "body_inertia": 1e4,
    "body_pos": 100.0,
    "body_ipos": 100.0,
    "jnt_pos": 100.0,
    "jnt_range": 1e3,
    "jnt_actfrcrange": 1e5,
    "actuator_forcerange": 1e5,
    "actuator_ctrlrange": 1e5,
    "actuator_gear": 1e4,
    "geom_pos": 100.0,
    "geom_size": 100.0,
    "dof_damping": 1e4,
    "dof_frictionloss": 1e4,
    "dof_armature": 1e4,
}
"""Magnitudes of what is read of a model: kg, kg m², m, rad, N m, N m s/rad."""

_BENT = 0.61
"""Height of a standing hip over the foot's centre, of the leg's length; as Go1 stands."""


def own_robot(file: str | Path, like: RobotModel) -> RobotModel:
    """The robot of a MuJoCo model; see `cavalcade.fleet.mujoco.own_model` for what it must be.

    Masses, joints, torques and shapes are those of the file. It says nothing of the speed of
    motors, which is not limited therefore.

    Args:
        file: MJCF.
        like: Whose footprint, speeds and parameters for planning it gets.

    Raises:
        InputError: MuJoCo is missing, the file cannot be read, or it is no such quadruped.
    """
    own = read_own_model(file)
    _check_figures(own.model, file)
    model, data = own.model, zero_state(own.model)
    # Body of the trunk and of the 12 links to index: 0, and `1 + 3 * leg + j`.
    bodied = (own.root, *own.joints)
    links = {int(model.joint(name).bodyid[0]): number for number, name in enumerate(bodied)}
    places = [np.zeros(3), *(data.xanchor[model.joint(name).id] for name in own.joints)]
    bodies = _inertials(model, data, links, places)
    legs = []
    for leg, name in enumerate(own.feet):
        first = 1 + 3 * leg
        origins = (places[0], *places[first : first + 3])
        hip, thigh, calf = (
            _joint(own, 3 * leg + part, _vector(origins[part + 1] - origins[part]))
            for part in range(3)
        )
        foot = _vector(data.geom_xpos[model.geom(name).id] - places[first + 2])
        links_of_leg = bodies[first], bodies[first + 1], bodies[first + 2]
        legs.append(LegDescription((hip, thigh, calf), links_of_leg, foot))
    radius = float(model.geom(own.feet[0]).size[0])
    hip, thigh, calf = legs[0].joints
    length = math.hypot(*calf.offset[::2]) + math.hypot(*legs[0].foot[::2])
    looks, solids = _shapes(own, data, links, places)
    description = QuadrupedDescription(
        name=Path(file).stem,
        trunk=bodies[0],
        legs=(legs[0], legs[1], legs[2], legs[3]),
        foot_radius=radius,
        stand_height=_BENT * length + radius - hip.offset[2] - thigh.offset[2],
        looks=looks,
        solids=solids,
        source=str(file),
        file=str(file),
    )
    return replace(like, name=description.name, source=str(file), description=description)


def _check_figures(model: Any, file: str | Path) -> None:
    """Refuse figures that no robot has: with them, forces and motion would overflow.

    Raises:
        InputError: It names the file and the attribute of MuJoCo's model.
    """
    for name, most in _LARGEST.items():
        values = np.asarray(getattr(model, name), dtype=float)
        # Written so that nan is refused, too.
        if not (np.abs(values) <= most).all():
            raise InputError(f"expected figures within ±{most:g}", file=file, key=name)


def _joint(own: OwnModel, number: int, offset: Vector) -> JointDescription:
    joint = own.model.joint(own.joints[number])
    torque = own.torques[number]
    lower, upper = (float(value) for value in joint.range)
    dof = int(joint.dofadr[0])
    return JointDescription(
        offset,
        AXES[number % 3],
        lower,
        upper,
        torque,
        math.inf,
        damping=float(np.ravel(own.model.dof_damping[dof])[0]),
        friction=float(own.model.dof_frictionloss[dof]),
        armature=float(own.model.dof_armature[dof]),
        stall_torque=torque,
        no_load_speed=math.inf,
    )


def _inertials(model: Any, data: Any, links: dict[int, int], places: list[Any]) -> list[Inertial]:
    """Of the trunk and the links, each with all bodies that are fixed to it, in its frame."""
    pieces: list[list[Inertial]] = [[] for _ in links]
    for body in range(1, model.nbody):
        link = links[int(model.body_weldid[body])]
        mass = float(model.body_mass[body])
        if mass <= 0.0:
            continue
        xx, yy, zz = _vector(model.body_inertia[body])
        own = Inertial(mass, (0.0, 0.0, 0.0), (xx, yy, zz, 0.0, 0.0, 0.0))
        place = _vector(data.xipos[body] - places[link])
        pieces[link].append(own.turned(data.ximat[body].reshape(3, 3)).moved(place))
    return [combined(part) for part in pieces]


def _shapes(
    own: OwnModel, data: Any, links: dict[int, int], places: list[Any]
) -> tuple[tuple[BodyShape, ...], tuple[BodyShape, ...]]:
    """What the robot looks like and what of it touches; meshes as the boxes around them."""
    mujoco = load_mujoco()
    model = own.model
    named: dict[int, ShapeKind] = {
        int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
        int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
        int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    }
    looks, solids = [], []
    for geom in range(model.ngeom):
        link = links[int(model.body_weldid[model.geom_bodyid[geom]])]
        foot = str(model.geom(geom).name) in own.feet
        kind = named.get(int(model.geom_type[geom]), "box")
        place, size = data.geom_xpos[geom] - places[link], model.geom_size[geom]
        if kind == "box":
            turn = data.geom_xmat[geom].reshape(3, 3)
            place = place + turn @ model.geom_aabb[geom, :3]
            size = model.geom_aabb[geom, 3:]
        rotation = np.zeros(4)
        mujoco.mju_mat2Quat(rotation, data.geom_xmat[geom])
        w, x, y, z = (float(value) for value in rotation)
        shape = BodyShape(
            "foot" if foot else PARTS[0 if link == 0 else 1 + (link - 1) % 3],
            -1 if link == 0 else (link - 1) // 3,
            kind,
            _vector(size),
            _vector(place),
            (w, x, y, z),
            _vector(model.geom_rgba[geom, :3]),
        )
        touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
        if touches:
            solids.append(shape)
        # By MuJoCo's custom geoms of groups 3 to 5 are not drawn.
        if model.geom_group[geom] < 3:
            looks.append(shape)
    return tuple(looks or solids), tuple(solids)


def _vector(values: Any) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
