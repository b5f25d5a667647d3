"""A quadruped as a MuJoCo specification."""

from __future__ import annotations

from typing import Any

from cavalcade.fleet.physics.engine import load_mujoco
from cavalcade.robots.description import JOINTS, LEGS, BodyShape, QuadrupedDescription
from cavalcade.robots.inertial import Inertial

FOOT_SOLREF = (0.01, 1.0)
FOOT_SOLIMP = (0.9, 0.95, 0.001, 0.5, 2.0)
"""Stiffness of contacts with feet; softer ones let them sink and slide."""

FOOT_PRIORITY = 2
"""A foot's friction and stiffness hold against whatever it touches."""

BODY_PRIORITY = 1
"""Likewise the rest of a robot against ground and obstacles."""


def robot_spec(
    description: QuadrupedDescription,
    bits: tuple[int, int],
    friction: float,
    mass_scale: float,
    looks: bool = False,
) -> Any:
    """A fresh `MjSpec` of one robot.

    Bodies, joints and motors are named as in `LEGS` and `JOINTS`, as `FL_hip`; geoms of feet and
    the touch sensors on them as `FL_foot`.

    Args:
        description: Of the robot.
        bits: `contype` and `conaffinity` of its shapes.
        friction: Coulomb coefficient of its shapes.
        mass_scale: Factor on masses and inertias.
        looks: Whether to add the shapes for drawing.
    """
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    trunk = spec.worldbody.add_body(name="trunk")
    trunk.add_freejoint(name="root")
    _set_inertial(trunk, description.trunk, mass_scale)
    links = [trunk]
    for leg, name in enumerate(LEGS):
        parent = trunk
        parts = description.legs[leg]
        for part, joint, inertial in zip(JOINTS, parts.joints, parts.links, strict=True):
            body = parent.add_body(name=f"{name}_{part}", pos=joint.offset)
            _set_inertial(body, inertial, mass_scale)
            body.add_joint(
                name=f"{name}_{part}",
                type=mujoco.mjtJoint.mjJNT_HINGE,
                axis=joint.axis,
                range=(joint.lower, joint.upper),
                limited=mujoco.mjtLimited.mjLIMITED_TRUE,
                damping=joint.damping,
                frictionloss=joint.friction,
                armature=joint.armature,
            )
            links.append(body)
            parent = body
    for shape in description.solids:
        _add_solid(links[shape.link], shape, bits, friction)
    if looks:
        for shape in description.looks:
            _add_look(links[shape.link], shape)
    add_motors(spec, description, [f"{leg}_{joint}" for leg in LEGS for joint in JOINTS])
    for leg, name in enumerate(LEGS):
        calf = links[3 + 3 * leg]
        add_touch_sensor(
            spec, calf, f"{name}_foot", description.legs[leg].foot, description.foot_radius
        )
    return spec


def add_motors(spec: Any, description: QuadrupedDescription, joints: list[str]) -> None:
    """One torque motor per joint, in the order of `joints`, named `motor_` and its number."""
    mujoco = load_mujoco()
    for number, (name, joint) in enumerate(zip(joints, description.joints, strict=True)):
        motor = spec.add_actuator(
            name=f"motor_{number}",
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcerange=(-joint.torque, joint.torque),
            forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        )
        motor.set_to_motor()


def add_touch_sensor(spec: Any, body: Any, name: str, place: Any, radius: float) -> None:
    """A sensor of normal forces on the ball of a foot; its site is a little larger than that."""
    mujoco = load_mujoco()
    body.add_site(name=f"{name}_touch", pos=place, size=(1.3 * radius, 0.0, 0.0))
    spec.add_sensor(
        name=f"{name}_touch",
        type=mujoco.mjtSensor.mjSENS_TOUCH,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=f"{name}_touch",
    )


def _set_inertial(body: Any, inertial: Inertial, scale: float) -> None:
    body.explicitinertial = True
    body.mass = scale * inertial.mass
    body.ipos = inertial.center
    body.fullinertia = [scale * value for value in inertial.inertia]


def _add_solid(body: Any, shape: BodyShape, bits: tuple[int, int], friction: float) -> None:
    geom = _add_shape(body, shape)
    geom.contype, geom.conaffinity = bits
    geom.friction = (friction, 0.005, 0.0001)
    geom.condim = 3
    geom.priority = BODY_PRIORITY
    if shape.part == "foot":
        geom.name = f"{LEGS[shape.leg]}_foot"
        geom.priority = FOOT_PRIORITY
        geom.solref, geom.solimp = FOOT_SOLREF, FOOT_SOLIMP


def _add_look(body: Any, shape: BodyShape) -> None:
    geom = _add_shape(body, shape)
    geom.contype = geom.conaffinity = 0
    geom.group = 2


def _add_shape(body: Any, shape: BodyShape) -> Any:
    kinds = load_mujoco().mjtGeom
    return body.add_geom(
        type=getattr(kinds, f"mjGEOM_{shape.kind.upper()}"),
        size=shape.size,
        pos=shape.position,
        quat=shape.rotation,
        rgba=(*shape.color, 1.0),
        mass=0.0,
        group=3,
    )
