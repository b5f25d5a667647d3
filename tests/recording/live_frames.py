"""Frames of a run that was never made, and a process that records them until it is killed."""

from __future__ import annotations

import sys
import time

import numpy as np

from cavalcade.recording.frames import Frame
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap

ROBOTS = 3
MODELS = (robot_model("go1"), robot_model("spirit"), robot_model("go2"))
AREA = OccupancyMap.empty((4.0, 3.0), 0.5)


def a_frame(k: int, period: float = 0.05) -> Frame:
    """Cycle `k`: three robots side by side, always ahead."""
    poses = np.array([(1.0 + 0.001 * k, 1.0 + robot, 0.1 * robot) for robot in range(ROBOTS)])
    status = PlannerStatus(
        state="partial",
        leader=k // 100 % ROBOTS,
        roles=np.arange(ROBOTS),
        slots=np.array([(1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]),
        goals=poses[:, :2] + 0.01 * k,
        goal=np.array([3.0, 1.0, 0.0]),
        paths=tuple(np.linspace(pose[:2], (3.0, 1.0), 30) for pose in poses),
        connections=np.array([(0, 1), (1, 2)]),
        eta=np.full(ROBOTS, 1.0),
    )
    notes = (f"goal {k}",) if k % 50 == 0 else ()
    maps = (AREA,) if k == 0 else ()
    time = round(k * period, 9)
    return Frame(time, poses, poses + 0.01, np.full((ROBOTS, 3), 0.1), status, 0.001, notes, maps)


def record_for_ever(path: str, rate: float) -> None:
    """Record until somebody kills the process; says on stdout how many cycles there were."""
    recording = LiveRecording(path, MODELS, names=("a", "b", "c"))
    k, start = 0, time.monotonic()
    while True:
        recording(a_frame(k, 1.0 / rate))
        k += 1
        print(k, time.monotonic() - start, flush=True)
        time.sleep(max(0.0, start + k / rate - time.monotonic()))


if __name__ == "__main__":
    record_for_ever(sys.argv[1], float(sys.argv[2]))
