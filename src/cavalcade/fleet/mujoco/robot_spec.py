"""A quadruped as a MuJoCo specification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.own_model import read_own_model
from cavalcade.robots.description import JOINTS, LEGS, BodyShape, QuadrupedDescription
from cavalcade.robots.inertial import Inertial

FOOT_SOLREF = (0.01, 1.0)
FOOT_SOLIMP = (0.9, 0.95, 0.001, 0.5, 2.0)
"""Stiffness of contacts with feet; softer ones let them sink and slide."""

STOP_SOLREF = (0.004, 1.0)
"""Stiffness of joints' stops, as stiff as steps of 2 ms allow; the usual ones give way by 0.2 rad
when a robot is pushed."""

FOOT_PRIORITY = 2
"""A foot's friction and stiffness hold against whatever it touches."""

BODY_PRIORITY = 1
"""Likewise the rest of a robot against ground and obstacles."""

_SENSORS = tuple(f"cavalcade_touch_{leg}" for leg in LEGS)
"""Of names that no model of one's own is likely to have."""


@dataclass(frozen=True)
class RobotSpec:
    """One robot as a specification, and what its things are called.

    Motors are called `motor_` and the joint's number; touch sensors are `sensors`.

    Attributes:
        spec: A fresh `MjSpec`.
        root: The free joint.
        joints: The 12 hinges.
        feet: The geoms of the four feet.
        sensors: The touch sensors on them.
    """

    spec: Any
    root: str
    joints: tuple[str, ...]
    feet: tuple[str, ...]
    sensors: tuple[str, ...]


def robot_spec(
    description: QuadrupedDescription,
    bits: tuple[int, int],
    friction: float,
    looks: bool = False,
) -> RobotSpec:
    """A fresh specification of one robot: from its description, or from its own file.

    Args:
        description: Of the robot.
        bits: `contype` and `conaffinity` of its shapes.
        friction: Coulomb coefficient of its shapes.
        looks: Whether to add the shapes for drawing.

    Raises:
        InputError: MuJoCo is missing, or the robot's own file cannot be used.
    """
    robot = _from_file(description) if description.file else _from_description(description, looks)
    feet = set(robot.feet)
    for geom in robot.spec.geoms:
        if geom.contype or geom.conaffinity:
            _finish(geom, bits, friction, geom.name in feet)
    return robot


def _from_file(description: QuadrupedDescription) -> RobotSpec:
    """The robot of the user's model; feet and motors as those of ours."""
    own = read_own_model(description.file)
    _add_motors(own.spec, description, own.joints)
    for leg, name in enumerate(own.feet):
        foot = own.spec.geom(name)
        _add_touch_sensor(own.spec, foot.parent, LEGS[leg], foot.pos, description.foot_radius)
    return RobotSpec(own.spec, own.root, own.joints, own.feet, _SENSORS)


def _from_description(description: QuadrupedDescription, looks: bool) -> RobotSpec:
    """Bodies, joints and motors are named as in `LEGS` and `JOINTS`, as `FL_hip`."""
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    trunk = spec.worldbody.add_body(name="trunk")
    trunk.add_freejoint(name="root")
    _set_inertial(trunk, description.trunk)
    links = [trunk]
    for leg, name in enumerate(LEGS):
        parent = trunk
        parts = description.legs[leg]
        for part, joint, inertial in zip(JOINTS, parts.joints, parts.links, strict=True):
            body = parent.add_body(name=f"{name}_{part}", pos=joint.offset)
            _set_inertial(body, inertial)
            body.add_joint(
                name=f"{name}_{part}",
                type=mujoco.mjtJoint.mjJNT_HINGE,
                axis=joint.axis,
                range=(joint.lower, joint.upper),
                limited=mujoco.mjtLimited.mjLIMITED_TRUE,
                damping=joint.damping,
                frictionloss=joint.friction,
                armature=joint.armature,
                solref_limit=STOP_SOLREF,
            )
            links.append(body)
            parent = body
    for shape in description.solids:
        geom = _add_shape(links[shape.link], shape)
        if shape.part == "foot":
            geom.name = f"{LEGS[shape.leg]}_foot"
    if looks:
        for shape in description.looks:
            geom = _add_shape(links[shape.link], shape)
            geom.contype = geom.conaffinity = 0
            geom.group = 2
    joints = tuple(f"{leg}_{joint}" for leg in LEGS for joint in JOINTS)
    _add_motors(spec, description, joints)
    for leg, name in enumerate(LEGS):
        place = description.legs[leg].foot
        _add_touch_sensor(spec, links[3 + 3 * leg], name, place, description.foot_radius)
    return RobotSpec(spec, "root", joints, tuple(f"{leg}_foot" for leg in LEGS), _SENSORS)


def _add_motors(spec: Any, description: QuadrupedDescription, joints: tuple[str, ...]) -> None:
    """One torque motor per joint, in the order of `joints`."""
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


def _add_touch_sensor(spec: Any, body: Any, leg: str, place: Any, radius: float) -> None:
    """A sensor of normal forces on the ball of a foot; its site is a little larger than that."""
    mujoco = load_mujoco()
    name = _SENSORS[LEGS.index(leg)]
    body.add_site(name=name, pos=place, size=(1.3 * radius, 0.0, 0.0))
    spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_TOUCH,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=name,
    )


def _set_inertial(body: Any, inertial: Inertial) -> None:
    body.explicitinertial = True
    body.mass = inertial.mass
    body.ipos = inertial.center
    body.fullinertia = inertial.inertia


def _finish(geom: Any, bits: tuple[int, int], friction: float, foot: bool) -> None:
    """What holds for everything that touches."""
    geom.contype, geom.conaffinity = bits
    geom.friction = (friction, 0.005, 0.0001)
    geom.condim = 3
    geom.priority = BODY_PRIORITY
    if foot:
        geom.priority = FOOT_PRIORITY
        geom.solref, geom.solimp = FOOT_SOLREF, FOOT_SOLIMP


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
