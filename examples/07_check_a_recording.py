"""Judge a run by its recording alone, and read the recording for figures of your own.

python examples/07_check_a_recording.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

cv.run("cone", folder / "cone", figures=False, replay=False, force=True)

report = cv.check(folder / "cone")  # shares no code with what it judges
print("clean" if report.ok else f"first violation: {report.violations[0].message}")
if report.figures is not None:
    print(f"least gap, also between samples: {report.figures.min_footprint_gap_m:.3f} m")
    print(f"largest acceleration: {report.figures.max_acceleration:.2f} m/s²")

recording = cv.read_recording(folder / "cone")
steps = np.diff(recording.poses[:, :, :2], axis=0)
length = np.hypot(steps[..., 0], steps[..., 1]).sum(axis=0)
for robot, metres in enumerate(length):
    print(f"robot {robot} walked {metres:.2f} m")
