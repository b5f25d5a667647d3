"""Planted faults in a body's motion: each is found, named, with robot and time."""

from __future__ import annotations

import numpy as np
import pytest

WALK, TAKE_OFF, FLIGHT, LANDING = range(4)


def kinds(report):
    return {violation.kind for violation in report.violations}


def first(report, kind):
    return next(v for v in report.violations if v.kind == kind)


def middle_of(judged, phase):
    return int(np.median(np.flatnonzero(judged.arrays["phase_0"] == phase)))


def test_a_position_that_jumps(walker):
    walker.arrays["position_0"][100:, 1] += 0.002
    report = walker.report()
    violation = first(report, "dynamics")
    assert violation.robots == (0,)
    assert violation.time == pytest.approx(walker.arrays["t_0"][99])


def test_velocities_that_are_not_those_of_the_positions(walker):
    walker.arrays["velocity_0"] *= 0.95
    assert kinds(walker.report()) == {"dynamics"}


@pytest.mark.parametrize("axis", [0, 2])
def test_positions_off_in_flight_are_found_to_a_tenth_of_a_millimetre(leaper, axis):
    k = middle_of(leaper, FLIGHT)
    leaper.arrays["position_0"][k, axis] += 1e-4
    assert kinds(leaper.report()) == {"dynamics"}
    assert first(leaper.report(), "dynamics").time == leaper.arrays["t_0"][k - 1]


def test_stretched_time(walker):
    # Half the time: twice the speed, but not where velocities say so.
    walker.arrays["t_0"] *= 0.9
    assert "dynamics" in kinds(walker.report())


def test_a_plan_that_does_not_end_at_rest(maker, team):
    judged = team(maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75).cruise(0.75, 1.0))
    assert kinds(judged.report()) == {"dynamics"}
    assert "ends its plan at 0.750 m/s" in judged.report().violations[0].message


def test_a_plan_that_does_not_begin_at_rest(maker, team):
    judged = team(maker((5.0, 5.0, 0.0)).cruise(0.75, 1.0).ramp(0.75, 0.0))
    assert "begins its plan at 0.750 m/s" in judged.report().violations[0].message


@pytest.mark.parametrize(("acceleration", "ok"), [(2.45, True), (2.6, False)])
def test_friction_while_walking(maker, team, acceleration, ok):
    plan = maker((5.0, 5.0, 0.0)).wait(0.3).walk(2.0, speed=1.5, acceleration=acceleration)
    report = team(plan).report()
    assert report.ok == ok
    if not ok:
        violation = first(report, "force")
        assert violation.time == pytest.approx(0.3)
        assert violation.value == pytest.approx(acceleration, rel=0.01)
        assert violation.limit == pytest.approx(0.25 * 9.81)


@pytest.mark.parametrize(("speed", "ok"), [(2.0, True), (2.1, False)])
def test_speed(maker, team, speed, ok):
    report = team(maker((3.0, 5.0, 0.0)).walk(8.0, speed=speed, acceleration=2.0)).report()
    assert report.ok == ok
    assert ok or kinds(report) == {"speed"}


@pytest.mark.parametrize(("rate", "ok"), [(1.2, True), (1.25, True), (1.3, False)])
def test_yaw_rate(maker, team, rate, ok):
    report = team(maker((5.0, 5.0, 0.0)).turn(2.0, rate=rate)).report()
    assert report.ok == ok
    assert ok or kinds(report) == {"yaw-rate"}


@pytest.mark.parametrize(("angle", "ok"), [(0.05, True), (-0.15, False), (np.pi, False)])
def test_walking_sideways_or_backwards(walker, angle, ok):
    moving = np.hypot(*walker.arrays["velocity_0"][:, :2].T) > 0.0
    turn = np.where(moving, angle, np.where(walker.arrays["t_0"] > 2.0, angle, 0.0))
    walker.arrays["yaw_0"] += turn
    found = kinds(walker.report())
    assert ("heading" in found) == (not ok)


def test_the_heading_is_free_while_standing(maker, team):
    assert team(maker((5.0, 5.0, 0.0)).turn(1.0).turn(-2.0).wait(1.0)).report().ok


