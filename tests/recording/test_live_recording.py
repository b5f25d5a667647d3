"""Recordings that are written while the run goes on: killed, cut off, on a full disk."""

from __future__ import annotations

import gc
import os
import resource
import signal
import struct
import subprocess
import sys
import threading
import time
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader

from cavalcade.errors import OutputError, RecordingError
from cavalcade.mcap_framing import ENDING, readable
from cavalcade.recording import live_writer
from cavalcade.recording.frames import Recorder, Recording
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.mcap_reader import read_recording
from cavalcade.recording.mcap_writer import write_recording

from .live_frames import AREA, MODELS, ROBOTS, a_frame


@pytest.fixture(autouse=True)
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many chunks in a short time."""
    monkeypatch.setattr(live_writer, "PERIOD", 0.02)


def recorded(path: Path, count: int, pause: float = 0.0) -> Path:
    with LiveRecording(path, MODELS) as recording:
        for k in range(count):
            recording(a_frame(k))
            time.sleep(pause)
    assert recording.problem == ""
    return path


def read_cut_off(path: Path) -> Recording:
    with pytest.warns(UserWarning, match="the end of this recording is missing; read up to"):
        back = read_recording(path)
    assert not back.ended
    return back


def messages_of(path: Path) -> list[tuple[str, int, bytes]]:
    with Reader(path) as reader:
        return [(c.topic, t, bytes(data)) for c, t, data in reader.messages()]


def wait_until(condition, limit: float = 30.0) -> None:  # type: ignore[no-untyped-def]
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_the_same_messages_as_those_of_a_whole_run(tmp_path: Path) -> None:
    """Piece by piece or at once: the same messages in the same order, byte by byte."""
    live = recorded(tmp_path / "live.mcap", 150, pause=0.002)
    recorder = Recorder()
    for k in range(150):
        recorder(a_frame(k))
    whole = write_recording(tmp_path / "w.mcap", recorder.recording(), MODELS, recorder.maps)
    assert messages_of(live) == messages_of(whole)
    assert live.read_bytes().count(b"zstd") > 2 * whole.read_bytes().count(b"zstd")  # chunks
    back = read_recording(live)
    assert back.ended
    assert len(back.time) == 150
    assert back.notes == tuple((2.5 * k, f"goal {50 * k}") for k in range(3))


def test_a_killed_process_leaves_what_happened_until_then(tmp_path: Path) -> None:
    path, rate = tmp_path / "recording.mcap", 50.0
    command = [sys.executable, "-m", "tests.recording.live_frames", str(path), str(rate)]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        cwd=Path(__file__).parents[2],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        text=True,
    ) as process:
        assert process.stdout is not None
        written = 0
        while written < 2.5 * rate:
            written = int(process.stdout.readline().split()[0])
        process.send_signal(signal.SIGKILL)
        rest = [int(line.split()[0]) for line in process.stdout if " " in line]
        written = max(written, *rest, 0)
    with Reader(path) as reader:  # as it lies there, by a reader that is not ours
        assert reader.message_count > 0
    back = read_cut_off(path)
    assert len(back.time) >= written - 1.0 * rate
    assert np.array_equal(np.diff(back.time).round(9), np.full(len(back.time) - 1, 0.02))
    assert (0.0, "recording: robot 0 is a, robot 1 is b, robot 2 is c") in back.notes
    assert (0.0, "goal 0") in back.notes


def test_the_file_is_whole_while_it_grows(tmp_path: Path) -> None:
    path = tmp_path / "r.mcap"
    recording = LiveRecording(path, MODELS)
    with pytest.raises(RecordingError, match="its end is missing, and nothing before it is whole"):
        read_recording(path)
    for k in range(5):
        for n in range(20):
            recording(a_frame(20 * k + n))
        wait_until(lambda: not recording._waiting.qsize())
        size = path.stat().st_size
        wait_until(lambda size=size: path.stat().st_size >= size and path.stat().st_size > 1000)
        assert path.read_bytes().endswith(ENDING)
        read_cut_off(path)
    recording.close()
    recording.close()
    assert len(read_recording(path).time) == 100


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, int]:
    """A finished file, and where its first chunk ends."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(live_writer, "PERIOD", 0.02)
        path = recorded(tmp_path_factory.mktemp("live") / "r.mcap", 60, pause=0.002)
    data = path.read_bytes()
    place = 8
    while data[place] != 6:
        place += 9 + struct.unpack_from("<Q", data, place + 1)[0]
    return data, place + 9 + struct.unpack_from("<Q", data, place + 1)[0]


def borders(data: bytes) -> list[int]:
    """Where records begin."""
    found, place = [8], 8
    while place + 9 <= len(data) - 8:
        place += 9 + struct.unpack_from("<Q", data, place + 1)[0]
        found.append(place)
    return found


