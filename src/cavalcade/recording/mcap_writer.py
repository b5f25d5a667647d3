"""Recordings as MCAP files of standard ROS 2 messages, for RViz, Foxglove and for us."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from operator import itemgetter
from pathlib import Path

import numpy as np

from cavalcade.files import replacing
from cavalcade.recording import _messages
from cavalcade.recording.cdr import nanoseconds, stamps_of
from cavalcade.recording.cycle_messages import CycleMessages, Message, opening, series, text_message
from cavalcade.recording.frames import Recording
from cavalcade.recording.mcap_file import McapFile
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.robots import LEGS, RobotModel, body_of
from cavalcade.world import OccupancyMap

FILE = "recording.mcap"
"""A run's recording in its folder."""


def write_recording(
    path: str | Path,
    recording: Recording,
    models: Sequence[RobotModel],
    maps: Iterable[tuple[float, OccupancyMap]] = (),
) -> Path:
    """Write a recording, all at once.

    Args:
        path: The new file; one that is there is replaced.
        recording: What happened.
        models: One per robot, for their descriptions and the size of the markers.
        maps: (time in s, map) as it was from then on.

    Returns:
        The file written.

    Raises:
        OutputError: It cannot be written.
    """
    physics, bodies = recording.physics, 0
    start = float(recording.time[0]) if len(recording.time) else 0.0
    messages = list(opening(models, start, recording.obstacles, standing=physics is None))
    messages += CycleMessages(models, frames=physics is None)(recording, maps)
    if physics is not None:
        bodies = physics.size
        messages += physics_messages(physics)
        messages += _physics_frames(physics, models)
    messages.sort(key=itemgetter(0, 1))
    topics = _messages.topics_of(recording.poses.shape[1], bodies, len(models))
    target = Path(path)
    with replacing(target) as temporary:
        file = McapFile(temporary, topics, _messages.latched(len(models)))
        try:
            for time, _, topic, data in messages:
                file.write(topic, time, data)
                if file.full:
                    file.flush()
            file.close()
        finally:
            file.abandon()
    return target


def physics_messages(track: PhysicsTrack) -> Iterator[Message]:
    """Every message of a track; of each topic in order of time."""
    times = nanoseconds(track.time)
    count, stamp = len(times), stamps_of(times)
    for robot in range(track.size):
        name = f"/robot_{robot}"
        # The quaternion is w, x, y, z in memory and x, y, z, w in messages.
        pose = track.base[:, robot][:, (0, 1, 2, 4, 5, 6, 3)]
        yield from series(
            times, 10, f"{name}/body", _messages.POSE.pack(count, stamp=stamp, pose=pose)
        )
        columns = {
            column: getattr(track, name)[:, robot]
            for column, name in _messages.JOINT_COLUMNS.items()
        }
        joints = _messages.joints_layout(robot).pack(count, stamp=stamp, **columns)
        yield from series(times, 10, f"{name}/joint_states", joints)
        wrench = np.zeros((count, len(LEGS), 6))
        wrench[..., :3] = track.foot_forces[:, robot]
        for k, leg in enumerate(LEGS):
            layout = _messages.force_layout(robot, leg)
            forces = layout.pack(count, stamp=stamp, wrench=wrench[:, k])
            yield from series(times, 10, f"{name}/foot_force/{leg}", forces)
    for contact in track.contacts:
        yield text_message(contact.time, 10, _messages.CONTACTS_TOPIC, asdict(contact))
    for fall in track.falls:
        yield text_message(fall.time, 10, _messages.FALLS_TOPIC, asdict(fall))


def _physics_frames(track: PhysicsTrack, models: Sequence[RobotModel]) -> Iterator[Message]:
    """The transforms of all robots at each sample."""
    frames: list[_messages.Transform] = []
    for robot, model in enumerate(models):
        body, joints = body_of(model), track.joints[:, robot]
        frames += _messages.body_frames(robot, track.base[:, robot])
        if body is not None:
            frames += _messages.link_frames(robot, body.link_poses(joints))
            frames += _messages.contact_frames(
                robot, track.base[:, robot], body.foot_places(joints)
            )
    times = nanoseconds(track.time)
    return series(times, 5, "/tf", _messages.transform_messages(times, frames))
