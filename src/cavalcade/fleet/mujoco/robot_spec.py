"""A quadruped as a MuJoCo specification."""

from __future__ import annotations

import itertools
import math
from typing import Any

from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.own_model import RobotSpec, read_own_model
from cavalcade.robots.description import JOINTS, LEGS, BodyShape, Inertial, QuadrupedDescription

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

TOUCH_SENSORS = tuple(f"cavalcade_touch_{leg}" for leg in LEGS)
"""Of names that no model of one's own is likely to have."""

BITS = 30
"""Bits that say which shapes may touch, for robots: the first is the world's, the 32nd the sign."""


def robot_bits(robots: int) -> list[tuple[int, int]]:
    """`contype` and `conaffinity` of each of so many robots: they touch all but themselves.

    MuJoCo lets two shapes touch if the `contype` bits of one meet the `conaffinity` bits of the
    other. Robots get sets of equally many bits, no two the same, and ask for all bits but their
    own: two different sets of one size never lie in each other, so two robots always meet, and one
    never meets itself. Sets of one bit serve 30 robots, of two 435, and so on.
    """
    size = next(size for size in range(1, BITS) if math.comb(BITS, size) >= robots)
    everything = 2 ** (BITS + 1) - 1
    sets = itertools.islice(itertools.combinations(range(1, BITS + 1), size), robots)
    codes = [sum(1 << bit for bit in chosen) for chosen in sets]
    return [(code, everything & ~code) for code in codes]


def robot_spec(
    description: QuadrupedDescription,
    bits: tuple[int, int],
    friction: float,
    looks: bool = False,
) -> RobotSpec:
    """A fresh specification of one robot: from its description, or from its own file.

    Motors are called `motor_` and the joint's number; touch sensors on the feet `TOUCH_SENSORS`.
    Of its shapes `bits` are `contype` and `conaffinity`, `friction` is the Coulomb coefficient;
    with `looks` there are also those for drawing.
    """
    if description.file:
        robot: RobotSpec = read_own_model(description.file)
    else:
        robot = _from_description(description, looks)
    for geom in robot.spec.geoms:
        if geom.contype or geom.conaffinity:
            _finish(geom, bits, friction, geom.name in robot.feet)
    _add_motors(robot, description)
    _add_touch_sensors(robot, description.foot_radius)
    return robot


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
    return RobotSpec(spec, "root", joints, tuple(f"{leg}_foot" for leg in LEGS))


def _add_motors(robot: RobotSpec, description: QuadrupedDescription) -> None:
    """One torque motor per joint, in their order."""
    mujoco = load_mujoco()
    for number, (name, joint) in enumerate(zip(robot.joints, description.joints, strict=True)):
        motor = robot.spec.add_actuator(
            name=f"motor_{number}",
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcerange=(-joint.torque, joint.torque),
            forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        )
        motor.set_to_motor()


def _add_touch_sensors(robot: RobotSpec, radius: float) -> None:
    """Sensors of normal forces on the balls of the feet; sites are a little larger than those."""
    mujoco = load_mujoco()
    for name, foot in zip(TOUCH_SENSORS, map(robot.spec.geom, robot.feet), strict=True):
        foot.parent.add_site(name=name, pos=foot.pos, size=(1.3 * radius, 0.0, 0.0))
        robot.spec.add_sensor(
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
