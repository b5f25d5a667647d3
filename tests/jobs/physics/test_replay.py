from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import subprocess
from importlib.resources import files

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.drawing.replay.data import replay_data
from cavalcade.drawing.replay.page import replay_page, write_replay
from cavalcade.drawing.replay.track import ANGLE, FORCE, merged_contacts, skeleton_of
from cavalcade.errors import OutputError, RecordingError
from cavalcade.recording.frames import Recording
from cavalcade.recording.physics_track import ContactEvent, FallEvent

from .link_frames import foot_places, link_frames, rotations

STARTS = [(1.0, 1.0, 0.3), (1.0, 3.0, -0.3)]
GOALS = [(4.0, 2.0, 0.5), (4.0, 3.5, 2.5)]


def scenario_of(starts=STARTS, goals=GOALS, **world):
    return cv.parse_scenario(
        {
            "version": 1,
            "name": "two-go",
            "world": world or {"empty": {"size": [6, 5]}},
            "robots": [
                {"model": "go1", "start": list(start), "goal": list(goal)}
                for start, goal in zip(starts, goals, strict=True)
            ],
            "task": {"goals": "individual"},
        }
    )


@pytest.fixture
def run(trot):
    scenario = scenario_of()
    when = np.linspace(0.0, 4.0, 81)
    share = (when / 4.0)[:, None, None]
    poses = np.array(STARTS) + share * (np.array(GOALS) - np.array(STARTS))
    return scenario, cv.build_world(scenario), trot(when, poses)


def data_of(run, **changes):
    scenario, world, track = run
    return physics_data(scenario, world, dataclasses.replace(track, **changes))


def physics_data(scenario, world, track):
    return replay_data(scenario, world, recording=bare(track), summary={})


def bare(track):
    """A recording of nothing but the track."""
    none = np.zeros((0, track.size, 3))
    return Recording(
        time=np.zeros(0), poses=none, estimated=none, commands=none,
        status=(), obstacles=(), notes=(), physics=track,
    )  # fmt: skip


def unpacked(text, kind, columns=1):
    return np.frombuffer(base64.b64decode(text), kind).reshape(-1, columns).astype(float)


def decoded(said):
    """Base and joints of a robot as the page has them."""
    place = [p["low"] + p["step"] * unpacked(p["data"], "<u2")[:, 0] for p in said["place"]]
    turn = unpacked(said["turn"], "<i2", 4)
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    return np.column_stack([*place, turn]), unpacked(said["joints"], "<i2", 12) * ANGLE


def test_the_page_holds_all_and_loads_nothing(run):
    data = data_of(run)
    page = replay_page(data)
    assert not re.search(r"(src|href)\s*=|@import|https?://|fetch\(|XMLHttpRequest|url\(", page)
    assert "default-src 'none'" in page
    text = re.search(r'<script id="scene" type="application/json">(.*?)</script>', page, re.S)
    assert json.loads(text.group(1)) == json.loads(json.dumps(data))
    assert "%" not in re.sub(r"<style>.*?</style>|<script.*?</script>", "", page, flags=re.S)


def test_a_name_cannot_break_out_of_the_page(run):
    data = data_of(run)
    page = replay_page({**data, "name": "</script><b>%DATA%"})
    assert page.count("</script>") == replay_page(data).count("</script>")
    assert "<b>%DATA%" not in page


def test_a_minute_of_four_robots_is_small(trot, tmp_path):
    starts = [(1.0 + k, 1.0, 0.0) for k in range(4)]
    scenario = scenario_of(starts, [(1.0 + k, 4.0, 0.0) for k in range(4)])
    poses = np.array(starts) + np.zeros((3001, 1, 1))
    track = trot(np.linspace(0.0, 60.0, 3001), poses)
    world = cv.build_world(scenario)
    file = write_replay(tmp_path / "r.html", scenario, world, recording=bare(track), summary={})
    assert file.stat().st_size < 1_500_000
    assert list(tmp_path.iterdir()) == [file]


def test_the_motion_comes_back_closely_enough(run):
    _, _, track = run
    for k, said in enumerate(data_of(run)["robots"]):
        said = said["track"]
        base, joints = decoded(said)
        np.testing.assert_allclose(base[:, :3], track.base[:, k, :3], atol=1e-4)
        np.testing.assert_allclose(
            rotations(base[:, 3:]), rotations(track.base[:, k, 3:]), atol=2e-4
        )
        np.testing.assert_allclose(joints, track.joints[:, k], atol=ANGLE)
        forces = unpacked(said["forces"], "<i2", 12) * FORCE
        np.testing.assert_allclose(
            forces, track.foot_forces[:, k].reshape(-1, 12), atol=0.51 * FORCE
        )
        # Neighbours never lie on opposite sides: the page blends between them.
        assert (np.sum(base[1:, 3:] * base[:-1, 3:], axis=1) > 0.0).all()


