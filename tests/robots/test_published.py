"""Our figures against the published descriptions."""

from __future__ import annotations

import copy
import importlib.metadata
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from cavalcade.robots import LEGS, robot_model

TRUNKS = {"go1": "trunk", "go2": "base"}
TOKENS = 1e-4  # kg: Go1's sensors stand in its description with 0.01 g each


def described(name):
    try:
        files = importlib.metadata.files("example-robot-data") or ()
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    (path,) = (file.locate() for file in files if file.name == f"{name}.urdf")
    return ET.parse(path).getroot()


@pytest.fixture(scope="module", params=sorted(TRUNKS))
def robot(request):
    return robot_model(request.param).description


@pytest.fixture(scope="module")
def published(robot):
    return described(robot.name)


def vector(element, name="xyz"):
    return np.zeros(3) if element is None else np.array(element.get(name).split(), dtype=float)


def movable(published):
    """Joints that turn, by name."""
    return {j.get("name"): j for j in published.iter("joint") if j.get("type") == "revolute"}


def lumped(published, root):
    """Mass, centre and inertia of a link with all that is fixed to it, in its frame.

    Fixed joints that matter are not turned; what is turned are Go1's sensors, 0.01 g each.
    """
    fixed = {}
    for joint in published.iter("joint"):
        if joint.get("type") == "fixed":
            fixed.setdefault(joint.find("parent").get("link"), []).append(joint)
    bodies = {link.get("name"): link.find("inertial") for link in published.iter("link")}
    pieces, waiting = [], [(root, np.zeros(3))]
    while waiting:
        name, place = waiting.pop()
        inertial = bodies[name]
        if inertial is not None and float(inertial.find("mass").get("value")) > 0.0:
            i = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
            matrix = [
                [i["ixx"], i["ixy"], i["ixz"]],
                [i["ixy"], i["iyy"], i["iyz"]],
                [i["ixz"], i["iyz"], i["izz"]],
            ]
            mass = float(inertial.find("mass").get("value"))
            pieces.append((mass, place + vector(inertial.find("origin")), np.array(matrix)))
        for joint in fixed.get(name, []):
            waiting.append((joint.find("child").get("link"), place + vector(joint.find("origin"))))
    mass = sum(piece[0] for piece in pieces)
    center = sum(piece[0] * piece[1] for piece in pieces) / mass
    inertia = np.zeros((3, 3))
    for piece, place, matrix in pieces:
        arm = place - center
        inertia += matrix + piece * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, center, inertia


def test_total_mass(robot, published):
    masses = [float(mass.get("value")) for mass in published.iter("mass")]
    assert robot.mass == pytest.approx(sum(masses), abs=TOKENS)


def test_every_link(robot, published):
    ours = {TRUNKS[robot.name]: robot.trunk}
    for leg, description in zip(LEGS, robot.legs, strict=True):
        for part, link in zip(("hip", "thigh", "calf"), description.links, strict=True):
            ours[f"{leg}_{part}"] = link
    for name, body in ours.items():
        mass, center, inertia = lumped(published, name)
        assert body.mass == pytest.approx(mass, abs=TOKENS), name
        np.testing.assert_allclose(body.center, center, atol=1e-5, err_msg=name)
        np.testing.assert_allclose(body.matrix, inertia, rtol=1e-3, atol=2e-5, err_msg=name)
        if name != TRUNKS[robot.name]:
            np.testing.assert_allclose(body.center, center, atol=1e-12, err_msg=name)
            np.testing.assert_allclose(body.matrix, inertia, rtol=1e-9, atol=1e-12, err_msg=name)


def test_joints_places_axes_and_limits(robot, published):
    joints = movable(published)
    assert len(joints) == 12
    for leg, description in zip(LEGS, robot.legs, strict=True):
        for part, ours in zip(("hip", "thigh", "calf"), description.joints, strict=True):
            theirs = joints[f"{leg}_{part}_joint"]
            np.testing.assert_array_equal(ours.offset, vector(theirs.find("origin")))
            np.testing.assert_array_equal(vector(theirs.find("origin"), "rpy"), 0.0)
            np.testing.assert_array_equal(ours.axis, vector(theirs.find("axis")))
            limit = {key: float(value) for key, value in theirs.find("limit").attrib.items()}
            assert (ours.lower, ours.upper) == (limit["lower"], limit["upper"])
            assert (ours.torque, ours.speed) == (limit["effort"], limit["velocity"])
            dynamics = theirs.find("dynamics")
            if dynamics is not None:
                assert ours.damping == float(dynamics.get("damping"))
                assert ours.friction == float(dynamics.get("friction"))


def test_feet(robot, published):
    places = {
        joint.find("child").get("link"): vector(joint.find("origin"))
        for joint in published.findall("joint")
    }
    for leg, description in zip(LEGS, robot.legs, strict=True):
        np.testing.assert_array_equal(description.foot, places[f"{leg}_foot"])
    spheres = [
        float(sphere.get("radius"))
        for link in published.iter("link")
        if link.get("name") == "FL_foot"
        for sphere in link.findall("collision/geometry/sphere")
    ]
    assert spheres in ([], [robot.foot_radius])


def test_rotors_as_the_joints_feel_them(robot, published):
    for leg in LEGS:
        for part, joint in zip(("hip", "thigh", "calf"), robot.legs[0].joints, strict=True):
            (link,) = (x for x in published.iter("link") if x.get("name") == f"{leg}_{part}_rotor")
            inertia = link.find("inertial/inertia")
            axial = float(inertia.get("ixx" if part == "hip" else "iyy"))
            gear = np.sqrt(joint.armature / axial)
            assert gear == pytest.approx(6.33 * joint.torque / 23.7)


def test_mujoco_reads_the_same_robot_from_both(robot, published):
    mujoco = pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco.robot_spec import robot_spec

    published = copy.deepcopy(published)
    for link in published.findall("link"):
        for part in list(link):
            mass = part.find("mass")
            # MuJoCo refuses the tokens' inertias, which no body can have.
            if mass is None or float(mass.get("value")) < TOKENS:
                link.remove(part)
    theirs = mujoco.MjSpec.from_string(ET.tostring(published, encoding="unicode")).compile()
    ours = robot_spec(robot, (1, 1), 0.8).spec.compile()
    for leg in LEGS:
        for part in ("hip", "thigh", "calf"):
            one, other = ours.body(f"{leg}_{part}"), theirs.body(f"{leg}_{part}")
            assert one.mass[0] == pytest.approx(other.mass[0], rel=1e-9)
            np.testing.assert_allclose(one.ipos, other.ipos, atol=1e-9)
            np.testing.assert_allclose(one.inertia, other.inertia, rtol=1e-6)
            np.testing.assert_allclose(one.pos, other.pos, atol=1e-12)
            mine, its = ours.joint(f"{leg}_{part}"), theirs.joint(f"{leg}_{part}_joint")
            np.testing.assert_allclose(mine.range, its.range)
            np.testing.assert_allclose(mine.axis, its.axis)
    assert ours.body_mass.sum() == pytest.approx(robot.mass)
