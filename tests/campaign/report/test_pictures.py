from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from cavalcade.campaign.report import write_report
from cavalcade.campaign.report.pictures import draw_paths, tightest
from cavalcade.campaign.report.worst import same_run
from cavalcade.drawing.scene import Scene
from cavalcade.jobs import JobResult
from cavalcade.recording.frames import Recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import build_world, parse_scenario

DATA = {
    "version": 1,
    "name": "two",
    "world": {
        "empty": {"size": [8, 5]},
        "obstacles": [{"circle": {"center": [4.0, 3.0], "radius": 0.3}}],
    },
    "robots": [{"model": "go1", "start": [1.0, y, 0.0]} for y in (1.0, 2.4)],
    "task": {"formation": {"shape": "line", "spacing": 1.4}, "goals": [[6.5, 1.7, 0.0]]},
}


@pytest.fixture(scope="module")
def run():
    """Two robots abreast; the upper one passes the circle at 0.16 m, seen from its flank."""
    scenario = parse_scenario(DATA)
    time = np.arange(111) * 0.1
    poses = np.zeros((111, 2, 3))
    poses[:, :, 0] = 1.0 + 0.5 * time[:, None]
    poses[:, :, 1] = (1.0, 2.4)
    status = PlannerStatus(
        state="final", leader=0, roles=np.array([0, 1]), slots=np.array([[0, 0.7], [0, -0.7]]),
        goals=poses[-1, :, :2], goal=np.array([6.5, 1.7, 0.0]), paths=((), ()),
        connections=np.array([[0, 1]]), eta=np.zeros(2), arrived=True, waypoint=0,
        goal_moved=0.0, involved=(), message="",
    )  # fmt: skip
    recording = Recording(time, poses, poses, np.zeros_like(poses), (status,) * 111, (), ())
    summary = {"reason": "arrived", "min_footprint_gap_m": 0.16, "collisions": {"robot_robot": 0}}
    return scenario, build_world(scenario), recording, summary


def test_the_tightest_place_is_where_it_is(run):
    scenario, world, recording, _ = run
    found = tightest(Scene(scenario, world, recording))
    flank = 2.4 + scenario.models[1].width / 2.0
    assert found.gap == pytest.approx(3.0 - 0.3 - flank, abs=0.01)
    assert found.place == pytest.approx([4.0, flank], abs=0.2)


def test_bodies_count_as_well(run):
    scenario, world, recording, _ = run
    poses = recording.poses.copy()
    poses[50, 0, 1] = 2.2  # upon the other one
    found = tightest(Scene(scenario, world, replace(recording, poses=poses)))
    assert found.cycle == 50
    assert found.gap == 0.0


@pytest.mark.parametrize("hits", [0, 2])
def test_the_paths_are_drawn(run, tmp_path, hits):
    *scene, summary = run
    summary = {**summary, "collisions": {"robot_robot": 0, "robot_obstacle": hits}}
    path = draw_paths(*scene, summary, tmp_path / "way.png")
    with Image.open(path) as picture:
        assert min(picture.size) > 400
        assert np.asarray(picture.convert("L")).std() > 10


def test_nothing_is_drawn_of_a_run_without_a_cycle(run, tmp_path):
    scenario, world, _, summary = run
    empty = Recording(np.zeros(0), np.zeros((0, 2, 3)), np.zeros((0, 2, 3)), np.zeros((0, 2, 3)),
                      (), (), ())  # fmt: skip
    assert draw_paths(scenario, world, empty, summary, tmp_path / "way.png") is None


def test_the_worst_trials_have_pictures(run, tmp_path, make_lines, suite):
    asked = []

    def replay(line):
        asked.append(line["trial"])
        scenario, world, recording, _ = run
        return JobResult(scenario, world, dict(line["summary"], wall_time_s=99.0), recording)

    lines = make_lines(5, ("clutter",), variants=("cavalcade",))
    write_report(tmp_path, suite, lines, replay=replay)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert len(set(asked)) == len(asked) == 2
    for name in asked:
        assert f"(figures/worst-{name}.png)" in text
    assert "ended differently" not in text


def test_the_same_run_but_for_times():
    summary = {"reason": "arrived", "sim_time_s": 3.0, "wall_time_s": 1.0}
    assert same_run(summary, {**summary, "wall_time_s": 2.0})
    assert not same_run(summary, {**summary, "sim_time_s": 3.1})