def test_feet_that_stand_are_drawn_on_the_ground_and_stay_there(run):
    _, _, track = run
    data = data_of(run)
    skeleton = data["bodies"]["go1"]
    for k, said in enumerate(data["robots"]):
        feet = foot_places(skeleton, *decoded(said["track"]))
        stands = track.foot_forces[:, k, :, 2] > 1.0
        assert stands.mean() > 0.4
        assert np.abs(feet[..., 2] - skeleton["radius"])[stands].max() < 5e-4
        both = stands[1:] & stands[:-1]
        assert np.linalg.norm(np.diff(feet, axis=0), axis=2)[both].max() < 1e-3


@pytest.mark.parametrize("name", ["go1", "go2"])
def test_links_are_where_mujoco_has_them(name):
    mujoco = pytest.importorskip("mujoco")
    from cavalcade.fleet.mujoco.simulator import TeamSimulator

    model = cv.robots.robot_model(name)
    simulator = TeamSimulator([model], [(0.4, -0.2, 0.7)])
    skeleton = skeleton_of(model.description)
    rng = np.random.default_rng(0)
    names = [f"robot_0/{leg}_{joint}" for leg in ("FL", "FR", "RL", "RR")
             for joint in ("hip", "thigh", "calf")]  # fmt: skip
    for _ in range(20):
        turn = rng.normal(size=4)
        base = np.concatenate([rng.normal(size=3), turn / np.linalg.norm(turn)])
        joints = rng.uniform(-1.0, 1.0, 12)
        simulator.data.qpos[simulator.team.qpos[0]] = np.concatenate([base, joints])
        mujoco.mj_kinematics(simulator.model, simulator.data)
        place, spin = link_frames(skeleton, base[None], joints[None])
        feet = foot_places(skeleton, base[None], joints[None])[0]
        bodies = [simulator.model.joint(joint).id for joint in names]
        bodies = [int(simulator.team.trunks[0]), *simulator.model.jnt_bodyid[bodies]]
        np.testing.assert_allclose(simulator.data.xpos[bodies], place[0], atol=1e-6)
        matrices = simulator.data.xmat[bodies].reshape(-1, 3, 3)
        np.testing.assert_allclose(matrices, spin[0], atol=1e-6)
        balls = [simulator.model.geom(f"robot_0/{leg}_foot").id for leg in ("FL", "FR", "RL", "RR")]
        np.testing.assert_allclose(simulator.data.geom_xpos[balls], feet, atol=1e-6)


@pytest.mark.skipif(shutil.which("node") is None, reason="runs the page's own script")
def test_the_page_moves_links_as_python_does():
    description = cv.robots.robot_model("go1").description
    skeleton = skeleton_of(description)
    rng = np.random.default_rng(1)
    turn = rng.normal(size=4)
    base = np.concatenate([rng.normal(size=3), turn / np.linalg.norm(turn)])
    joints = rng.uniform(-1.0, 1.0, 12)
    assets = files("cavalcade.drawing.replay") / "assets"
    matrix = (assets / "matrix.js").read_text()
    motion = (assets / "motion.js").read_text()
    motion = motion[: motion.index("// The robots, each")]
    given = json.dumps([skeleton, base[:3].tolist(), base[3:].tolist(), joints.tolist()])
    script = f"{matrix}\n{motion}\nconsole.log(JSON.stringify(linksOf(...{given})));"
    said = json.loads(
        subprocess.run(["node", "-e", script], capture_output=True, check=True, timeout=60).stdout
    )
    place, spin = link_frames(skeleton, base[None], joints[None])
    np.testing.assert_allclose(said["at"], place[0], atol=1e-12)
    # The script keeps columns.
    np.testing.assert_allclose(np.swapaxes(said["turn"], 1, 2), spin[0], atol=1e-12)
    feet = foot_places(skeleton, base[None], joints[None])
    np.testing.assert_allclose(said["feet"], feet[0], atol=1e-12)


@pytest.mark.skipif(shutil.which("node") is None, reason="parses the page's own script")
def test_the_script_is_whole(run):
    page = replay_page(data_of(run))
    script = page[page.rindex("<script>") + 8 : page.rindex("</script>")]
    check = "new Function(require('fs').readFileSync(0, 'utf8'))"
    done = subprocess.run(
        ["node", "-e", check], input=script.encode(), capture_output=True, timeout=60
    )
    assert done.returncode == 0, done.stderr.decode()


