from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cavalcade.errors import RecordingError
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.recording.plan_file import read_plan, write_plan


def some_path(seed: int = 0, count: int = 30) -> Trajectory:
    rng = np.random.default_rng(seed)
    return Trajectory(
        np.linspace(0.0, 1.0, count),
        rng.random((count, 3)),
        rng.random((count, 3)),
        rng.random(count),
        rng.integers(0, 4, count).astype(np.int8),
    )


def test_what_is_written_is_read_back(tmp_path):
    paths, feet = (
        [some_path(0), None, some_path(2)],
        [np.ones((3, 6)), np.zeros((0, 6))] + [np.zeros((0, 6))],
    )
    write_plan(tmp_path / "plan.npz", paths, feet)
    read, steps = read_plan(tmp_path)
    assert sorted(read) == [0, 2]
    for robot in (0, 2):
        for name in ("time", "position", "velocity", "yaw", "phase"):
            np.testing.assert_array_equal(
                getattr(read[robot], name), getattr(paths[robot], name), strict=True
            )
        np.testing.assert_array_equal(steps[robot], feet[robot])


def test_numpy_reads_it_and_the_keys_are_the_contracts(tmp_path):
    write_plan(tmp_path / "plan.npz", [some_path()], [np.zeros((2, 6))])
    with np.load(tmp_path / "plan.npz") as arrays:
        shapes = {name: arrays[name].shape for name in arrays.files}
    assert shapes == {
        "t_0": (30,),
        "position_0": (30, 3),
        "velocity_0": (30, 3),
        "yaw_0": (30,),
        "phase_0": (30,),
        "footholds_0": (2, 6),
    }


def test_the_same_plan_is_the_same_bytes_at_any_time_of_day(tmp_path, monkeypatch):
    first = write_plan(tmp_path / "a.npz", [some_path()], [np.zeros((1, 6))]).read_bytes()
    monkeypatch.setattr("time.time", lambda: 2e9)
    monkeypatch.setattr("time.localtime", lambda *_: (2033, 5, 18, 3, 33, 20, 2, 138, 0))
    second = write_plan(tmp_path / "b.npz", [some_path()], [np.zeros((1, 6))]).read_bytes()
    assert first == second
    other = write_plan(tmp_path / "c.npz", [some_path(1)], [np.zeros((1, 6))]).read_bytes()
    assert other != first


def test_nothing_is_left_of_a_plan_that_cannot_be_written(tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        write_plan(tmp_path / "plan.npz", [some_path(), some_path()], [np.zeros((1, 6))])
    assert list(tmp_path.iterdir()) == []


def test_a_missing_plan_is_said_so(tmp_path):
    with pytest.raises(RecordingError, match=r"plan\.npz: there is no such plan"):
        read_plan(tmp_path)


@given(st.binary(max_size=200))
@example(b"PK\x03\x04")
@example(b"PK\x05\x06")
def test_any_other_file_is_no_plan(tmp_path_factory, content):
    file = tmp_path_factory.mktemp("plan") / "plan.npz"
    file.write_bytes(content)
    with pytest.raises(RecordingError):
        read_plan(file)


def test_a_plan_that_lacks_an_array_is_no_plan(tmp_path):
    file = tmp_path / "plan.npz"
    with zipfile.ZipFile(file, "w") as archive:
        content = io.BytesIO()
        np.save(content, np.zeros(3))
        archive.writestr("t_0.npy", content.getvalue())
    with pytest.raises(RecordingError, match="position_0"):
        read_plan(file)
