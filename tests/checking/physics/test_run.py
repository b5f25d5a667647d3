"""Whole runs in physics: a real one passes, and what is changed about it is found."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from cavalcade.checking import check
from cavalcade.checking.check import judge_physics
from cavalcade.checking.physics.record import read_records
from cavalcade.checking.tracks import read_tracks
from cavalcade.errors import RecordingError
from cavalcade.scenario import load_scenario, resolve_scenario

pytest.importorskip("mujoco")

SCENARIO = """
version: 1
name: short-walk
world:
  empty: {size: [6, 4]}
  obstacles:
    - {box: {center: [3.0, 0.9], size: [0.4, 0.4]}}
robots:
  - {model: go1, start: [1.0, 1.6, 0.0]}
  - {model: go1, start: [1.0, 2.4, 0.0]}
task:
  formation: {shape: line, spacing: 0.8}
  goals: [[3.0, 2.0, 0.0]]
execution: {backend: mujoco, timeout: 20}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import cavalcade as cv

    home = tmp_path_factory.mktemp("physics")
    (home / "walk.yaml").write_text(SCENARIO)
    out = home / "out"
    result = cv.run(cv.load_scenario(home / "walk.yaml"), out=out, seed=1)
    assert result.success
    return out


@pytest.fixture
def run(folder):
    """What is judged: scenario, tracks, records and summary."""
    scenario = resolve_scenario(load_scenario(folder / "scenario.yaml"))
    recording = folder / "recording.mcap"
    summary = json.loads((folder / "summary.json").read_text())
    return scenario, read_tracks(recording, 2), read_records(recording, 2), summary


def kinds(report):
    return {violation.kind for violation in report.violations}


def changed(run, **changes):
    """The run with another first robot."""
    scenario, tracks, (first, *others), summary = run
    return scenario, tracks, (replace(first, **changes), *others), summary


def test_a_real_run_is_clean(folder):
    report = check(folder)
    assert report.violations == ()
    assert report.figures is not None
    assert report.figures.robots == 2
    physics = report.figures.physics
    assert physics.carried == pytest.approx((1.0, 1.0), abs=0.01)
    assert 0.1 < physics.max_torque_ratio <= 1.0
    assert 0.0 < physics.max_slide_m < 0.01


def test_records_are_what_was_run(run):
    _, _, records, summary = run
    for record in records:
        assert record.time[0] == 0.0
        assert record.time[-1] == pytest.approx(summary["sim_time_s"], abs=0.02)
        assert np.abs(record.rates).max() > 1.0
        assert record.forces[5:, :, 2].sum(axis=1).mean() == pytest.approx(128.5, rel=0.02)


def test_in_memory_it_is_judged_alike(folder, run):
    """From the arrays that the run kept, without its file."""
    import cavalcade as cv
    from cavalcade.checking.physics import Touch, records_from

    scenario, tracks, records, summary = run
    kept = cv.read_recording(folder).physics
    touches = [
        [Touch(c.time, c.part, c.other) for c in kept.contacts if c.robot == robot]
        for robot in range(2)
    ]
    motion = (kept.base, kept.joints, kept.joint_rates, kept.torques, kept.foot_forces)
    same = records_from(records[0].time, motion, touches)
    assert judge_physics(scenario, tracks, same, summary) == check(folder)


def slide(run, speed):
    """The first robot beside its recording: body and pose drift sideways together."""
    scenario, (track, *others), (record, *rest), summary = run
    base, pose = record.base.copy(), track.pose.copy()
    base[:, 1] -= speed * record.time
    pose[:, 1] -= speed * track.time
    moved = replace(track, pose=pose), *others
    return scenario, moved, (replace(record, base=base), *rest), summary


def test_a_run_is_not_slid_a_little_further(run):
    assert "slide" in kinds(judge_physics(*slide(run, 0.1)))