def test_contacts_and_falls_are_told(run):
    contacts = (
        ContactEvent(1.0, 0, "thigh", "obstacle"),
        ContactEvent(1.2, 0, "thigh", "obstacle"),
        ContactEvent(1.2, 1, "thigh", "obstacle"),
        ContactEvent(1.6, 0, "thigh", "obstacle"),
        ContactEvent(2.5, 0, "thigh", "obstacle"),
    )
    data = data_of(run, contacts=contacts, falls=(FallEvent(3.0, 1),))
    assert data["contacts"] == [
        [1.0, 0, "thigh", "obstacle"],
        [1.2, 1, "thigh", "obstacle"],
        [2.5, 0, "thigh", "obstacle"],
    ]
    assert data["falls"] == [[3.0, 1]]
    assert ["falls", "1"] in data["facts"]
    assert ["unwanted contacts", "3"] in data["facts"]


def test_merging_contacts_loses_no_kind():
    rng = np.random.default_rng(2)
    kinds = [(r, p, o) for r in (0, 1) for p in ("trunk", "thigh") for o in ("ground", "robot 1")]
    events = tuple(
        ContactEvent(float(time), *kinds[rng.integers(len(kinds))])
        for time in np.sort(rng.uniform(0.0, 8.0, 60))
    )
    kept = merged_contacts(events)
    told = {(event.robot, event.part, event.other) for event in kept}
    assert told == {(event.robot, event.part, event.other) for event in events}
    assert set(kept) <= set(events)


def test_goals_and_ground_are_there(trot):
    scenario = scenario_of(
        [(1.0, 2.0, 0.0)], [(8.0, 2.0, 0.0)], generate={"kind": "step", "size": [9, 4], "seed": 0}
    )
    world = cv.build_world(scenario)
    assert world.terrain is not None
    when, poses = np.array([0.0, 1.0]), np.array([[(1.0, 2.0, 0.0)], [(1.4, 2.0, 0.0)]])
    track = trot(when, poses, world.terrain.heights_at)
    data = physics_data(scenario, world, track)
    assert data["robots"][0]["goal"] == [8.0, 2.0, 0.0]
    # Every node of the terrain travels: steps are where feet find them.
    assert len(data["terrain"]["x"]) == world.terrain.cols


def test_what_the_planner_wanted_is_there(run):
    scenario, world, track = run
    data = replay_data(scenario, world, recording=planned(track, scenario), summary={})
    assert np.cumsum(data["commands"]["speed"][1])[-1] == 30
    assert np.cumsum(data["commands"]["time"])[-1] == 4000
    said = data["run"]
    assert said["notes"] == [[1.0, "hello"]]
    [mover] = said["movers"]
    assert (mover["start"], mover["end"]) == (0.5, None)
    assert len(mover["fill"]) == 3 * (len(mover["ring"]) // 2 - 2)


def planned(track, scenario):
    from cavalcade.recording.frames import ObstacleTrack
    from cavalcade.recording.status import PlannerStatus

    time = np.linspace(0.0, track.time[-1], 41)
    poses = np.zeros((41, 2, 3))
    poses[..., :2] = np.stack(
        [[np.interp(time, track.time, track.base[:, k, axis]) for axis in (0, 1)] for k in (0, 1)]
    ).transpose(2, 0, 1)
    status = PlannerStatus(
        state="final", leader=0, roles=np.array([0, 1]), slots=np.zeros((0, 2)),
        goals=np.array(scenario.goals)[:, :2], goal=None,
        paths=(np.array([[1.0, 1.0], [4.0, 2.0]]), np.zeros((0, 2))),
        connections=np.zeros((0, 2), dtype=int), eta=np.array([1.0, 2.0]), arrived=False,
        waypoint=0, goal_moved=0.0, involved=(), message="", targets=np.array(scenario.goals),
    )  # fmt: skip
    ball = {"circle": {"center": [5.0, 4.0], "radius": 0.3}}
    mover = ObstacleTrack(ball, 0.5, np.inf, np.array([0.5, 1.5]), np.array([[0, 0], [0.5, 0]]))
    return Recording(
        time=time, poses=poses, estimated=poses, commands=np.full((41, 2, 3), (0.3, 0.0, 0.1)),
        status=(status,) * 41, obstacles=(mover,), notes=((1.0, "hello"),), physics=track,
    )  # fmt: skip


def test_a_long_run_is_thinned(run, monkeypatch):
    monkeypatch.setattr("cavalcade.drawing.replay.track._MOST_SAMPLES", 100)
    data = data_of(run)
    assert 2 * len(data["time"]) <= 102
    assert data["end"] == pytest.approx(4.0)


def test_a_track_of_other_robots_is_refused(run):
    scenario, world, track = run
    fewer = {
        name: getattr(track, name)[:, :1]
        for name in ("base", "joints", "joint_rates", "torques", "foot_forces")
    }
    with pytest.raises(RecordingError, match="samples of 2 robots"):
        physics_data(scenario, world, dataclasses.replace(track, **fewer))


def test_a_place_that_cannot_be_written_is_named(run, tmp_path):
    scenario, world, track = run
    with pytest.raises(OutputError, match="cannot be written"):
        write_replay(tmp_path / "no" / "r.html", scenario, world, recording=bare(track), summary={})
