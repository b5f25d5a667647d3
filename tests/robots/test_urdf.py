"""Robots as URDF: read back by a small reader of our own, and loaded by MuJoCo."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.robots import (
    JOINT_NAMES,
    LEGS,
    LINK_NAMES,
    MODELS,
    RobotModel,
    body_of,
    robot_model,
    urdf_of,
)

LEGGED = sorted(name for name, model in MODELS.items() if body_of(model) is not None)
ROLLING = sorted(set(MODELS) - set(LEGGED))


@dataclass
class Joint:
    parent: str
    child: str
    place: np.ndarray
    turn: np.ndarray
    axis: np.ndarray | None


def about(axis, angle):
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def numbers(text):
    return np.array([float(part) for part in text.split()])


def origin(element):
    said = element.find("origin")
    roll, pitch, yaw = numbers(said.get("rpy"))
    turn = about((0, 0, 1), yaw) @ about((0, 1, 0), pitch) @ about((1, 0, 0), roll)
    return numbers(said.get("xyz")), turn


def joints_of(text):
    found = {}
    for element in ElementTree.fromstring(text).findall("joint"):
        axis = element.find("axis")
        found[element.get("name")] = Joint(
            element.find("parent").get("link"),
            element.find("child").get("link"),
            *origin(element),
            None if axis is None else numbers(axis.get("xyz")),
        )
    return found


def place_of(link, joints, angles):
    """Of a link in the root, by the URDF alone."""
    place, turn = np.zeros(3), np.eye(3)
    by_child = {joint.child: (name, joint) for name, joint in joints.items()}
    while link in by_child:
        name, joint = by_child[link]
        own = joint.turn if joint.axis is None else joint.turn @ about(joint.axis, angles[name])
        place, turn, link = joint.place + own @ place, own @ turn, joint.parent
    return place, turn


def a_registered_model():
    """Legs of other sizes than any shipped robot has."""
    spirit = robot_model("spirit")
    legs = replace(spirit.legs, hip_x=0.3, hip_y=0.11, h_nom=0.4, h_max=0.5, mass=25.0)
    return replace(spirit, name="own-robot", length=0.8, width=0.5, legs=legs)


@pytest.mark.parametrize("name", LEGGED)
def test_feet_are_where_leg_control_has_them(name):
    body = body_of(MODELS[name])
    joints = joints_of(urdf_of(MODELS[name]))
    for angles in np.random.default_rng(1).uniform(-2.5, 2.5, (20, 12)):
        named = dict(zip(JOINT_NAMES, angles, strict=True))
        for leg, wanted in zip(LEGS, body.foot_places(angles), strict=True):
            place, _ = place_of(f"{leg}_foot", joints, named)
            np.testing.assert_allclose(place, wanted, atol=1e-9)


def test_links_of_transforms_are_those_of_the_urdf():
    body = body_of(robot_model("go2"))
    joints = joints_of(urdf_of(robot_model("go2")))
    angles = np.random.default_rng(2).uniform(-2.0, 2.0, 12)
    named = dict(zip(JOINT_NAMES, angles, strict=True))
    for number, pose in enumerate(body.link_poses(angles)):
        joint = joints[JOINT_NAMES[number]]
        x, y, z, w = pose[3:]
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        np.testing.assert_allclose(pose[:3], joint.place, atol=1e-12)
        turn = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
        np.testing.assert_allclose(turn, about(joint.axis, named[JOINT_NAMES[number]]), atol=1e-12)


@pytest.mark.parametrize("name", LEGGED)
def test_every_link_hangs_on_one_root(name):
    root = ElementTree.fromstring(urdf_of(MODELS[name], "robot_3"))
    links = [link.get("name") for link in root.findall("link")]
    joints = joints_of(urdf_of(MODELS[name], "robot_3"))
    assert len(set(links)) == len(links) == 17
    assert set(links) >= {f"robot_3/{link}" for link in LINK_NAMES}
    assert set(links) - {joint.child for joint in joints.values()} == {"robot_3/body"}
    assert all(joint.parent in links and joint.child in links for joint in joints.values())
    assert [joint for joint in joints if not joint.endswith("_foot_joint")] == list(JOINT_NAMES)
    assert JOINT_NAMES[:3] == ("FL_hip_joint", "FL_thigh_joint", "FL_calf_joint")


@pytest.mark.parametrize("model", [*(MODELS[name] for name in LEGGED), a_registered_model()])
def test_masses_and_limits_are_those_of_real_bodies(model):
    body = body_of(model)
    root = ElementTree.fromstring(urdf_of(model))
    assert root.get("name") == model.name
    masses = [float(mass.get("value")) for mass in root.iter("mass")]
    assert sum(masses) == pytest.approx(body.mass)
    assert min(masses) > 0.0
    for inertia in root.iter("inertia"):
        xx, yy, zz, xy, xz, yz = (float(inertia.get(key)) for key in (
            "ixx", "iyy", "izz", "ixy", "ixz", "iyz"))  # fmt: skip
        low, middle, high = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert low > 0.0
        assert high <= (low + middle) * (1.0 + 1e-9)
    for element in root.findall("joint[@type='revolute']"):
        limit = element.find("limit")
        assert float(limit.get("lower")) < float(limit.get("upper"))
        assert float(limit.get("effort")) > 0.0
        assert float(limit.get("velocity")) > 0.0


@pytest.mark.parametrize("model", [robot_model("spirit"), a_registered_model()])
def test_plain_bodies_stand_as_planners_have_them(model):
    body = body_of(model)
    assert body.mass == pytest.approx(model.legs.mass)
    feet = body.foot_places(body.standing)
    np.testing.assert_allclose(feet[:, 2], body.foot_radius - model.legs.h_nom, atol=1e-9)
    np.testing.assert_allclose(abs(feet[:, 0]), model.legs.hip_x, atol=1e-9)
    low, high = body.joint_range.T
    assert (body.standing >= low).all()
    assert (body.standing <= high).all()


@pytest.mark.parametrize("name", LEGGED)
def test_mujoco_loads_it(name):
    """Another reader of URDF: the same masses, joints and feet."""
    mujoco = pytest.importorskip("mujoco")
    body = body_of(MODELS[name])
    text = urdf_of(MODELS[name], "robot_0")
    # MuJoCo would weld feet to their calves and take the trunk for the world.
    keep = '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", keep))
    assert [model.joint(k).name for k in range(model.njnt)] == list(JOINT_NAMES)
    assert model.body_mass.sum() == pytest.approx(body.mass, rel=1e-6)
    np.testing.assert_allclose(model.jnt_range, body.joint_range, atol=1e-9)
    data = mujoco.MjData(model)
    for angles in np.random.default_rng(3).uniform(-1.0, 1.0, (5, 12)):
        data.qpos[:] = angles
        mujoco.mj_kinematics(model, data)
        for leg, wanted in zip(LEGS, body.foot_places(angles), strict=True):
            np.testing.assert_allclose(data.body(f"robot_0/{leg}_foot").xpos, wanted, atol=1e-9)


@pytest.mark.parametrize("name", LEGGED)
def test_shapes_are_where_the_body_has_them(name):
    """Boxes and cylinders turned as said, whatever their turn."""
    root = ElementTree.fromstring(urdf_of(MODELS[name]))
    body = body_of(MODELS[name])
    for number, link in enumerate(LINK_NAMES):
        shapes = [shape for shape in body.looks if shape.link == number]
        shown = root.find(f"link[@name='{link}']").findall("visual")
        centers = [origin(one) for one in shown if one.find("geometry/sphere") is None]
        wanted = [shape for shape in shapes if shape.kind != "sphere"]
        assert len(centers) == len(wanted)
        for (place, turn), shape in zip(centers, wanted, strict=True):
            np.testing.assert_allclose(place, shape.position, atol=1e-9)
            np.testing.assert_allclose(turn, shape.turn, atol=1e-9)


@pytest.mark.parametrize("name", ROLLING)
def test_robots_without_legs_are_their_footprint(name):
    model = MODELS[name]
    root = ElementTree.fromstring(urdf_of(model, "robot_1"))
    assert [link.get("name") for link in root.findall("link")] == ["robot_1/base"]
    assert root.findall("joint") == []
    shape = root.find("link/visual/geometry")
    if model.round:
        assert float(shape.find("cylinder").get("radius")) == pytest.approx(model.length / 2.0)
    else:
        size = numbers(shape.find("box").get("size"))
        assert size == pytest.approx((model.length, model.width, model.height))


def test_the_root_can_be_called_otherwise():
    joints = joints_of(urdf_of(robot_model("go1"), "a/b", root="base_link"))
    assert joints["RR_hip_joint"].parent == "a/b/base_link"


@pytest.mark.parametrize("bad", [" ", "a b", "/a", "a/", "a<b", 3, None])
def test_names_that_no_frame_has_are_refused(bad):
    with pytest.raises(InputError, match="name: expected a frame's name"):
        urdf_of(robot_model("go1"), bad)
    with pytest.raises(InputError, match="root: expected a frame's name"):
        urdf_of(robot_model("go1"), root=bad)


def test_other_things_are_no_models():
    with pytest.raises(InputError, match="model"):
        urdf_of("go1")  # type: ignore[arg-type]
    assert isinstance(robot_model("go1"), RobotModel)
