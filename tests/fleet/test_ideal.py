from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cavalcade.errors import InputError
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.geometry import wrap_angle
from cavalcade.robots import robot_model

GO1 = robot_model("go1")
DT = 0.05


def fleet_of(*poses: tuple[float, float, float], **options: object) -> IdealFleet:
    return IdealFleet([GO1] * len(poses), poses, **options)  # type: ignore[arg-type]


def drive(fleet: IdealFleet, command: object, cycles: int) -> np.ndarray:
    """Poses `(cycles + 1, N, 3)` under a command held for all robots."""
    poses = [fleet.true_poses()]
    for _ in range(cycles):
        fleet.send(np.tile(np.array(command, dtype=float), (fleet.size, 1)))
        fleet.advance(DT)
        poses.append(fleet.true_poses())
    return np.array(poses)


def test_robots_stand_where_they_were_put() -> None:
    fleet = fleet_of((1.0, 2.0, 0.5), (3.0, 4.0, -0.5))
    fleet.advance(1.0)
    assert np.array_equal(fleet.true_poses(), [(1.0, 2.0, 0.5), (3.0, 4.0, -0.5)])
    assert fleet.time == 1.0
    observation = fleet.observe()
    assert np.array_equal(observation.poses, fleet.true_poses())
    assert np.array_equal(observation.stamps, [1.0, 1.0])


def test_forward_command_reaches_full_speed_and_stops_again() -> None:
    fleet = fleet_of((0.0, 0.0, np.pi / 2))
    drive(fleet, (0.5, 0.0, 0.0), 40)
    assert fleet.true_velocities()[0] == pytest.approx([0.0, 0.5, 0.0], abs=1e-12)
    # 0.5 s to reach 0.5 m/s at 1 m/s², then 1.5 s of it.
    assert fleet.true_poses()[0] == pytest.approx([0.0, 0.125 + 0.75, np.pi / 2])
    drive(fleet, (0.0, 0.0, 0.0), 11)
    assert fleet.true_velocities()[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert fleet.true_poses()[0, 1] == pytest.approx(1.0)


def test_commands_beyond_the_limits_are_limited() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    drive(fleet, (0.0, 9.0, 0.0), 40)
    assert fleet.true_velocities()[0, 1] == pytest.approx(GO1.max_speed_y)
    drive(fleet, (0.0, 0.0, 9.0), 40)
    assert fleet.true_velocities()[0, 2] == pytest.approx(GO1.max_yaw_rate)


def test_yaw_is_wrapped_but_keeps_turning() -> None:
    fleet = fleet_of((0.0, 0.0, 3.0))
    yaw = drive(fleet, (0.0, 0.0, 1.0), 200)[:, 0, 2]
    assert np.all((yaw >= -np.pi) & (yaw < np.pi))
    assert np.all(wrap_angle(np.diff(yaw))[1:] > 0.0)


@settings(max_examples=40, deadline=None)
@given(
    arrays(float, (12, 2, 3), elements=st.floats(-2.0, 2.0)),
    st.floats(-np.pi, np.pi),
)
def test_recorded_samples_obey_the_limits(commands: np.ndarray, yaw: float) -> None:
    """Second differences of positions and yaw at 20 Hz, and the speed ellipse."""
    fleet = fleet_of((0.0, 0.0, yaw), (5.0, 0.0, -yaw))
    poses, velocities = [fleet.true_poses()], [fleet.true_velocities()]
    for command in commands:
        fleet.send(command)
        fleet.advance(DT)
        poses.append(fleet.true_poses())
        velocities.append(fleet.true_velocities())
    track = np.array(poses)
    track[..., 2] = np.unwrap(track[..., 2], axis=0)
    bend = np.diff(track, n=2, axis=0) / DT**2
    assert np.hypot(bend[..., 0], bend[..., 1]).max() <= GO1.max_acceleration + 1e-6
    assert np.abs(bend[..., 2]).max() <= GO1.max_yaw_acceleration + 1e-6
    speed = np.array(velocities)
    c, s = np.cos(track[..., 2]), np.sin(track[..., 2])
    along, across = (
        c * speed[..., 0] + s * speed[..., 1],
        c * speed[..., 1] - s * speed[..., 0],
    )
    ellipse = (along / GO1.max_speed_x) ** 2 + (across / GO1.max_speed_y) ** 2
    assert ellipse.max() <= 1.0 + 1e-9
    assert np.abs(speed[..., 2]).max() <= GO1.max_yaw_rate + 1e-9


@settings(max_examples=20, deadline=None)
@given(st.floats(0.001, 0.4), st.integers(1, 6))
def test_the_length_of_the_advance_does_not_matter(dt: float, parts: int) -> None:
    """Steps that the internal step divides give the same motion however they are grouped."""
    whole, split = fleet_of((0.0, 0.0, 0.0)), fleet_of((0.0, 0.0, 0.0))
    steps = max(1, int(dt * 100))
    for fleet in (whole, split):
        fleet.send([(0.4, 0.1, 0.3)])
    whole.advance(steps * parts * 0.01)
    for _ in range(parts):
        split.advance(steps * 0.01)
    assert whole.true_poses() == pytest.approx(split.true_poses(), abs=1e-9)


def test_noise_is_on_the_reports_only_and_has_the_asked_spread() -> None:
    noise = LocalisationNoise(position=0.05, heading=0.1)
    fleet = fleet_of((1.0, 2.0, 0.0), noise=noise, seed=3)
    reports = []
    for _ in range(2000):
        fleet.advance(0.01)
        reports.append(fleet.observe().poses[0])
    off = np.array(reports) - (1.0, 2.0, 0.0)
    assert np.abs(off.mean(axis=0)).max() < 0.01
    assert off.std(axis=0) == pytest.approx([0.05, 0.05, 0.1], rel=0.08)
    assert np.array_equal(fleet.true_poses(), [(1.0, 2.0, 0.0)])


def test_same_seed_same_world() -> None:
    def reports(seed: int) -> np.ndarray:
        fleet = fleet_of(
            (0.0, 0.0, 0.0),
            noise=LocalisationNoise(0.05, 0.05),
            delay=CommandDelay(0.1, 0.05, 0.2),
            seed=seed,
        )
        drive(fleet, (0.5, 0.0, 0.2), 40)
        return np.array([fleet.observe().poses, fleet.true_poses()])

    assert np.array_equal(reports(1), reports(1))
    assert not np.array_equal(reports(1), reports(2))


def test_reading_twice_gives_the_same_report() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), noise=LocalisationNoise(0.1, 0.1))
    fleet.advance(0.1)
    assert np.array_equal(fleet.observe().poses, fleet.observe().poses)


