"""Where mass and feet are in a leap: against MuJoCo, and laws of the legs in flight."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.locomotion._centroid import measure_centroid
from cavalcade.locomotion._kinematics import measure_body
from cavalcade.locomotion._leap import flying_foot, keep_clear
from cavalcade.locomotion.leap import LeapManoeuvre, LeapSettings, plan_leap
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.locomotion.records import BODY, FLIGHT, LEAP, ROBOT, Centroid, Measured
from cavalcade.robots import robot_model


def row_of(name):
    rows = np.zeros(1, ROBOT)
    rows[0] = robot_parameters(robot_model(name).description)
    return rows


def seen(rows, qpos, qvel):
    """The body of the robot `rows[0]`, and its centroid."""
    body, measured = np.zeros(1, BODY), Measured(0.0, qpos, qvel, np.zeros(4))
    measure_body(rows[0], measured, body[0])
    return body[0], measure_centroid(rows[0], measured, body[0])


def random_state(description, rng, tilt=0.4):
    low, high = description.joint_range.T
    axis = rng.normal(size=3)
    half = 0.5 * rng.uniform(0.0, tilt)
    turn = [np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))]
    qpos = np.concatenate([rng.uniform(-1.0, 1.0, 3), turn, rng.uniform(low, high)])
    return qpos, rng.uniform(-2.0, 2.0, 18)


@pytest.mark.parametrize("name", ["go1", "go2"])
@pytest.mark.parametrize("seed", range(5))
def test_the_mass_is_where_mujoco_has_it_and_moves_as_there(name, seed):
    mujoco = pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco import TeamSimulator

    model = robot_model(name)
    simulator = TeamSimulator([model], [[0.0, 0.0, 0.0]])
    rng = np.random.default_rng(seed)
    qpos, qvel = random_state(model.description, rng)
    data, team = simulator.data, simulator.team
    data.qpos[team.qpos[0]], data.qvel[team.qvel[0]] = qpos, qvel
    mujoco.mj_forward(simulator.model, data)
    mujoco.mj_subtreeVel(simulator.model, data)
    _, (centre, velocity, _) = seen(row_of(name), qpos, qvel)
    trunk = int(team.trunks[0])
    np.testing.assert_allclose(centre, data.subtree_com[trunk], atol=1e-5)
    np.testing.assert_allclose(velocity, data.subtree_linvel[trunk], atol=1e-4)


def test_a_body_whose_joints_rest_turns_as_its_trunk():
    rows = row_of("go1")
    description = robot_model("go1").description
    qpos = np.concatenate([[0.0, 0.0, 0.28], [1.0, 0.0, 0.0, 0.0], description.standing])
    qvel = np.zeros(18)
    qvel[3:6] = 0.3, -0.2, 0.5
    body, (centre, _, spin) = seen(rows, qpos, qvel)
    np.testing.assert_allclose(spin, qvel[3:6], atol=1e-12)
    np.testing.assert_allclose(centre, body["centre"], atol=1e-9)
    # Legs that swing forward turn the rest the other way, and the mean turns with the legs.
    qvel[:] = 0.0
    qvel[7::3] = -2.0
    _, (_, velocity, spin) = seen(rows, qpos, qvel)
    assert spin[1] < -0.05
    assert velocity[0] > 0.0


def leap_row():
    description = robot_model("go1").description
    parameters = robot_parameters(description)
    feet = np.column_stack(
        [parameters["hip"][:, 0], parameters["hip"][:, 1] + parameters["side"], np.full(4, 0.02)]
    )
    leap = LeapManoeuvre((0.0, 0.0, 0.0, 0.0), (0.75, 0.0, 0.0, 0.0), (0.23, 0.53))
    row = np.zeros(1, LEAP)
    row[0] = plan_leap(leap, parameters, 0.28, feet, 0.0, LeapSettings())
    row["left"][0] = feet
    return row


def fly(row, leg, t):
    """Place and rate of a foot while the body flies as planned."""
    lift, velocity = row["lift"][0], row["lift_velocity"][0]
    fall = np.array([0.0, 0.0, 9.81])
    place, rate = np.zeros(3), np.zeros(3)
    centre, speed = lift + velocity * t - 0.5 * fall * t * t, velocity - fall * t
    flying_foot(row[0], Centroid(centre, speed, np.zeros(3)), leg, t, place, rate)
    return place, rate, centre


@pytest.mark.parametrize("leg", range(4))
def test_feet_fly_from_where_they_stood_to_their_footholds(leg):
    row = leap_row()
    lasts = row["lasts"][0, FLIGHT]
    np.testing.assert_allclose(fly(row, leg, 0.0)[0], row["left"][0, leg], atol=1e-12)
    np.testing.assert_allclose(fly(row, leg, lasts)[0], row["foothold"][0, leg], atol=1e-9)
    # Drawn up in between, over the gap's whole width.
    heights = [fly(row, leg, t) for t in np.linspace(0.0, lasts, 60)]
    over = [place[2] for place, _, _ in heights if 0.24 < place[0] < 0.52]
    assert min(over) > 0.08
    middle = fly(row, leg, 0.5 * lasts)
    assert middle[0][2] - middle[2][2] == pytest.approx(-row["tuck"][0])


@pytest.mark.parametrize("leg", range(4))
def test_feet_rates_are_their_places_rates(leg):
    row, dt = leap_row(), 1e-6
    for share in (0.05, 0.2, 0.45, 0.65, 0.8, 0.95):
        t = share * row["lasts"][0, FLIGHT]
        ahead, behind = fly(row, leg, t + dt)[0], fly(row, leg, t - dt)[0]
        np.testing.assert_allclose((ahead - behind) / (2 * dt), fly(row, leg, t)[1], atol=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_feet_are_kept_where_legs_can_be_and_left_alone_there(seed):
    rng, rows = np.random.default_rng(seed), row_of("go1")
    description = robot_model("go1").description
    qpos, qvel = random_state(description, rng, tilt=0.8)
    body, _ = seen(rows, qpos, qvel)
    for leg in range(4):
        place = qpos[:3] + rng.uniform(-0.4, 0.4, 3)
        keep_clear(rows[0], body, leg, place)
        local = body["matrix"].T @ (place - qpos[:3])
        hip = rows["hip"][0, leg]
        assert local[2] <= hip[2] - 0.11 + 1e-9
        assert abs(local[1] - hip[1] - rows["side"][0, leg]) <= 0.12 + 1e-9
        again = place.copy()
        keep_clear(rows[0], body, leg, again)
        np.testing.assert_allclose(again, place, atol=1e-12)
