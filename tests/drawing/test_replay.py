from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pytest

from cavalcade.drawing.replay.page import write_replay
from cavalcade.errors import OutputError


def page(run, tmp_path, **changes):
    recording = dataclasses.replace(run.recording, **changes)
    return page_of(run.scenario, run.world, recording, run.summary, tmp_path)


def page_of(scenario, world, recording, summary, tmp_path):
    path = tmp_path / "replay.html"
    file = write_replay(path, scenario, world, recording=recording, summary=summary)
    return file.read_text(encoding="utf-8")


def data_of(text):
    found = re.search(r'<script id="scene" type="application/json">(.*?)</script>', text, re.DOTALL)
    return json.loads(found[1])


def whole(steps, unit):
    return np.cumsum(steps) * unit


class Elements(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def test_a_minute_of_four_robots_is_small(make_run, tmp_path):
    text = page(make_run(cycles=1200, duration=60.0), tmp_path)
    assert len(text.encode()) < 1_500_000 / 4


def test_three_minutes_of_many_robots_are_not_big_either(make_run, tmp_path):
    text = page(make_run(cycles=1800, duration=180.0, robots=24), tmp_path)
    assert len(text.encode()) < 3_000_000


def test_the_page_needs_nothing_from_outside(run, tmp_path):
    text = page(run, tmp_path)
    elements = Elements()
    elements.feed(text)
    tags = [tag for tag, _ in elements.found]
    assert tags.count("script") == 2
    assert not {"link", "img", "iframe", "object"} & set(tags)
    assert all("src" not in attrs and "href" not in attrs for _, attrs in elements.found)
    assert re.findall(r"(?:https?:)?//[a-z]+\.", text) == []
    assert "url(" not in text
    assert "import(" not in text
    policy = next(attrs for tag, attrs in elements.found if attrs.get("http-equiv"))
    assert policy["content"].startswith("default-src 'none'")


def test_the_page_carries_the_run_exactly_enough(run, tmp_path):
    data = data_of(page(run, tmp_path))
    said = data["run"]
    assert whole(said["time"], 0.001) == pytest.approx(run.recording.time, abs=0.0006)
    for k in range(4):
        pose = said["poses"][k]
        assert whole(pose["x"], 0.001) == pytest.approx(run.recording.poses[:, k, 0], abs=0.0006)
        assert whole(pose["y"], 0.001) == pytest.approx(run.recording.poses[:, k, 1], abs=0.0006)
        turn = whole(pose["a"], 0.001) - run.recording.poses[:, k, 2]
        assert np.sin(turn) == pytest.approx(np.zeros(len(turn)), abs=0.0006)
        # Unwrapped: no step is longer than half a turn.
        assert np.abs(pose["a"][1:]).max() <= 3142
    assert data["robots"][0]["model"] == "go1"
    assert data["robots"][0]["size"][:2] == [0.65, 0.28]
    assert said["notes"] == [[12.0, "obstacle moves to (11.5, 7.0)"]]
    assert data["outcome"] == {"text": "arrived in 30.0 s", "good": True}
    assert min(sum(line[: i + 1]) for line in said["series"]["neighbour"] for i in range(9)) > 50


def test_phases_tell_who_leads_and_who_has_which_slot(run, tmp_path):
    phases = data_of(page(run, tmp_path))["run"]["phases"]
    assert [phase["leader"] for phase in phases] == [0, 1, -1, -1]
    assert phases[1]["roles"] == [1, 0, 2, 3]
    assert [phase["state"] for phase in phases[2:]] == ["final", "inactive"]
    assert [phase["arrived"] for phase in phases] == [False, False, False, True]
    times = [phase["t"] for phase in phases]
    assert times == sorted(times)


def test_goals_that_are_not_known_stay_with_their_robot(run, tmp_path):
    status = tuple(
        dataclasses.replace(one, goals=np.full((4, 2), np.nan), paths=(np.full((3, 2), np.nan),))
        for one in run.recording.status
    )
    data = data_of(page(run, tmp_path, status=status))["run"]
    assert whole(data["goals"][2][::2], 0.01) == pytest.approx(
        run.recording.poses[:, 2, 0], abs=0.006
    )
    assert data["paths"]["lines"][0] == [[]]


def test_a_lost_robot_is_marked(run, tmp_path):
    status = tuple(
        dataclasses.replace(one, roles=np.array([0, 1, -1, 2])) for one in run.recording.status
    )
    phases = data_of(page(run, tmp_path, status=status))["run"]["phases"]
    assert phases[0]["lost"] == [0, 0, 1, 0]


def test_text_from_outside_cannot_leave_its_place(run, tmp_path):
    nasty = "</script><script>alert(1)</script>%DATA% & \u2028 <!--"
    scenario = run.scenario.model_copy(update={"name": nasty})
    recording = dataclasses.replace(run.recording, notes=((1.0, nasty),))
    text = page_of(scenario, run.world, recording, run.summary, tmp_path)
    assert text.count("<script") == 2
    assert data_of(text)["name"] == nasty
    assert data_of(text)["run"]["notes"] == [[1.0, nasty]]


def test_unreachable_goals_and_missing_numbers_are_null_not_nan(run, tmp_path):
    status = tuple(
        dataclasses.replace(one, eta=np.full(4, np.inf), goal=None, paths=())
        for one in run.recording.status
    )
    bare = {"success": False, "reason": "stuck", "makespan_s": None, "collisions": None}
    recording = dataclasses.replace(run.recording, status=status)
    data = data_of(page_of(run.scenario, run.world, recording, bare, tmp_path))
    assert set(data["run"]["paths"]["eta"]) == {None}
    assert data["outcome"] == {"text": "stuck", "good": False}
    assert data["facts"] == []


@pytest.mark.parametrize(("robots", "cycles"), [(1, 30), (2, 2), (3, 1)])
def test_small_runs(make_run, tmp_path, robots, cycles):
    run = make_run(cycles=30, robots=robots)
    text = page(
        run,
        tmp_path,
        time=run.recording.time[:cycles],
        poses=run.recording.poses[:cycles],
        status=run.recording.status[:cycles],
    )
    assert len(data_of(text)["robots"]) == robots


def test_the_same_run_gives_the_same_page(run, tmp_path):
    assert page(run, tmp_path) == page(run, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["replay.html"]


def test_a_place_that_cannot_be_written_is_named(run, tmp_path):
    with pytest.raises(OutputError, match="missing"):
        page(run, tmp_path / "missing")


@pytest.mark.skipif(shutil.which("node") is None, reason="runs the page's own script")
@pytest.mark.parametrize("begin", [0.0, 2.5])
def test_the_clock_went_below_zero(tmp_path, begin):
    """The first frame may be of a moment before the click that starts it."""
    clock = (files("cavalcade.drawing.replay") / "assets" / "clock.js").read_text()
    script = f"""
    const begin = {begin}, end = 9.0, nodes = {{}};
    const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
    const id = (name) => nodes[name] ??= {{
      value: "0", style: {{}}, addEventListener() {{}}, setAttribute() {{}}, append() {{}},
    }};
    const window = {{ devicePixelRatio: 1 }}, location = {{ hash: "" }};
    const performance = {{ now: () => 1000 }}, requestAnimationFrame = () => 0, draw = () => 0;
    class Option {{}}
    {clock}
    const shown = [];
    setPlaying(true);
    for (const when of [980, 900, 1100, 1050, 1200, 99999]) {{ frame(when); shown.push(now); }}
    console.log(JSON.stringify([shown, nodes.clock.innerHTML]));
    """
    path = tmp_path / "clock.js"
    path.write_text(script, encoding="utf-8")
    done = subprocess.run(["node", path], capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr.decode()
    shown, said = json.loads(done.stdout)
    assert shown == pytest.approx([begin + t for t in (0.0, 0.0, 0.1, 0.1, 0.2, 0.3)])
    assert f"{begin + 0.3:.2f}" in said


@pytest.mark.skipif(shutil.which("node") is None, reason="runs the page's own script")
def test_feet_under_recorded_poses_stay_where_they_stand(run, tmp_path):
    assets = files("cavalcade.drawing.replay") / "assets"
    text = json.dumps(json.dumps(data_of(page(run, tmp_path))))
    script = f"""
    const node = {{ textContent: {text}, classList: {{ add() {{}} }}, append() {{}} }};
    const document = {{ getElementById: () => node, createElement: () => ({{}}) }};
    {"".join((assets / name).read_text() for name in ("data.js", "matrix.js", "motion.js"))}
    const moments = Array.from({{ length: 601 }}, (_, k) => begin + k / 600 * (end - begin));
    const feet = (time) => robots.map((robot) => [0, 1, 2, 3].map((leg) => {{
      const state = stateAt(robot, time), foot = footAt(robot, leg, time, state);
      return [...foot.at, foot.stands ? 1 : 0, ...state.place];
    }}));
    console.log(JSON.stringify(moments.map(feet)));
    """
    path = tmp_path / "feet.js"
    path.write_text(script, encoding="utf-8")
    done = subprocess.run(["node", path], capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr.decode()
    said = np.array(json.loads(done.stdout))
    place, stands, body = said[..., :3], said[..., 3] == 1, said[..., 4:]
    assert (stands.sum(axis=2) >= 2).all()
    assert (~stands).any(axis=(0, 1)).all()
    both = stands[1:] & stands[:-1]
    moved = np.linalg.norm(np.diff(place, axis=0), axis=3)
    # Two samples of a foot that stands are of one step, or a whole stride apart.
    assert ((moved[both] < 1e-9) | (moved[both] > 0.1)).mean() > 0.999
    assert np.median(moved[both]) == 0.0
    assert np.linalg.norm((place - body)[..., :2], axis=3).max() < 0.45
    assert (place[..., 2] >= -1e-9).all()
    assert place[stands][:, 2] == pytest.approx(0.0)
