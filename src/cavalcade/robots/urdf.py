"""A robot as URDF, the form in which ROS, RViz, Foxglove and physics engines know robots."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from xml.etree import ElementTree

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.robots.description import (
    JOINT_NAMES,
    LEGS,
    LINK_NAMES,
    BodyShape,
    Inertial,
    JointDescription,
    QuadrupedDescription,
)
from cavalcade.robots.model import RobotModel
from cavalcade.robots.plain_body import body_of
from cavalcade.values import described, instance_of

_BASE_COLOR = (0.6, 0.6, 0.65)


def urdf_of(model: RobotModel, name: str = "", root: str = "body") -> str:
    """The robot's URDF, without files beside it.

    Legged robots have the links `body` (the trunk), per leg `FL_hip`, `FL_thigh`, `FL_calf` and
    `FL_foot` (the centre of the foot's ball), and the joints `FL_hip_joint`, `FL_thigh_joint`,
    `FL_calf_joint` and `FL_foot_joint` (fixed); legs are FL, FR, RL, RR. At angles of zero all
    frames are parallel. Other robots are one link `base`, on the ground below the middle.

    Args:
        model: Any, also a registered one. Legged robots without a mechanism get a plain one made
            of `model.legs`.
        name: Put before the links' names, with a slash, as transforms of several robots need it:
            `robot_0` gives `robot_0/body`. Joints keep their names; topics of joint states are
            each robot's own.
        root: What a legged robot's trunk is called.

    Raises:
        InputError: An argument is of another kind.
    """
    instance_of(model, RobotModel, "model")
    prefix = f"{_frame_name(name, 'name')}/" if name != "" else ""
    trunk = _frame_name(root, "root")
    robot = ElementTree.Element("robot", name=model.name)
    body = body_of(model)
    if body is None:
        _add_base(robot, f"{prefix}base", model)
    else:
        names = [prefix + one for one in (trunk, *LINK_NAMES[1:])]
        _add_links(robot, names, body)
        _add_joints(robot, names, prefix, body)
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def _frame_name(value: object, key: str) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[\w.-]+(/[\w.-]+)*", value):
        raise InputError(
            f"expected a frame's name such as robot_0, got {described(value)}", key=key
        )
    return value


def _add_base(robot: ElementTree.Element, name: str, model: RobotModel) -> None:
    link = ElementTree.SubElement(robot, "link", name=name)
    for role in ("visual", "collision"):
        part = ElementTree.SubElement(link, role)
        _add_origin(part, (0.0, 0.0, model.height / 2.0))
        geometry = ElementTree.SubElement(part, "geometry")
        if model.round:
            size = {"radius": _said(model.length / 2.0), "length": _said(model.height)}
            ElementTree.SubElement(geometry, "cylinder", size)
        else:
            size = {"size": _said(model.length, model.width, model.height)}
            ElementTree.SubElement(geometry, "box", size)
        if role == "visual":
            _add_material(part, _BASE_COLOR)


def _add_links(
    robot: ElementTree.Element, names: Sequence[str], body: QuadrupedDescription
) -> None:
    masses = [body.trunk, *(link for leg in body.legs for link in leg.links)]
    for number, (name, inertial) in enumerate(zip(names, masses, strict=True)):
        link = ElementTree.SubElement(robot, "link", name=name)
        _add_inertial(link, inertial)
        for role, shapes in (("visual", body.looks or body.solids), ("collision", body.solids)):
            for shape in shapes:
                if shape.link == number:
                    _add_shape(link, role, shape)


def _add_joints(
    robot: ElementTree.Element, names: Sequence[str], prefix: str, body: QuadrupedDescription
) -> None:
    for number, (name, joint) in enumerate(zip(JOINT_NAMES, body.joints, strict=True)):
        parent = number if number % 3 else 0
        element = ElementTree.SubElement(robot, "joint", name=name, type="revolute")
        _connect(element, names[parent], names[number + 1], joint.offset)
        _add_limits(element, joint)
    for number, leg in enumerate(LEGS):
        foot = f"{prefix}{leg}_foot"
        ElementTree.SubElement(robot, "link", name=foot)
        element = ElementTree.SubElement(robot, "joint", name=f"{leg}_foot_joint", type="fixed")
        _connect(element, names[3 * number + 3], foot, body.legs[number].foot)


def _connect(joint: ElementTree.Element, parent: str, child: str, offset: Sequence[float]) -> None:
    _add_origin(joint, offset)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)


def _add_limits(element: ElementTree.Element, joint: JointDescription) -> None:
    ElementTree.SubElement(element, "axis", xyz=_said(*joint.axis))
    limit = {"lower": joint.lower, "upper": joint.upper}
    limit |= {"effort": joint.torque, "velocity": joint.speed}
    ElementTree.SubElement(element, "limit", {key: _said(value) for key, value in limit.items()})
    friction = {"damping": joint.damping, "friction": joint.friction}
    ElementTree.SubElement(
        element, "dynamics", {key: _said(value) for key, value in friction.items()}
    )


def _add_inertial(link: ElementTree.Element, inertial: Inertial) -> None:
    element = ElementTree.SubElement(link, "inertial")
    _add_origin(element, inertial.center)
    ElementTree.SubElement(element, "mass", value=_said(inertial.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = (_said(value) for value in inertial.inertia)
    ElementTree.SubElement(element, "inertia", dict(zip(names, values, strict=True)))


def _add_shape(link: ElementTree.Element, role: str, shape: BodyShape) -> None:
    """One shape of a link; capsules, which URDF lacks, are a cylinder and two balls."""
    turn = shape.turn
    first, second, third = shape.size
    middle, length = (0.0, 0.0, 0.0), _said(2.0 * second)
    match shape.kind:
        case "box":
            parts = [(middle, "box", {"size": _said(2 * first, 2 * second, 2 * third)})]
        case "sphere":
            parts = [(middle, "sphere", {"radius": _said(first)})]
        case "cylinder" | "capsule":
            parts = [(middle, "cylinder", {"radius": _said(first), "length": length})]
    if shape.kind == "capsule":
        ends = ((0.0, 0.0, second), (0.0, 0.0, -second))
        parts += [(end, "sphere", {"radius": _said(first)}) for end in ends]
    for place, kind, size in parts:
        part = ElementTree.SubElement(link, role)
        center = [at + float(way @ place) for at, way in zip(shape.position, turn, strict=True)]
        _add_origin(part, center, _roll_pitch_yaw(turn))
        ElementTree.SubElement(ElementTree.SubElement(part, "geometry"), kind, size)
        if role == "visual":
            _add_material(part, shape.color)


def _add_material(visual: ElementTree.Element, color: Sequence[float]) -> None:
    digits = "".join(f"{round(255 * min(max(part, 0.0), 1.0)):02x}" for part in color)
    material = ElementTree.SubElement(visual, "material", name=f"color_{digits}")
    ElementTree.SubElement(material, "color", rgba=_said(*color, 1.0))


def _add_origin(
    element: ElementTree.Element, place: Sequence[float], turn: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    ElementTree.SubElement(element, "origin", xyz=_said(*place), rpy=_said(*turn))


def _roll_pitch_yaw(turn: Array) -> tuple[float, float, float]:
    """Angles about the fixed axes x, y, z in this order, of a rotation `(3, 3)`."""
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    if math.hypot(turn[0, 0], turn[1, 0]) < 1e-9:  # x points up or down: one angle is free
        return math.atan2(-turn[1, 2], turn[1, 1]), pitch, 0.0
    roll = math.atan2(turn[2, 1], turn[2, 2])
    return roll, pitch, math.atan2(turn[1, 0], turn[0, 0])


def _said(*values: float) -> str:
    return " ".join(f"{value + 0.0:.12g}" for value in values)
