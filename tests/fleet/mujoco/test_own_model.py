"""A user's own MuJoCo model of a quadruped."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco import ContactRecorder, TeamSimulator, own_robot
from cavalcade.robots import robot_model

pytest.importorskip("mujoco")

GO1 = robot_model("go1")

LEG = """
<body name="{leg}_upper" pos="{x} {y} 0">
  <inertial pos="0 0 0" mass="0.6" diaginertia="0.001 0.001 0.001"/>
  <joint {abduction} axis="1 0 0" range="-50 50"/>
  <body pos="0 {side} 0">
    <inertial pos="0 0 -0.05" mass="1.0" diaginertia="0.005 0.005 0.001"/>
    <joint {swing} axis="0 1 0" range="-60 180"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.2"/>
    <body pos="0 0 -0.2">
      <inertial pos="0 0 -0.1" mass="0.2" diaginertia="0.001 0.001 0.0001"/>
      <joint {knee} axis="0 1 0" range="{bend}"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.18"/>
      <body pos="0 0 -0.2"><geom {foot} type="sphere" size="0.025" mass="0.05"/></body>
    </body>
  </body>
</body>
"""

FILE = """
<mujoco>
  <option timestep="0.01" cone="pyramidal"/>
  <default><motor ctrlrange="-30 30"/></default>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="torso" pos="0 0 0.4">
      <freejoint/>
      <geom type="box" size="0.2 0.1 0.05" mass="6"/>
      {legs}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
  <sensor><jointpos joint="knee_FR"/></sensor>
  <keyframe><key qpos="0 0 0.4 1 0 0 0  0 0 0  0 0 0  0 0 0  0 0 0"/></keyframe>
