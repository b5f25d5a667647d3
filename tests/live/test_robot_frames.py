"""What a simulated robot says of itself fits together: description, joints, transforms."""

from __future__ import annotations

from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from cavalcade.fleet.ros2 import scenario_robots
from cavalcade.fleet.ros2.messages import fill_transforms
from cavalcade.live.robot_frames import RobotFrames
from cavalcade.live.simulation import Simulation
from cavalcade.robots import JOINT_NAMES, body_of, robot_model
from cavalcade.scenario import parse_scenario

MODELS = ("go1", "go2", "spirit", "single-integrator", "unicycle")


@pytest.mark.parametrize("name", MODELS)
def test_every_link_of_the_description_is_a_frame_once_and_no_other(name):
    model = robot_model(name)
    frames, body = RobotFrames(model, "robot_3"), body_of(model)
    joints = None if body is None else body.standing
    found = [("map", frames.base), *(one[:2] for one in (*frames.legs(joints), *frames.fixed))]
    parents = {child: parent for parent, child in found}
    assert len(parents) == len(found)
    urdf = ElementTree.fromstring(frames.urdf)
    links = {link.attrib["name"] for link in urdf.iter("link")}
    assert links <= set(parents)
    assert set(parents) - links <= {frames.base}
    assert frames.base == scenario_robots(4)[3].base_frame
    for joint in urdf.iter("joint"):
        parent, child = (joint.find(end).attrib["link"] for end in ("parent", "child"))
        assert parents[child] == parent
    moving = [j.attrib["name"] for j in urdf.iter("joint") if j.attrib["type"] == "revolute"]
    assert moving == ([] if body is None else list(JOINT_NAMES))


def test_the_transforms_lead_to_the_feet():
    body = robot_model("go1").description
    joints = body.standing + 0.1 * np.sin(np.arange(12))
    frames = RobotFrames(robot_model("go1"), "a")
    places = {child: (parent, place) for parent, child, place in frames.legs(joints)}
    places |= {child: (parent, place) for parent, child, place in frames.fixed}
    feet = body.foot_places(joints)
    for leg, foot in zip(("FL", "FR", "RL", "RR"), feet, strict=True):
        point, frame = np.zeros(3), f"a/{leg}_foot"
        while frame != frames.base:
            frame, place = places[frame]
            axis, w = place[3:6], place[6]
            turned = 2.0 * np.cross(axis, point)
            point = place[:3] + point + w * turned + np.cross(axis, turned)
        assert point == pytest.approx(foot, abs=1e-12)


@pytest.mark.parametrize("name", MODELS)
def test_simulated_robots_stand_on_the_ground_by_their_own_joints(name):
    simulation = Simulation(
        parse_scenario(
            {
                "version": 1,
                "name": "one",
                "world": {"empty": {"size": [6.0, 4.0]}},
                "robots": [{"model": name, "start": [1.0, 2.0, 0.5], "goal": [5.0, 2.0, 0.0]}],
                "task": {"goals": "individual"},
            }
        )
    )
    (trunk,), (legs,) = simulation.trunks(), simulation.joints()
    body = body_of(simulation.models[0])
    assert (legs is None) == (body is None)
    if body is not None:
        lowest = trunk[2] + body.foot_places(legs[0])[:, 2] - body.foot_radius
        assert lowest == pytest.approx(np.zeros(4), abs=0.01)


def test_transforms_are_filled_and_used_again():
    def make():
        return SimpleNamespace(
            header=SimpleNamespace(stamp=SimpleNamespace(), frame_id=""),
            child_frame_id="",
            transform=SimpleNamespace(translation=SimpleNamespace(), rotation=SimpleNamespace()),
        )

    message = SimpleNamespace(transforms=[])
    place = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8])
    for stamp in (5.25, 6.5):
        fill_transforms(message, stamp, [("map", "a", place), ("a", "b", 2.0 * place)], make)
        if stamp == 5.25:
            before = message.transforms
    assert message.transforms is before
    first, second = message.transforms
    assert (first.header.frame_id, first.child_frame_id) == ("map", "a")
    assert (first.header.stamp.sec, first.header.stamp.nanosec) == (6, 500_000_000)
    assert vars(first.transform.rotation) == {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}
    assert vars(second.transform.translation) == {"x": 2.0, "y": 4.0, "z": 6.0}