def check_cut(data: bytes, cut: int, first: int, path: Path) -> int:
    """How many cycles are read; nothing but a RecordingError is raised."""
    path.write_bytes(data[:cut])
    if cut < first:
        with pytest.raises(RecordingError, match=r"cut\.mcap"):
            read_recording(path)
        return 0
    back = read_cut_off(path)
    assert np.allclose(back.time, 0.05 * np.arange(len(back.time)))
    assert back.poses.shape == (len(back.time), ROBOTS, 3)
    if len(back.time):
        assert np.allclose(back.poses[-1], a_frame(len(back.time) - 1).poses)
    return len(back.time)


def test_files_cut_at_and_beside_every_record(finished: tuple[bytes, int], tmp_path: Path) -> None:
    data, first = finished
    counts = []
    # Of the indices of chunks' topics, which are many, a few; everything else.
    places = borders(data)
    for place in [p for k, p in enumerate(places) if data[p] not in (7, 8) or k % 40 == 0]:
        for cut in (place - 1, place, place + 1, place + 8, place + 9, place + 10):
            if 0 <= cut < len(data):
                counts.append((cut, check_cut(data, cut, first, tmp_path / "cut.mcap")))
    counts.sort()
    assert [count for _, count in counts] == sorted(count for _, count in counts)
    assert counts[-1][1] == 60


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_files_cut_anywhere(
    finished: tuple[bytes, int], tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    data, first = finished
    folder = tmp_path_factory.mktemp("cut")
    check_cut(data, int(share * len(data)), first, folder / "cut.mcap")


def test_zeros_at_the_end_were_taken_for_records(finished: tuple[bytes, int], tmp_path: Path):
    """A failure of power leaves blocks that were never written."""
    data, first = finished
    path = tmp_path / "recording.mcap"
    path.write_bytes(data[: first + 500] + bytes(5000))
    assert len(read_cut_off(path).time) > 0


def test_a_cut_in_the_midst_of_a_cycle_leaves_whole_cycles(tmp_path: Path) -> None:
    """`write_recording` splits chunks anywhere."""
    recorder = Recorder()
    for k in range(1200):
        recorder(a_frame(k))
    file = write_recording(tmp_path / "r.mcap", recorder.recording(), MODELS)
    data = file.read_bytes()
    chunks = [place for place in borders(data) if data[place] == 6]
    assert len(chunks) > 1
    file.write_bytes(data[: chunks[-1]])
    back = read_cut_off(file)
    assert 100 < len(back.time) < 1200
    assert np.isfinite(back.poses[-1]).all()


def test_copies_are_cleaned_up(finished: tuple[bytes, int], tmp_path: Path) -> None:
    path = tmp_path / "recording.mcap"
    path.write_bytes(finished[0][:-100])
    with readable(path) as (copy, ended):
        assert not ended
        assert copy != path
    assert not copy.exists()


def limited(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def test_a_full_disk_is_a_note_and_the_run_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "recording.mcap"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    recording, k = LiveRecording(path, MODELS), 0

    def feed(count: int) -> None:
        nonlocal k
        for _ in range(count):
            recording(a_frame(k))
            k += 1
            time.sleep(0.001)

    try:
        feed(60)
        wait_until(lambda: path.stat().st_size > 3000)
        limited(path.stat().st_size)
        full_from = k
        while not recording.problem:
            feed(10)
        assert "cannot be written: File too large" in recording.problem
        assert len(read_cut_off(path).time) >= 1  # whole, as it was
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    while recording.problem:
        feed(10)
    feed(60)
    recording.close()
    back = read_recording(path)
    assert back.ended
    told = [text for _, text in back.notes if "what happened before is missing" in text]
    assert told
    assert "File too large" in told[0]
    assert back.time[-1] == pytest.approx(0.05 * (k - 1))
    assert full_from - 60 < len(back.time) < k
    # Whatever was left out, each status is that of its cycle.
    for time_, status in zip(back.time, back.status, strict=True):
        wanted = a_frame(round(time_ / 0.05)).status
        assert status.leader == wanted.leader
        assert np.allclose(status.goals, wanted.goals, atol=1e-6)


def test_a_disk_full_from_the_start(tmp_path: Path) -> None:
    """The topics are told as soon as there is room."""
    path = tmp_path / "recording.mcap"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    recording = LiveRecording(path, MODELS)
    try:
        limited(path.stat().st_size + 200)
        recording(a_frame(0))
        wait_until(lambda: bool(recording.problem))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    for k in range(1, 30):
        recording(a_frame(k))
    recording.close()
    assert recording.problem == ""
    back = read_recording(path)
    assert len(back.time) == 29
    assert "missing" in back.notes[0][1]


def test_a_disk_that_stays_full_is_told_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / "recording.mcap"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    recording = LiveRecording(path, MODELS)
    try:
        recording(a_frame(0))
        wait_until(lambda: path.stat().st_size > 1000)
        limited(path.stat().st_size)
        recording.note("the last word")
        recording.close()
        assert "File too large" in recording.problem
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert len(read_cut_off(path).time) == 1


def test_calls_never_wait_for_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that hangs costs frames, never time; what is missing is told."""
    hang, pwrite = threading.Event(), os.pwrite

    def slow(*args: int | bytes) -> int:
        hang.wait()
        return pwrite(*args)  # type: ignore[arg-type]

    recording = LiveRecording(tmp_path / "r.mcap", MODELS)
    monkeypatch.setattr(os, "pwrite", slow)
    frames = [a_frame(k) for k in range(3000)]
    start = time.perf_counter()
    for frame in frames:
        recording(frame)
    assert time.perf_counter() - start < 2.0
    assert recording._waiting.qsize() <= 600
    hang.set()
    recording.close()
    back = read_recording(tmp_path / "r.mcap")
    (missing,) = (text for _, text in back.notes if "are missing" in text)
    assert int(missing.split()[1]) + len(back.time) == 3000


def test_memory_stays_flat(tmp_path: Path) -> None:
    """Minutes at 20 Hz as fast as they go: what is kept is the index of chunks."""
    recording = LiveRecording(tmp_path / "r.mcap", MODELS)

    def feed(first: int, count: int) -> int:
        for k in range(first, first + count):
            recording(a_frame(k))
            if k % 100 == 0:
                wait_until(lambda: not recording._waiting.qsize())
        wait_until(lambda: not recording._waiting.qsize())
        gc.collect()  # what goes round in circles is taken away when enough has come together
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        early = feed(0, 1000)
        late = feed(1000, 3000)
    finally:
        tracemalloc.stop()
        recording.close()
    assert late - early < 3e5


def test_clocks_that_stand_still_or_go_back(tmp_path: Path) -> None:
    path = tmp_path / "recording.mcap"
    with LiveRecording(path, MODELS) as recording:
        for k in (0, 1, 2, 2, 3, 1, 2, 100):
            recording(a_frame(k))
    back = read_recording(path)
    assert len(back.time) == 8
    assert (np.diff(back.time) > 0.0).all()
    assert back.time[0] == 0.0
    told = [text for _, text in back.notes if "stood still or went back" in text]
    assert len(told) == 2
    assert "went back to 0.050 s" in told[1]


def test_poses_that_nobody_knows(tmp_path: Path) -> None:
    """Frames begin when all robots are known; later the last known poses stand."""
    path = tmp_path / "recording.mcap"
    with LiveRecording(path, MODELS) as recording:
        for k in range(6):
            frame = a_frame(k)
            if k in (0, 1, 4):
                frame.poses[1] = np.nan
                frame.estimated[1] = np.nan
            recording(frame)
        recording(a_frame(50))
        recording.note("stop: pressed by the operator")
    back = read_recording(path)
    assert np.allclose(back.time, [0.1, 0.15, 0.2, 0.25, 2.5])
    assert np.array_equal(back.poses[2, 1], back.poses[1, 1])
    assert np.isnan(back.estimated[2, 1]).all()
    assert back.notes[0] == (0.1, "goal 0")
    assert back.notes[-1] == (2.5, "stop: pressed by the operator")


def test_maps_that_come_and_nothing_that_came(tmp_path: Path) -> None:
    with LiveRecording(tmp_path / "a.mcap", MODELS, maps=[(0.0, AREA)]) as recording:
        recording(a_frame(1))
    assert [topic for topic, _, _ in messages_of(tmp_path / "a.mcap")].count("/map") == 1
    LiveRecording(tmp_path / "b.mcap", MODELS).close()
    assert len(read_recording(tmp_path / "b.mcap").time) == 0


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="missing"):
        LiveRecording(tmp_path / "missing" / "r.mcap", MODELS)


def test_errors_of_the_writer_never_reach_the_run(tmp_path: Path) -> None:
    recording = LiveRecording(tmp_path / "r.mcap", MODELS)
    recording(a_frame(0))
    recording(object())  # type: ignore[arg-type]
    wait_until(lambda: bool(recording.problem))
    assert "the recording ended" in recording.problem
    recording(a_frame(1))
    recording.note("nobody listens")
    recording.close()


def test_finished_files_are_read_without_a_word(finished: tuple[bytes, int], tmp_path: Path):
    (tmp_path / "recording.mcap").write_bytes(finished[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_recording(tmp_path).ended


def test_cycles_that_a_slow_disk_leaves_out_are_told_at_once_and_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_writer, "PERIOD", 60.0)  # nothing is written before the end
    monkeypatch.setattr(live_writer, "_MOST", 3)
    with LiveRecording(tmp_path / "a.mcap", MODELS) as recording:
        for k in range(5):
            assert ("the disk is too slow" in recording.problem) == (k > 3)
            recording(a_frame(k))
        told = recording.problem
        recording(a_frame(5))
        assert recording.problem == told  # no news each cycle
    assert recording.problem == ""
    back = read_recording(tmp_path / "a.mcap")
    assert len(back.time) == 3
    assert any("3 cycles or notes are missing" in text for _, text in back.notes)
