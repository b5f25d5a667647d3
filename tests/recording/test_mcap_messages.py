"""All messages of an MCAP file at once, compared with what rosbags reads one by one."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from cavalcade.errors import RecordingError
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.mcap_file import McapFile
from cavalcade.recording.mcap_messages import read_messages
from cavalcade.recording.mcap_reader import read_recording

from .live_frames import MODELS, a_frame


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    with LiveRecording(tmp_path / "recording.mcap", MODELS) as file:
        for k in range(30):
            file(a_frame(k))
    return tmp_path / "recording.mcap"


def test_the_same_as_rosbags(recording: Path) -> None:
    expected: dict[tuple[str, str], list[tuple[int, bytes]]] = {}
    with Reader(recording) as reader:
        for connection in reader.connections:
            expected[connection.topic, connection.msgtype] = []
        for connection, time, data in reader.messages():
            expected[connection.topic, connection.msgtype].append((time, bytes(data)))
    found = read_messages(recording)
    assert {key: list(zip(one.times, one.data, strict=True)) for key, one in found.items()} == (
        expected
    )
    assert not [
        topic
        for topic, _ in read_messages(recording, lambda topic: topic != "/tf")
        if topic == "/tf"
    ]


def test_messages_that_were_written_out_of_order(tmp_path: Path) -> None:
    file = McapFile(tmp_path / "a.mcap", {"/a": "std_msgs/msg/String"})
    for time in (3, 1, 2):
        file.write("/a", time, bytes([time]))
        file.flush()
    file.close()
    (messages,) = read_messages(tmp_path / "a.mcap").values()
    assert (messages.times, messages.data) == ([1, 2, 3], [b"\x01", b"\x02", b"\x03"])


@pytest.mark.parametrize("share", [0.01, 0.5, 0.99])
def test_bytes_of_a_chunk_that_were_changed_are_damage(recording: Path, share: float) -> None:
    data = bytearray(recording.read_bytes())
    chunk = data.index(b"zstd") + 4
    size = int.from_bytes(data[chunk : chunk + 8], "little")
    data[chunk + 8 + int(share * size)] ^= 0x55
    recording.write_bytes(data)
    with pytest.raises(RecordingError, match=r"recording\.mcap: .*cannot be read"):
        read_recording(recording)