def test_a_body_elsewhere_than_its_pose_is_found(run):
    base = run[2][0].base.copy()
    base[:, 0] += 0.01
    assert kinds(judge_physics(*changed(run, base=base))) == {"pose"}


def test_a_run_with_idle_motors_is_refused(run):
    report = judge_physics(*changed(run, torques=0.0 * run[2][0].torques))
    assert kinds(report) == {"torque"}


def test_a_run_with_the_forces_of_another_moment_is_refused(run):
    forces = np.roll(run[2][0].forces, 10, axis=0)
    found = kinds(judge_physics(*changed(run, forces=forces)))
    assert {"momentum", "footing"} & found


def test_forces_evened_out_are_refused(run):
    """Each foot with its mean: right in sum, wrong at every moment."""
    forces = np.broadcast_to(run[2][0].forces.mean(axis=0), run[2][0].forces.shape)
    assert "footing" in kinds(judge_physics(*changed(run, forces=forces)))


def test_contacts_left_out_are_found_by_geometry(run):
    """The obstacle is where the robot has been, and nothing was recorded."""
    scenario, *rest = run
    record = rest[1][0]
    middle = [float(v) for v in record.base[len(record.time) // 2, :2]]
    box = scenario.world.obstacles[0].box.model_copy(update={"center": tuple(middle)})
    obstacle = scenario.world.obstacles[0].model_copy(update={"box": box})
    world = scenario.world.model_copy(update={"obstacles": (obstacle,)})
    report = judge_physics(scenario.model_copy(update={"world": world}), *rest)
    hidden = [v for v in report.violations if v.kind == "robot-obstacle"]
    assert hidden
    assert hidden[0].obstacle == "world.obstacles[0]"
    assert "summary" in kinds(report)


@pytest.mark.parametrize(
    ("key", "more"),
    [
        ("min_robot_distance_m", 0.1),
        ("min_obstacle_distance_m", 0.1),
        ("min_footprint_gap_m", 0.1),
    ],
)
def test_overstated_distances_are_found(run, key, more):
    scenario, tracks, records, summary = run
    report = judge_physics(scenario, tracks, records, {**summary, key: summary[key] + more})
    assert kinds(report) == {"summary"}


def test_falls_that_the_summary_denies_are_found(run):
    base = run[2][0].base.copy()
    late = run[2][0].time > run[2][0].time[-1] - 0.5
    base[late, 3:] = (np.cos(0.8), np.sin(0.8), 0.0, 0.0)
    report = judge_physics(*changed(run, base=base))
    assert {"fall", "summary"} <= kinds(report)


def test_bodies_must_be_recorded_to_the_end(run):
    first = run[2][0]
    half = len(first.time) // 2
    names = ("time", "base", "joints", "rates", "torques", "forces")
    short = tuple(
        replace(record, **{name: getattr(record, name)[:half] for name in names})
        for record in run[2]
    )
    assert "samples" in kinds(judge_physics(run[0], run[1], short, run[3]))


def test_a_run_that_ends_at_once_is_clean_but_must_not_claim_more(tmp_path):
    import cavalcade as cv

    out = tmp_path / "out"
    result = cv.run(
        "infeasible", out=out, overrides=["robots.*.model=go1"], backend="mujoco", replay=False
    )
    assert result.reason == "infeasible"
    assert check(out).ok
    summary = json.loads((out / "summary.json").read_text())
    (out / "summary.json").write_text(json.dumps(summary | {"success": True}))
    assert not check(out).ok


def test_a_recording_without_bodies_cannot_be_judged(folder, tmp_path, recorder, knot_path):
    for name in ("scenario.yaml", "summary.json"):
        (tmp_path / name).write_text((folder / name).read_text())
    tracks = [knot_path([(0.0, 1.0, y, 0.0), (1.0, 1.0, y, 0.0)]) for y in (1.6, 2.4)]
    recorder(tmp_path / "recording.mcap", tracks)
    with pytest.raises(RecordingError, match="robot_0/body"):
        check(tmp_path)
