"""Folders of `plan` on disk: sound, tampered with, damaged."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pytest
import yaml

from cavalcade.checking import check
from cavalcade.checking.tracks import Track
from cavalcade.cli import main
from cavalcade.errors import RecordingError


def write(judged, folder):
    folder.mkdir()
    (folder / "scenario.yaml").write_text(yaml.safe_dump(judged.words))
    (folder / "summary.json").write_text(json.dumps(judged.summary))
    np.savez(folder / "plan.npz", **judged.arrays)
    return folder


@pytest.fixture
def folder(walker, tmp_path):
    return write(walker, tmp_path / "plan")


def exit_code(*arguments):
    return main([str(argument) for argument in arguments])


def test_a_sound_folder(folder, capsys):
    assert check(folder).ok
    assert exit_code("check", folder) == 0
    assert "clean" in capsys.readouterr().out


def test_a_fault_is_told_in_one_line(leaper, tmp_path, capsys):
    leaper.arrays["velocity_0"][leaper.arrays["phase_0"] == 2, 2] += 0.5
    folder = write(leaper, tmp_path / "plan")
    assert exit_code("check", folder) == 1
    (line,) = capsys.readouterr().out.splitlines()
    assert "robot 0" in line


@pytest.mark.parametrize("name", ["scenario.yaml", "summary.json", "plan.npz"])
def test_a_missing_file_is_named(folder, name, capsys):
    (folder / name).unlink()
    with pytest.raises(RecordingError):
        check(folder)
    assert exit_code("check", folder) == 2
    captured = capsys.readouterr()
    assert name in captured.err
    assert len(captured.err.splitlines()) == 1


@pytest.mark.parametrize("content", [b"", b"\x00\xff rubbish", b"PK\x03\x04 and no more"])
def test_rubbish_is_named(folder, content, capsys):
    (folder / "plan.npz").write_bytes(content)
    with pytest.raises(RecordingError, match=r"plan\.npz"):
        check(folder)
    assert exit_code("check", folder) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 0.99])
def test_a_truncated_plan(folder, part):
    file = folder / "plan.npz"
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    with pytest.raises(RecordingError, match=r"plan\.npz"):
        check(folder)


def test_a_damaged_plan_is_no_traceback(folder):
    file = folder / "plan.npz"
    content = bytearray(file.read_bytes())
    rng = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(content)
        for place in rng.integers(0, len(content), 5):
            damaged[place] = rng.integers(256)
        file.write_bytes(damaged)
        with contextlib.suppress(RecordingError):
            check(folder)


def test_objects_are_not_unpacked(folder):
    np.savez(folder / "plan.npz", t_0=np.array([{"a": 1}], dtype=object))
    with pytest.raises(RecordingError, match=r"plan\.npz"):
        check(folder)


def test_a_plan_of_a_formation(folder):
    content = yaml.safe_load((folder / "scenario.yaml").read_text())
    del content["robots"][0]["goal"]
    content["task"] = {
        "formation": {"shape": "column", "spacing": 1.0},
        "goals": [[8.0, 5.0, 0.0]],
    }
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(RecordingError, match="has a formation"):
        check(folder)


def test_a_verdict_is_plain_data(leaper, tmp_path, capsys):
    leaper.arrays["phase_0"][leaper.arrays["phase_0"] == 2] = 0
    leaper.arrays["footholds_0"][3, 2] = 7
    leaper.summary["makespan_s"] = None
    folder = write(leaper, tmp_path / "plan")
    assert exit_code("check", folder, "--json") == 1
    told = json.loads(capsys.readouterr().out)
    assert {"phase", "foothold", "summary"} <= {v["kind"] for v in told["violations"]}


def test_a_run_that_carried_out_a_plan_is_judged_as_both(leaper, tmp_path, recorder):
    leaper.summary |= {"path_length_m": [0.0], "duration_s": [None]}  # those of the run
    folder = write(leaper, tmp_path / "run")
    arrays = leaper.arrays
    poses = np.column_stack((arrays["position_0"][:, :2], arrays["yaw_0"]))
    rest = arrays["t_0"][-1] + 0.03 * np.arange(1, 30)
    time = np.concatenate((arrays["t_0"], rest))
    track = Track(time, np.concatenate((poses, np.repeat(poses[-1:], len(rest), axis=0))))
    recorder(folder / "recording.mcap", [track])
    report = check(folder)
    assert report.violations == ()
    assert report.figures.duration_s == pytest.approx(time[-1])

    arrays["velocity_0"][arrays["phase_0"] == 2, 2] += 0.5
    np.savez(folder / "plan.npz", **arrays)
    assert {"ballistics", "dynamics"} <= {v.kind for v in check(folder).violations}

    track.pose[100:, 1] += 0.3
    recorder(folder / "recording.mcap", [track])
    assert "speed" in {v.kind for v in check(folder).violations}
