"""The independent checker on motion of one's own: arrays in, a verdict out, no files.

python examples/17_check_arrays.py
"""

import numpy as np

import cavalcade as cv

go1 = cv.robot_model("go1")
time = np.arange(0.0, 12.0, 0.1)
along = 0.15 * time - 0.075 / np.pi * np.sin(2.0 * np.pi * time / 2.0)  # m, from a stand

for aside in (0.6, 0.2):  # m between the lines on which the two go
    there = np.column_stack([2.0 + along, np.full_like(time, 2.0), np.zeros_like(time)])
    back = np.column_stack(
        [3.8 - along, np.full_like(time, 2.0 + aside), np.full_like(time, np.pi)]
    )
    report = cv.check_motion(
        time,
        np.stack([there, back], axis=1),  # (T, N, 3): x, y in m, yaw in rad
        [go1, go1],
        size=(6.0, 4.0),
        obstacles=[{"circle": {"center": [3.0, 1.5], "radius": 0.2}}],
    )
    if report.ok:
        print(f"{aside} m apart: clean, closest {report.figures.min_footprint_gap_m:.2f} m")
    else:
        print(f"{aside} m apart: {report.violations[0].message}")