@pytest.mark.parametrize("phase", [TAKE_OFF, LANDING])
@pytest.mark.parametrize(("force", "ok"), [(4.9, True), (5.3, False)])
def test_the_force_of_legs(maker, team, phase, force, ok):
    duration = 0.08
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75)
    judged = team(plan.leap(force=force, duration=duration).ramp(0.75, 0.0))
    found = [v for v in judged.report().violations if v.kind == "force"]
    times = judged.arrays["t_0"][judged.arrays["phase_0"] == phase]
    inside = [v for v in found if times[0] <= v.time <= times[-1]]
    assert bool(inside) == (not ok)
    if not ok:
        assert inside[0].limit == 5.0


@pytest.mark.parametrize("phase", [TAKE_OFF, LANDING])
def test_the_friction_cone_in_a_leap(leaper, phase):
    time = leaper.arrays["t_0"]
    k = middle_of(leaper, phase)
    dt = time[k + 1] - time[k]
    # 1 body weight across where 3 press: beyond 0.25 of them.
    kick = 9.81 * dt
    leaper.arrays["velocity_0"][k + 1 :, 1] += kick
    leaper.arrays["position_0"][k + 1 :, 1] += kick * (time[k + 1 :] - time[k] - dt / 2)
    violation = first(leaper.report(), "force")
    assert violation.time == time[k]
    assert "friction" in violation.message
    assert violation.value == pytest.approx(1.0, rel=0.01)


def test_a_leg_that_pulls(leaper):
    time, k = leaper.arrays["t_0"], middle_of(leaper, LANDING)
    dt = time[k + 1] - time[k]
    leaper.arrays["velocity_0"][k + 1 :, 2] -= 6.0 * 9.81 * dt
    assert "pull" in first(leaper.report(), "force").message


@pytest.mark.parametrize("push", [(0.1, 0.0, 0.0), (0.0, 0.0, -0.1)])
def test_flight_is_ballistic(leaper, push):
    time = leaper.arrays["t_0"]
    k = middle_of(leaper, FLIGHT)
    after = (time[k + 1 :] - time[k])[:, None]
    dt = time[k + 1] - time[k]
    change = np.array(push) * dt
    leaper.arrays["velocity_0"][k + 1 :] += change
    leaper.arrays["position_0"][k + 1 :] += change * (after - dt / 2)
    violation = first(leaper.report(), "ballistics")
    assert violation.time == time[k]
    assert violation.value == pytest.approx(0.1, rel=0.02)


def test_flight_under_another_gravity(leaper):
    flying = leaper.arrays["phase_0"] == FLIGHT
    leaper.arrays["velocity_0"][flying, 2] *= 0.9
    assert "ballistics" in kinds(leaper.report())


def jumping(maker, team, planner):
    """A leap of the published model: at its seams the vertical speed jumps by 1 m/s."""
    speed, force, duration = 0.75, 3.0, 0.2
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, speed).cruise(speed, 0.6)
    plan.dt = 0.02
    rise = 9.81 * duration * (2 * force / 3 - 1) - 1.0
    plan.push(TAKE_OFF, speed, -1.0, force, duration)
    flight = 2 * rise / 9.81
    high = plan.height
    plan.piece(
        flight,
        lambda t: (speed * t, speed, high + rise * t - 9.81 * t * t / 2, rise - 9.81 * t, 0.0),
        FLIGHT,
    )
    plan.push(LANDING, speed, -rise, force, duration)
    plan.dt = 0.03
    assert plan.height == pytest.approx(0.3)
    return team(plan.cruise(speed, 0.6).ramp(speed, 0.0), planner=planner)


def test_the_published_model_may_jump_at_its_seams(maker, team):
    assert jumping(maker, team, {"variant": "published"}).report().violations == ()


def test_our_own_may_not(maker, team):
    report = jumping(maker, team, None).report()
    assert kinds(report) == {"dynamics", "force"}


def test_the_published_model_may_not_jump_elsewhere(maker, team):
    judged = jumping(maker, team, {"variant": "published"})
    judged.arrays["velocity_0"][10:, 2] += 1.0
    judged.arrays["position_0"][11:, 2] += np.diff(judged.arrays["t_0"])[10:].cumsum()
    report = judged.report()
    assert kinds(report) >= {"dynamics", "force", "reach"}
    assert first(report, "dynamics").time == pytest.approx(judged.arrays["t_0"][9])


def test_a_walk_that_bounces(maker, team):
    plan = maker((5.0, 5.0, 0.0)).ramp(0.0, 0.75).sink(0.2, 0.75, 0.15).sink(0.3, 0.75, 0.15)
    report = team(plan.ramp(0.75, 0.0)).report()
    assert "force" in kinds(report)