</mujoco>
"""


def text(order=("FR", "FL", "RR", "RL"), feet="{leg}_foot", bend="-160 -40", named=True):
    """A model whose legs stand in another order than ours."""
    legs = []
    for leg in order:
        side = 1.0 if leg[1] == "L" else -1.0
        foot = feet.format(leg=leg)
        names = {"abduction": f"roll_{leg}", "swing": f"pitch_{leg}", "knee": f"knee_{leg}"}
        legs.append(
            LEG.format(
                leg=leg,
                x=0.2 if leg[0] == "F" else -0.2,
                y=0.05 * side,
                side=0.08 * side,
                foot=f'name="{foot}"' if foot else "",
                bend=bend,
                **{key: f'name="{name}"' for key, name in names.items()},
            )
        )
    motors = "".join(
        f'<motor joint="{joint}_{leg}"/>' for leg in order for joint in ("roll", "pitch", "knee")
    )
    return FILE.format(legs="".join(legs), motors=motors)


@pytest.fixture
def written(tmp_path):
    def written(content):
        file = tmp_path / "mine.xml"
        file.write_text(content)
        return file

    return written


def test_its_figures_are_those_of_the_file(written):
    robot = own_robot(written(text()), GO1)
    described = robot.description
    assert robot.name == described.name == "mine"
    assert (robot.length, robot.width) == (GO1.length, GO1.width)
    assert described.mass == pytest.approx(6.0 + 4 * (0.6 + 1.0 + 0.2 + 0.05))
    assert described.trunk.mass == pytest.approx(6.0)
    expected = [[0.2, 0.05, 0], [0.2, -0.05, 0], [-0.2, 0.05, 0], [-0.2, -0.05, 0]]
    np.testing.assert_allclose(described.joint_offsets[:, 0], expected, atol=1e-9)
    np.testing.assert_allclose(described.joint_offsets[:, 1, 1], [0.08, -0.08, 0.08, -0.08])
    np.testing.assert_allclose(described.joint_offsets[:, 2:], [[[0, 0, -0.2]] * 2] * 4, atol=1e-9)
    np.testing.assert_allclose(described.joint_range[2], np.radians([-160.0, -40.0]))
    np.testing.assert_array_equal(described.torque_limits, 30.0)
    assert described.foot_radius == 0.025
    calf = described.legs[0].links[2]
    assert calf.mass == pytest.approx(0.25)
    np.testing.assert_allclose(calf.center, [0.0, 0.0, -(0.2 * 0.1 + 0.05 * 0.2) / 0.25])


def test_shapes_hang_on_the_right_parts(written):
    described = own_robot(written(text()), GO1).description
    solids = {(shape.part, shape.leg): shape for shape in described.solids}
    assert set(solids) == {
        ("trunk", -1),
        *((part, leg) for part in ("thigh", "calf", "foot") for leg in range(4)),
    }
    assert solids["trunk", -1].size == (0.2, 0.1, 0.05)
    assert solids["foot", 2].position == pytest.approx((0.0, 0.0, -0.2))
    assert solids["thigh", 1].size == pytest.approx((0.02, 0.1, 0.0))
    assert solids["thigh", 1].position == pytest.approx((0.0, 0.0, -0.1))


def test_our_own_robot_comes_back_from_its_file(written):
    from cavalcade.fleet.mujoco.robot_spec import robot_spec

    spec = robot_spec(GO1.description, (1, 1), 0.8).spec
    spec.compile()
    again = own_robot(written(spec.to_xml()), GO1).description
    ours = GO1.description
    assert again.mass == pytest.approx(ours.mass, rel=1e-6)
    np.testing.assert_allclose(again.joint_offsets, ours.joint_offsets, atol=1e-6)
    np.testing.assert_allclose(again.joint_range, ours.joint_range, atol=1e-6)
    np.testing.assert_allclose(again.torque_limits, ours.torque_limits, atol=1e-6)
    bodies = (ours.trunk, *(link for leg in ours.legs for link in leg.links))
    others = (again.trunk, *(link for leg in again.legs for link in leg.links))
    for one, other in zip(bodies, others, strict=True):
        np.testing.assert_allclose(other.center, one.center, atol=1e-6)
        np.testing.assert_allclose(other.matrix, one.matrix, atol=1e-7)
    for one, other in zip(ours.joints, again.joints, strict=True):
        assert other.armature == pytest.approx(one.armature, rel=1e-4)
        assert (other.damping, other.friction) == pytest.approx((one.damping, one.friction))


@pytest.mark.parametrize("bend", ["-160 -40", "40 160"])
def test_several_of_them_stand_beside_ours(written, hold, bend):
    mine = own_robot(written(text(bend=bend)), GO1)
    poses = [(0.0, 0.0, 0.0), (2.0, 0.0, 1.0), (4.0, 0.0, 2.0)]
    simulator = TeamSimulator([mine, GO1, mine], poses)
    recorder = ContactRecorder(simulator)
    hold(simulator, 1500, recorder.record, stiffness=150.0)
    weights = 9.81 * np.array([mine.description.mass, GO1.description.mass, mine.description.mass])
    np.testing.assert_allclose(simulator.foot_forces.sum(axis=1), weights, rtol=5e-3)
    assert recorder.contacts == ()
    assert simulator.model.opt.timestep == 0.002
    # The legs are ours: left ones are on the left.
    places = simulator.data.geom_xpos
    team = simulator.team
    for leg, x, y in ((0, 1, 1), (1, 1, -1), (2, -1, 1), (3, -1, -1)):
        foot = (team.geom_robot == 0) & (team.geom_part == 4) & (team.geom_leg == leg)
        assert np.sign(places[foot][0, :2]).tolist() == [x, y]


@pytest.mark.parametrize("feet", ["{leg}", "{leg}_foot_collision", "foot_{leg}", "", "ball_{leg}"])
def test_feet_are_found_by_name_or_as_the_lowest_ball(written, feet):
    robot = own_robot(written(text(feet=feet)), GO1)
    assert [leg.foot[2] for leg in robot.description.legs] == pytest.approx([-0.2] * 4)


def test_torque_limits_from_other_places(written):
    limited = text().replace('<motor joint="knee_FL"/>', '<motor joint="knee_FL" gear="2"/>')
    limited = limited.replace(
        '<joint name="roll_FL"', '<joint actuatorfrcrange="-9 9" name="roll_FL"'
    )
    limits = own_robot(written(limited), GO1).description.torque_limits
    assert limits[[0, 1, 2]].tolist() == [9.0, 30.0, 60.0]
    assert own_robot(written(limited), GO1).description.torque_limits[3] == 30.0


@pytest.mark.parametrize("how", ["", 'mocap="true"'])
def test_what_else_stands_in_its_world_is_left_out(written, how):
    floor = '<geom name="floor"'
    table = f'<body name="table" {how} pos="2 0 0"><geom type="box" size="0.1 0.1 0.1"/></body>'
    weld = '<equality><weld body1="table" body2="torso"/></equality><sensor>'
    crowded = text().replace(floor, table + floor).replace("<sensor>", weld)
    again = own_robot(written(crowded), GO1)
    assert again.description.mass == own_robot(written(text()), GO1).description.mass
    assert TeamSimulator([again], [(0.0, 0.0, 0.0)]).model.nbody == 1 + 17


BROKEN = {
    "no free joint": (("<freejoint/>", ""), "expected one body with a free joint"),
    "one hinge less": (
        ('<joint name="knee_RL" axis="0 1 0" range="-160 -40"/>', ""),
        "expected 12 hinge joints",
    ),
    "a slide": (
        ('<joint name="knee_RL" axis', '<joint type="slide" name="knee_RL" axis'),
        "found 11 and 1 of other kinds",
    ),
    "another axis": (
        ('<joint name="knee_RL" axis="0 1 0"', '<joint name="knee_RL" axis="0 -1 0"'),
        r"'knee_RL' is the calf of leg RL; expected it to turn about \+y",
    ),
    "turned link": (
        ('<body name="FL_upper"', '<body euler="0 20 0" name="FL_upper"'),
        "'roll_FL' is the hip of leg FL",
    ),
    "two left": (("-0.2 -0.05 0", "-0.2 0.06 0"), "expected four legs of three joints"),
    "no torque limit": (('<motor joint="roll_FR"/>', ""), "'roll_FR' has no torque limit"),
    "no torque forwards": (("-30 30", "-30 0"), "largest torque of 0 N m"),
    "no foot": (
        ('type="sphere" size="0.025"', 'type="box" size="0.02 0.02 0.02"'),
        "no foot on leg FL",
    ),
    "no xml": (("<mujoco>", "<mujoco"), "not a MuJoCo model that can be used"),
    "unknown joint": (('joint="knee_FR"/></sensor>', 'joint="x"/></sensor>'), "not a MuJoCo model"),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_faults_are_answered_in_one_line_that_names_the_file(written, fault):
    (old, new), said = BROKEN[fault]
    content = text()
    assert old in content
    content = content.replace(old, new)
    if fault in ("one hinge less", "a slide", "no torque limit"):
        content = re.sub(r"<sensor>.*</keyframe>", "", content, flags=re.S)
    if fault in ("one hinge less", "a slide"):
        content = content.replace('<motor joint="knee_RL"/>', "")
    file = written(content)
    with pytest.raises(InputError, match=said) as caught:
        own_robot(file, GO1)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="there is no such MuJoCo model"):
        own_robot(tmp_path / "none.xml", GO1)
