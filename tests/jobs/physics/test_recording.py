"""Tracks of physics in the recording's file: topics, messages and the way back."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from cavalcade.drawing.replay.track import skeleton_of
from cavalcade.errors import RecordingError
from cavalcade.recording._messages import topics_of
from cavalcade.recording.frames import Recorder
from cavalcade.recording.mcap_reader import read_recording
from cavalcade.recording.mcap_writer import physics_messages, write_recording
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack
from cavalcade.robots import JOINT_NAMES, robot_model, urdf_of

from .link_frames import foot_places, rotations

STORE = get_typestore(Stores.ROS2_HUMBLE)
ROBOTS, SAMPLES = 2, 30


def a_track(robots: int = ROBOTS, samples: int = SAMPLES) -> PhysicsTrack:
    random = np.random.default_rng(3)
    base = random.uniform(-2.0, 2.0, (samples, robots, 7))
    base[..., 3:] /= np.linalg.norm(base[..., 3:], axis=-1, keepdims=True)
    joints, rates, torques = random.uniform(-3.0, 3.0, (3, samples, robots, 12))
    return PhysicsTrack(
        time=np.round(0.02 * np.arange(samples), 9),
        base=base,
        joints=joints,
        joint_rates=rates,
        torques=torques,
        foot_forces=random.uniform(-50.0, 200.0, (samples, robots, 4, 3)),
        contacts=(
            ContactEvent(0.116, 0, "calf", "obstacle"),
            ContactEvent(0.31, 1, "trunk", "ground"),
            ContactEvent(0.31, 0, "foot", "robot 1"),
        ),
        falls=(FallEvent(0.31, 1),),
    )


def written(path: Path, track: PhysicsTrack | None) -> Path:
    models = [robot_model("go1")] * (track.size if track else 0)
    return write_recording(path, replace(Recorder().recording(), physics=track), models)


def test_everything_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    written(tmp_path / "recording.mcap", a_track())
    back = read_recording(tmp_path).physics
    assert back is not None
    for field in fields(PhysicsTrack):
        one, other = getattr(back, field.name), getattr(a_track(), field.name)
        assert np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other


def test_recordings_of_ideal_robots_have_no_track(tmp_path: Path) -> None:
    assert read_recording(written(tmp_path / "r.mcap", None)).physics is None


def test_what_planners_saw_is_read_beside_it(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path / "r.mcap", a_track()))
    assert len(recording.time) == 0
    assert recording.physics is not None
    assert len(recording.physics.time) == SAMPLES
    assert read_recording(written(tmp_path / "i.mcap", None)).physics is None


def test_same_track_same_bytes(tmp_path: Path) -> None:
    one = written(tmp_path / "a.mcap", a_track()).read_bytes()
    assert written(tmp_path / "b.mcap", a_track()).read_bytes() == one


def test_messages_are_those_of_ros() -> None:
    """Every message decoded by rosbags, and encoded again to the same bytes."""
    track, kinds = a_track(), topics_of(0, ROBOTS, 0)
    decoded: dict[str, list[tuple[int, Any]]] = {topic: [] for topic in kinds}
    for time, _, topic, data in physics_messages(track):
        message = STORE.deserialize_cdr(bytes(data), kinds[topic])
        assert bytes(STORE.serialize_cdr(message, kinds[topic])) == bytes(data)
        decoded[topic].append((time, message))
    assert all(len(decoded[topic]) == SAMPLES for topic in kinds if topic.startswith("/robot"))
    for k in (0, SAMPLES - 1):
        for robot in range(ROBOTS):
            time, state = decoded[f"/robot_{robot}/joint_states"][k]
            assert time == round(track.time[k] * 1e9)
            assert tuple(state.name) == JOINT_NAMES
            assert np.array_equal(state.position, track.joints[k, robot])
            assert np.array_equal(state.velocity, track.joint_rates[k, robot])
            assert np.array_equal(state.effort, track.torques[k, robot])
            _, body = decoded[f"/robot_{robot}/body"][k]
            place, turn = body.pose.position, body.pose.orientation
            said = (place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z)
            assert said == tuple(track.base[k, robot])
            assert body.header.frame_id == "map"
            for leg, name in enumerate(("FL", "FR", "RL", "RR")):
                _, foot = decoded[f"/robot_{robot}/foot_force/{name}"][k]
                assert foot.header.frame_id == f"robot_{robot}/{name}_contact"
                force = foot.wrench.force
                assert (force.x, force.y, force.z) == tuple(track.foot_forces[k, robot, leg])
    assert len(decoded["/cavalcade/contacts"]) == 3
    assert decoded["/cavalcade/falls"][0][0] == 310_000_000


def in_map(transforms: dict[str, Any], frame: str) -> tuple[np.ndarray, np.ndarray]:
    """Place and rotation of a frame, by the tree that `/tf` makes."""
    place, turn = np.zeros(3), np.eye(3)
    while frame != "map":
        item = transforms[frame]
        t, q = item.transform.translation, item.transform.rotation
        spin = rotations(np.array([q.w, q.x, q.y, q.z]))
        place, turn = np.array([t.x, t.y, t.z]) + spin @ place, spin @ turn
        frame = item.header.frame_id
    return place, turn


def test_frames_of_bodies_and_feet_were_missing(tmp_path: Path) -> None:
    """Every frame that a message is in hangs below the map, where physics had it."""
    track = a_track()
    description = robot_model("go1").description
    assert description is not None
    skeleton = skeleton_of(description)
    messages, fixed, named = [], {}, set()
    with Reader(written(tmp_path / "r.mcap", track)) as reader:
        for connection, time, data in reader.messages():
            message = STORE.deserialize_cdr(data, connection.msgtype)
            if connection.topic == "/tf":
                messages.append((time, message.transforms))
            elif connection.topic == "/tf_static":
                fixed |= {item.child_frame_id: item for item in message.transforms}
            elif hasattr(message, "header"):
                named.add(message.header.frame_id)
    for robot in range(ROBOTS):  # of the description, too
        root = ElementTree.fromstring(urdf_of(robot_model("go1"), f"robot_{robot}"))
        named |= {link.get("name") for link in root.findall("link")}
    assert [time for time, _ in messages] == [round(t * 1e9) for t in track.time]
    for k, (time, items) in enumerate(messages):
        assert not {item.child_frame_id for item in items} & set(fixed)
        transforms = fixed | {item.child_frame_id: item for item in items}
        assert named - {"map"} <= set(transforms)
        assert {item.header.stamp.sec * 10**9 + item.header.stamp.nanosec for item in items} == {
            time
        }
        for robot in range(ROBOTS):
            place, turn = in_map(transforms, f"robot_{robot}/body")
            assert np.allclose(place, track.base[k, robot, :3])
            assert np.allclose(turn, rotations(track.base[k, robot, 3:]))
            place, turn = in_map(transforms, f"robot_{robot}/base")
            assert place[2] == turn[0, 2] == turn[2, 0] == 0.0
            assert np.allclose(place[:2], track.base[k, robot, :2])
            base, joints = track.base[None, k, robot], track.joints[None, k, robot]
            for leg, wanted in enumerate(foot_places(skeleton, base, joints)[0]):
                name = ("FL", "FR", "RL", "RR")[leg]
                place, turn = in_map(transforms, f"robot_{robot}/{name}_contact")
                assert np.allclose(place, wanted)
                assert np.allclose(turn, np.eye(3))
                place, turn = in_map(transforms, f"robot_{robot}/{name}_foot")
                assert np.allclose(place, wanted)
                assert np.allclose(turn, in_map(transforms, f"robot_{robot}/{name}_calf")[1])


@pytest.mark.parametrize("cut", [0, 100, 4000])
def test_a_damaged_file_is_one_clear_error(tmp_path: Path, cut: int) -> None:
    file = written(tmp_path / "recording.mcap", a_track())
    file.write_bytes(file.read_bytes()[:cut])
    with pytest.raises(RecordingError, match=r"recording\.mcap") as caught:
        read_recording(tmp_path)
    assert "\n" not in str(caught.value)


def test_bytes_turned_over_never_end_in_a_traceback(tmp_path: Path) -> None:
    file = written(tmp_path / "recording.mcap", a_track(2, 10))
    sound = file.read_bytes()
    random = np.random.default_rng(1)
    for _ in range(25):
        data = bytearray(sound)
        for place in random.integers(0, len(data), 8):
            data[place] ^= 0xFF
        file.write_bytes(bytes(data))
        try:
            read_recording(file)
        except RecordingError:
            continue


def test_topics_of_the_contract_are_there(tmp_path: Path) -> None:
    file = written(tmp_path / "r.mcap", a_track())
    with Reader(file) as reader:
        found = {c.topic: (c.msgtype, c.msgcount) for c in reader.connections}
        times: dict[str, list[int]] = {}
        for connection, time, _ in reader.messages():
            times.setdefault(connection.topic, []).append(time)
    for robot in range(ROBOTS):
        states = found[f"/robot_{robot}/joint_states"]
        assert states == ("sensor_msgs/msg/JointState", SAMPLES)
        assert found[f"/robot_{robot}/body"] == ("geometry_msgs/msg/PoseStamped", SAMPLES)
    for stamps in times.values():
        assert stamps == sorted(stamps)


def test_no_recording_at_all(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no such recording"):
        read_recording(tmp_path)