def test_a_delay_shifts_the_motion() -> None:
    prompt = drive(fleet_of((0.0, 0.0, 0.0)), (0.5, 0.0, 0.0), 40)
    late = drive(fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(mean=0.2)), (0.5, 0.0, 0.0), 44)
    assert np.all(late[:5, 0, 0] == 0.0)
    assert late[4:, 0] == pytest.approx(prompt[:, 0], abs=1e-9)


def test_an_overtaken_command_is_ignored() -> None:
    """With much jitter the last command sent is the one that holds in the end."""
    for seed in range(20):
        fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(0.3, 0.3), seed=seed)
        for speed in np.linspace(0.05, 0.5, 10):
            fleet.send([(speed, 0.0, 0.0)])
            fleet.advance(0.01)
        fleet.advance(3.0)
        assert fleet.true_velocities()[0, 0] == pytest.approx(0.5)


def test_lost_commands_never_arrive_and_lost_reports_grow_old() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(drop=1.0))
    drive(fleet, (0.5, 0.0, 0.0), 20)
    assert np.array_equal(fleet.true_poses(), [(0.0, 0.0, 0.0)])
    assert fleet.observe().stamps[0] == 0.0


def test_some_commands_lost_some_arrive() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(drop=0.5), seed=1)
    drive(fleet, (0.5, 0.0, 0.0), 60)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.5)


def test_a_silent_robot_brakes_and_is_not_heard_of_until_revived() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    drive(fleet, (0.5, 0.0, 0.0), 20)
    known = fleet.observe().poses[0]
    fleet.silence(0)
    track = drive(fleet, (0.5, 0.0, 0.0), 20)
    observation = fleet.observe()
    assert np.array_equal(observation.poses[0], known)
    assert observation.stamps == pytest.approx([1.0, 2.0])
    assert fleet.true_velocities()[:, 0] == pytest.approx([0.0, 0.5])
    # From 0.5 m/s at 1 m/s².
    assert track[-1, 0, 0] - track[0, 0, 0] == pytest.approx(0.125)
    fleet.revive(0)
    drive(fleet, (0.5, 0.0, 0.0), 20)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.5)
    assert fleet.observe().stamps[0] == pytest.approx(3.0)


def test_a_disabled_robot_stops_but_is_seen() -> None:
    fleet = fleet_of((0.0, 0.0, 0.0), delay=CommandDelay(mean=0.1))
    drive(fleet, (0.5, 0.0, 0.0), 20)
    fleet.disable(0)
    drive(fleet, (0.5, 0.0, 0.0), 20)
    assert fleet.true_velocities()[0, 0] == 0.0
    assert fleet.observe().stamps[0] == pytest.approx(2.0)
    assert fleet.observe().poses == pytest.approx(fleet.true_poses())
    fleet.enable(0)
    drive(fleet, (0.5, 0.0, 0.0), 20)
    assert fleet.true_velocities()[0, 0] == pytest.approx(0.5)


@pytest.mark.parametrize("poses", [[(0.0, 0.0)], [], [(0.0, 0.0, np.nan)], [(0.0, 0.0, 0.0)] * 2])
def test_malformed_starts_are_refused(poses: list[tuple[float, ...]]) -> None:
    with pytest.raises(InputError):
        IdealFleet([GO1], poses)


@pytest.mark.parametrize("command", [[(0.0, 0.0)], [(np.nan, 0.0, 0.0)], [(np.inf, 0.0, 0.0)]])
def test_malformed_commands_are_refused_and_change_nothing(command: object) -> None:
    fleet = fleet_of((0.0, 0.0, 0.0))
    with pytest.raises(InputError):
        fleet.send(command)  # type: ignore[arg-type]
    fleet.advance(0.1)
    assert np.array_equal(fleet.true_poses(), [(0.0, 0.0, 0.0)])


@pytest.mark.parametrize("dt", [0.0, -1.0, np.nan, np.inf])
def test_time_only_goes_forward(dt: float) -> None:
    with pytest.raises(InputError):
        fleet_of((0.0, 0.0, 0.0)).advance(dt)
