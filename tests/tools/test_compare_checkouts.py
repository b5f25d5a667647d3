"""The comparison of two checkouts finds what differs, and names it."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

TOOLS = Path(__file__).parents[2] / "tools"
sys.path.insert(0, str(TOOLS))

from comparing.benchmarks import BENCHMARKS, FailedError, figures, overall, ratios  # noqa: E402
from comparing.checkout import Done, Processes, StoppedError  # noqa: E402
from comparing.folders import Side, compare_folders  # noqa: E402
from comparing.intended import INTENDED, ChangedText, ChangedValue, RenamedKey  # noqa: E402
from comparing.worlds import OBSTACLES, TERRAINS, write_worlds  # noqa: E402

POSE, TWIST = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/TwistStamped"
SUMMARY = {
    "success": True,
    "wall_time_s": 1.0,
    "cycle_ms": {"p50": 0.5, "p99": None},
    "leader_changes": 2,
    "path_length_m": [5.0, 5.5],
    "versions": {"numpy": "2.0"},
}
SCENARIO = {
    "world": {"map": "map.yaml"},
    "robots": [{"model": "go1", "start": [1.0, 2.0, 0.0]}],
    "planner": {"method": "auto", "conflict": "costly"},
}
LINE = {"trial": "a.0000.cbs", "outcome": "solved", "summary": SUMMARY, "measured": {}}


@pytest.fixture
def sides(tmp_path):
    """Two folders of the same run, each in a checkout of its own."""
    return [_left(tmp_path / name, seconds) for name, seconds in (("old", 1.0), ("new", 2.0))]


def _left(root, seconds):
    folder = root / "results" / "run"
    (folder / "figures").mkdir(parents=True)
    (folder / "figures" / "sequence.png").write_bytes(str(seconds).encode())
    (folder / "replay.html").write_text(f"<p>{seconds}</p>")
    (root / "map.yaml").write_text("")
    _write_json(folder / "summary.json", {**SUMMARY, "wall_time_s": seconds})
    world = {"map": "../../map.yaml" if seconds == 1.0 else str(root / "map.yaml")}
    (folder / "scenario.yaml").write_text(
        yaml.safe_dump({**SCENARIO, "world": world}, sort_keys=False)
    )
    np.savez(folder / "plan.npz", t_0=np.linspace(0.0, 1.0, 7), phase_0=np.zeros(7, np.int8))
    _write_recording(folder, [0.25, 0.5])
    (folder / "trials.jsonl").write_text(json.dumps(LINE) + "\n")
    _write_table(folder / "trials.parquet", "cycle_ms.p50", seconds, contacts=0)
    said = {"exit_code": 0, "stdout": [], "stderr": [f"cavalcade: {folder}: warning"]}
    _write_json(folder.parent / "run.said.json", said)
    return Side(folder.parent, ((root, "<checkout>"),))


def _write_json(file, tree):
    file.write_text(json.dumps(tree))


def _write_recording(folder, places, topics=("/robot_0/pose", "/robot_0/cmd_vel")):
    from rosbags.rosbag2 import StoragePlugin, Writer

    target = folder / "recording.mcap"
    target.unlink(missing_ok=True)
    bag = folder / "bag"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, kind, count in zip(topics, (POSE, TWIST), (7, 6), strict=True):
            connection = writer.add_connection(topic, kind, msgdef="float64 x", rihs01="RIHS01_0")
            for step, place in enumerate(places):
                numbers = np.zeros(count)
                numbers[0] = place
                writer.write(connection, step * 50_000_000, b"\0\1\0\0" + numbers.tobytes())
    (bag / "bag.mcap").rename(target)
    (bag / "metadata.yaml").unlink()
    bag.rmdir()


def _write_table(file, column, seconds, contacts):
    import duckdb

    rows = f'SELECT {seconds} AS "{column}", {contacts} AS contacts'
    duckdb.sql(f"COPY ({rows}) TO '{file}' (FORMAT parquet)")


def _change(file, tree):
    """A file of plain data with some keys replaced."""
    known = yaml.safe_load(file.read_text())
    _write_json(file, {**known, **tree})


def _found(sides, *changes):
    return [str(difference) for difference in compare_folders(*sides, changes)]


def test_equal_but_for_times_pictures_and_places(sides):
    assert _found(sides) == []


def test_a_changed_number_is_named(sides):
    _change(sides[1].folder / "run/summary.json", {"leader_changes": 3})
    assert _found(sides) == ["run/summary.json: leader_changes: 2 -> 3"]


@pytest.mark.parametrize(
    ("tree", "said"),
    [
        ({"path_length_m": [5.0, 5.500000000000001]}, "path_length_m[1]: 5.5 -> 5.500000000000001"),
        ({"path_length_m": [5.0]}, "path_length_m[1]: 5.5 -> missing"),
        ({"path_length_m": [5, 5.5]}, "path_length_m[0]: 5.0 -> 5"),
        ({"leader_changes": None}, "leader_changes: 2 -> None"),
        (
            {"cycle_ms": {"p50": 3.0, "p99": 4.0}},
            "cycle_ms.p99: None -> '<differs from run to run>'",
        ),
        ({"falls": 1}, "falls: missing -> 1"),
    ],
)
def test_what_changed_in_a_summary_is_named(sides, tree, said):
    _change(sides[1].folder / "run/summary.json", tree)
    assert _found(sides) == [f"run/summary.json: {said}"]


def test_keys_in_another_order_are_found(sides):
    _write_json(sides[1].folder / "run/summary.json", dict(reversed(SUMMARY.items())))
    (found,) = _found(sides)
    assert "order of keys" in found


def test_negative_zero_is_another_number(sides):
    for side, zero in zip(sides, (0.0, -0.0), strict=True):
        _change(side.folder / "run/summary.json", {"path_length_m": [zero]})
    assert _found(sides) == ["run/summary.json: path_length_m[0]: 0.0 -> -0.0"]


def test_an_array_off_by_one_ulp_is_named(sides):
    time = np.linspace(0.0, 1.0, 7)
    time[3] = np.nextafter(time[3], 1.0)
    np.savez(sides[1].folder / "run/plan.npz", t_0=time, phase_0=np.zeros(7, np.int8))
    (found,) = _found(sides)
    assert found == "run/plan.npz: t_0[3]: 0.5 -> 0.5000000000000001 (1 of 7 elements)"


def test_an_array_of_another_kind_or_name_is_named(sides):
    np.savez(sides[1].folder / "run/plan.npz", t_0=np.linspace(0, 1, 7), phases=np.zeros(7))
    assert [line.split(": ")[1] for line in _found(sides)] == ["phase_0", "phases"]
    np.savez(sides[1].folder / "run/plan.npz", t_0=np.linspace(0, 1, 7), phase_0=np.zeros(7))
    assert _found(sides) == ["run/plan.npz: phase_0: int8[7] -> float64[7]"]


def test_a_pose_off_by_one_bit_is_named(sides):
    _write_recording(sides[1].folder / "run", [0.25, np.nextafter(0.5, 1.0)])
    poses, commands = _found(sides)
    place = "message 1 at 0.050 s"
    values = "0.5 -> 0.5000000000000001"
    assert poses == f"run/recording.mcap: /robot_0/pose {place}: x: {values}"
    assert commands == f"run/recording.mcap: /robot_0/cmd_vel {place}: vx: {values}"


def test_a_missing_message_and_a_missing_topic_are_named(sides):
    _write_recording(sides[1].folder / "run", [0.25])
    assert "/robot_0/pose messages: 2 -> 1" in _found(sides)[0]
    _write_recording(sides[1].folder / "run", [0.25, 0.5], ("/robot_0/pose", "/robot_0/cmd"))
    assert [line.split(": ", 1)[1] for line in _found(sides)] == [
        f"/robot_0/cmd_vel: {TWIST} -> missing",
        f"/robot_0/cmd: missing -> {TWIST}",
    ]


def test_topics_that_are_gone_on_purpose_are_accepted(sides):
    _write_recording(sides[1].folder / "run", [0.25, 0.5], ("/robot_0/pose", "/robot_0/cmd"))
    changes = [
        RenamedKey("*.mcap", "/robot_0/cmd_vel", "", "nobody read it"),
        RenamedKey("*.mcap", "", "/robot_0/cmd", "somebody asked for it"),
    ]
    assert _found(sides, *changes) == []


def test_missing_files_messages_and_exit_codes_are_named(sides):
    (sides[1].folder / "run/replay.html").unlink()
    _change(sides[1].folder / "run.said.json", {"exit_code": 1})
    _change(sides[0].folder / "run.said.json", {"stderr": []})
    assert _found(sides) == [
        "run/replay.html: there -> missing",
        "run.said.json: exit_code: 0 -> 1",
        "run.said.json: stderr[0]: missing -> 'cavalcade: <checkout>/results/run: warning'",
    ]


def test_tables_and_lines_are_compared_by_their_content(sides):
    _write_table(sides[1].folder / "run/trials.parquet", "cycle_ms.p50", 3.0, contacts=1)
    line = {**LINE, "outcome": "infeasible"}
    (sides[1].folder / "run/trials.jsonl").write_text(json.dumps(line) + "\n")
    assert _found(sides) == [
        "run/trials.jsonl: a.0000.cbs.outcome: 'solved' -> 'infeasible'",
        "run/trials.parquet: contacts.values[0]: 0 -> 1",
    ]


def test_nothing_is_intended_unless_it_is_listed_with_a_reason():
    assert all(change.why and change.where for change in INTENDED)


def test_renamed_keys_are_accepted_where_they_are_intended(sides):
    new = sides[1].folder / "run"
    tree = yaml.safe_load((new / "scenario.yaml").read_text())
    tree["robots"] = [{"type": "go1", "start": [1.0, 2.0, 0.0]}]
    tree["planner"] = {"method": "auto", "conflict_order": "costly"}
    (new / "scenario.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))
    assert len(_found(sides)) == 4
    changes = [
        RenamedKey("*scenario.yaml", "robots.*.model", "robots.*.type", "a better word"),
        RenamedKey("*.yaml", "planner.conflict", "planner.conflict_order", "a better word"),
    ]
    assert _found(sides, *changes) == []
    elsewhere = [replace(change, where="*summary.json") for change in changes]
    assert len(_found(sides, *elsewhere)) == 4


def test_other_intended_changes_are_accepted(sides):
    new = sides[1].folder / "run"
    _write_table(new / "trials.parquet", "cycle_ms.median", 3.0, contacts=0)
    np.savez(new / "plan.npz", time_0=np.linspace(0, 1, 7), phase_0=np.zeros(7, np.int8))
    _write_recording(new, [0.25, 0.5], ("/robot_0/pose", "/robot_0/command"))
    _change(new / "summary.json", {"success": "yes", "falls": 0})
    said = json.loads((sides[0].folder / "run.said.json").read_text())["stderr"]
    news = [said[0].replace("warning", "note").replace("/old/", "/new/"), "warning: old word"]
    _change(sides[1].folder / "run.said.json", {"stderr": news})
    why = "on purpose"
    changes = [
        RenamedKey("*.parquet", "cycle_ms.p50", "cycle_ms.median", why),
        RenamedKey("*.npz", "t_0", "time_0", why),
        RenamedKey("*.mcap", "/robot_0/cmd_vel", "/robot_0/command", why),
        RenamedKey("*/summary.json", "", "falls", why),
        ChangedValue("*/summary.json", "success", True, "yes", why),
        ChangedText("*.said.json", r"warning$", "note", why),
        ChangedText("*.said.json", "", "warning: .*", why),
    ]
    assert _found(sides, *changes) == []
    for left_out in range(len(changes)):
        assert _found(sides, *changes[:left_out], *changes[left_out + 1 :])


def test_generated_worlds_are_the_same_again_and_of_every_kind(tmp_path):
    once, again = (write_worlds(tmp_path / name, 19, seed=3) for name in ("a", "b"))
    assert [file.read_bytes() for file in once] == [file.read_bytes() for file in again]
    kinds = set()
    for file in once:
        world = yaml.safe_load(file.read_text())["world"]
        kinds.add(world["generate"]["kind"] if "generate" in world else "empty")
    assert kinds == {*OBSTACLES, *TERRAINS, "empty"}


# The older checkout knows only the old spellings.
@pytest.mark.filterwarnings("ignore::cavalcade.scenario.spellings.RenamedWarning")
def test_generated_worlds_are_valid(tmp_path):
    from cavalcade.scenario import build_world, load_scenario

    for file in write_worlds(tmp_path, 38, seed=0):
        build_world(load_scenario(file))


SAYS = {
    "cycle": ("4 robots on 280 x 200 cells, 670 cycles (arrived): median 2.04 ms, p99", 0.00204),
    "eikonal": (
        "   280 x  200, 74% of the cells reached: scikit-fmm    25.51 ms, cavalcade    2.99 ms, x",
        0.00299,
    ),
    "body": ("A leap with its checks, gap: 14.40 us (28% valid; at most", 1.44e-5),
    "mpc": ("trot, calm       12.3 ( 14.7)   43.1 ( 49.3)   29.9", 1.23e-5),
    "physics-plant": ("| 4 | 10 |", 0.1),
    "startup": ("  compiled: moves after 1.25 s (median of 5)", 1.25),
    "campaign": ("nothing of the kind", 7.0),
}


@pytest.mark.parametrize("name", SAYS)
def test_figures_of_benchmarks_are_read(name):
    benchmark = next(one for one in BENCHMARKS if one.name == name)
    text, value = SAYS[name]
    found = figures(benchmark, Done(0, 7.0, 9.0, f"Some words\n{text}\n", ""))
    assert list(found.values()) == pytest.approx([value])


def test_benchmarks_are_compared_by_their_best():
    old = [{"a": 1.0, "b": 2.0}, {"a": 3.0, "b": 2.0}, {"a": 2.0, "b": 2.0}]
    found = list(ratios(old, [{"a": 1.02, "b": 1.9}, {"a": 9.0, "b": 9.0}]))
    assert [ratio.best for ratio in found] == pytest.approx([1.0 / 1.02, 2.0 / 1.9])
    assert found[0].median == pytest.approx(2.0 / 5.01)
    assert overall(found) == pytest.approx((2.0 / 1.9 / 1.02) ** 0.5)
    assert "below" in str(next(ratios([{"a": 1.0}], [{"a": 1.04}])))
    with pytest.raises(FailedError):
        list(ratios([{"a": 1.0}], [{"b": 1.0}]))


def test_commands_are_ended_and_counted(tmp_path):
    processes = Processes()
    done = processes.run([sys.executable, "-c", "print(1); raise SystemExit(3)"], tmp_path, {}, 60)
    assert (done.code, done.out) == (3, "1\n")
    assert done.cpu > 0.0
    late = processes.run(["sleep", "60"], tmp_path, {"PATH": "/usr/bin:/bin"}, 0.1)
    assert late.code < 0
    processes.stop()
    with pytest.raises(StoppedError):
        processes.run(["true"], tmp_path, {}, 1.0)


def test_a_checkout_that_is_none_is_refused(tmp_path):
    done = subprocess.run(
        [sys.executable, str(TOOLS / "compare_checkouts.py"), str(tmp_path), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "--python-old" in done.stderr
    assert len(done.stderr.splitlines()) == 1
