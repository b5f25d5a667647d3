"""How leaps are laid out: laws of ballistics, of frames and of the order of phases."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.geometry import GRAVITY
from cavalcade.locomotion._leap_horizon import foothold, leap_reference
from cavalcade.locomotion.leap import LeapManoeuvre, LeapSettings, plan_leap
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.locomotion.records import CROUCH, FLIGHT, LANDING, LEAP, PUSH
from cavalcade.robots import robot_model

GO1 = robot_model("go1").description
ROBOT = robot_parameters(GO1)
HEIGHT = 0.28
GAP = LeapManoeuvre((0.0, 0.0, 0.0, 0.0), (0.75, 0.0, 0.0, 0.0), (0.23, 0.53))
STEP = LeapManoeuvre((0.0, 0.0, 0.0, 0.0), (0.57, 0.0, 0.2, 0.0), (0.33, 0.33))
DROP = LeapManoeuvre((0.0, 0.0, 0.3, 0.0), (0.6, 0.1, 0.1, 0.2), (0.28, 0.28))
LEAPS = (GAP, STEP, DROP)


def feet_below(pose):
    """Where the feet stand at a pose x, y, ground, yaw."""
    c, s = math.cos(pose[3]), math.sin(pose[3])
    ahead, aside = ROBOT["hip"][:, 0], ROBOT["hip"][:, 1] + ROBOT["side"]
    return np.column_stack(
        [
            pose[0] + c * ahead - s * aside,
            pose[1] + s * ahead + c * aside,
            np.full(4, pose[2] + GO1.foot_radius),
        ]
    )


def laid(manoeuvre, settings=None):
    """The leap of a robot that stands at the take-off, as a row that kernels take."""
    row = np.zeros(1, LEAP)
    row[0] = plan_leap(
        manoeuvre,
        ROBOT,
        HEIGHT,
        feet_below(manoeuvre.take_off),
        manoeuvre.take_off[3],
        settings or LeapSettings(),
    )
    row[0]["start"] = (*manoeuvre.take_off[:2], manoeuvre.take_off[2] + HEIGHT)
    return row


def state(row, phase, t):
    out = np.zeros(12)
    leap_reference(row[0], phase, t, out)
    return out


@pytest.mark.parametrize("manoeuvre", LEAPS)
def test_a_flight_is_ballistic_and_ends_where_it_should(manoeuvre):
    row = laid(manoeuvre)
    lasts, velocity = row["lasts"][0, FLIGHT], row["lift_velocity"][0]
    fall = np.array([0.0, 0.0, GRAVITY])
    end = row["lift"][0] + velocity * lasts - 0.5 * fall * lasts**2
    np.testing.assert_allclose(end, row["down"][0], atol=1e-12)
    np.testing.assert_allclose(velocity - fall * lasts, row["down_velocity"][0], atol=1e-12)
    # It goes up, comes down, and is never lower than at its ends.
    assert velocity[2] > 0.0 > row["down_velocity"][0, 2]


@pytest.mark.parametrize("manoeuvre", LEAPS)
def test_one_phase_begins_as_the_last_ends(manoeuvre):
    row = laid(manoeuvre)
    for phase in (CROUCH, PUSH, FLIGHT):
        end = state(row, phase, row["lasts"][0, phase])
        np.testing.assert_allclose(state(row, phase + 1, 0.0), end, atol=1e-9)
    rest = state(row, LANDING, row["lasts"][0, LANDING])
    np.testing.assert_allclose(rest[3:6], row["rest"][0], atol=1e-12)
    np.testing.assert_allclose(rest[9:12], 0.0, atol=1e-12)


@pytest.mark.parametrize("manoeuvre", LEAPS)
@pytest.mark.parametrize("phase", [CROUCH, PUSH, FLIGHT, LANDING])
def test_speeds_are_the_places_rates(manoeuvre, phase):
    row, dt = laid(manoeuvre), 1e-6
    for share in (0.1, 0.37, 0.74):
        t = share * row["lasts"][0, phase]
        ahead, behind, now = (state(row, phase, t + d) for d in (dt, -dt, 0.0))
        np.testing.assert_allclose((ahead[3:6] - behind[3:6]) / (2 * dt), now[9:12], atol=1e-6)
        for angle, rate in ((1, 7), (2, 8)):
            turned = (ahead[angle] - behind[angle]) / (2 * dt)
            assert turned == pytest.approx(now[rate], abs=1e-6)


@pytest.mark.parametrize("manoeuvre", LEAPS)
def test_feet_land_beyond_the_edge_with_a_margin(manoeuvre):
    settings = LeapSettings()
    row = laid(manoeuvre, settings)
    along = row["along"][0]
    edge = np.dot(manoeuvre.take_off[:2], along) + manoeuvre.edges[1]
    for shift in (0.0, -0.2, 0.1):
        row["shift"][0] = shift * along
        for leg in range(4):
            assert np.dot(foothold(row[0], leg), along) >= edge + settings.margin - 1e-9
    lower = max(manoeuvre.take_off[2] - manoeuvre.landing[2], 0.0)
    clear = settings.margin + min(settings.drop * lower, settings.clear)
    assert row["bound"][0] == pytest.approx(edge + clear)
    np.testing.assert_allclose(row["foothold"][0, :, 2], manoeuvre.landing[2] + GO1.foot_radius)


def test_footholds_come_along_with_a_body_that_flies_further():
    row = laid(GAP)
    before = [foothold(row[0], leg) for leg in range(4)]
    row["shift"][0] = 0.1, 0.03
    after = [foothold(row[0], leg) for leg in range(4)]
    np.testing.assert_allclose(np.subtract(after, before), [[0.1, 0.03]] * 4, atol=1e-12)


@pytest.mark.parametrize("manoeuvre", LEAPS)
def test_the_same_leap_elsewhere_is_the_same(manoeuvre):
    turn, shift = 0.7, np.array([1.5, -2.0, 0.4])
    c, s = math.cos(turn), math.sin(turn)
    spin = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def moved(pose):
        x, y, z = spin @ np.array(pose[:3]) + shift
        return (float(x), float(y), float(z), pose[3] + turn)

    here = laid(manoeuvre)
    there = laid(
        replace(manoeuvre, take_off=moved(manoeuvre.take_off), landing=moved(manoeuvre.landing))
    )
    for name in ("squat", "lift", "down", "rest", "foothold"):
        np.testing.assert_allclose(there[name][0], here[name][0] @ spin.T + shift, atol=1e-9)
    for name in ("lift_velocity", "down_velocity"):
        np.testing.assert_allclose(there[name][0], here[name][0] @ spin.T, atol=1e-9)
    np.testing.assert_allclose(there["lasts"], here["lasts"])


def test_wider_gaps_and_higher_steps_ask_for_more_speed():
    def speed(manoeuvre):
        return float(np.linalg.norm(laid(manoeuvre)["lift_velocity"][0]))

    wider = replace(GAP, landing=(0.85, 0.0, 0.0, 0.0), edges=(0.23, 0.63))
    higher = replace(STEP, landing=(0.57, 0.0, 0.25, 0.0))
    assert speed(wider) > speed(GAP)
    assert speed(higher) > speed(STEP)


def test_pushes_stay_within_their_limits_and_squats_above_the_lowest():
    settings = LeapSettings()
    for manoeuvre in LEAPS:
        row = laid(manoeuvre, settings)
        assert settings.push[0] <= row["lasts"][0, PUSH] <= settings.push[1]
        ground = manoeuvre.take_off[2] + float(ROBOT["centre"][2])
        assert row["squat"][0, 2] >= ground + settings.squat - 1e-12


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"take_off": (0.0, 0.0, 0.0)}, "take_off"),
        ({"landing": (math.nan, 0.0, 0.0, 0.0)}, "landing"),
        ({"edges": (0.5, 0.3)}, "edges"),
        ({"edges": (math.inf, math.inf)}, "edges"),
    ],
)
def test_leaps_that_make_no_sense_are_refused(change, key):
    with pytest.raises(InputError, match=key):
        replace(GAP, **change)


def test_leaps_beyond_what_legs_can_are_refused():
    settings = LeapSettings()
    far = replace(GAP, landing=(1.3, 0.0, 0.0, 0.0), edges=(0.23, 1.1))
    high = replace(STEP, landing=(0.57, 0.0, 0.5, 0.0))
    for leap in (far, high):
        with pytest.raises(InputError, match="m/s"):
            laid(leap, settings)
        assert np.linalg.norm(laid(leap, replace(settings, fastest=9.0))["lift_velocity"]) > 2.75


def test_a_leap_on_the_spot_goes_where_the_robot_looks():
    leap = LeapManoeuvre((1.0, 2.0, 0.0, 0.5), (1.0, 2.0, 0.1, 0.5))
    np.testing.assert_allclose(leap.direction, (math.cos(0.5), math.sin(0.5)))
