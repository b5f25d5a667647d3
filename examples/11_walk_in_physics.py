"""Legs in MuJoCo: a robot that is driven, pushed and looked at; then a formation that walks.

python examples/11_walk_in_physics.py [FOLDER]     (needs pip install 'cavalcade[physics]')
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

# The fleet takes the commands that ideal robots take: body-frame m/s, m/s, rad/s.
fleet = cv.MujocoFleet([cv.robot_model("go1")], [[0.0, 0.0, 0.0]])
for step in range(80):
    fleet.send([[0.5, 0.0, 0.4]])  # silence of 0.5 s stops a robot
    if step == 40:
        fleet.simulator.push(0, (0.0, 200.0, 0.0), 0.1)  # N, s
    fleet.advance(0.05)
x, y, yaw = fleet.true_poses()[0]
print(f"after {fleet.time:.1f} s at ({x:.2f}, {y:.2f}), heading {np.degrees(yaw):.0f} degrees")
print("fell" if fleet.falls else "on its feet after a push of 20 N s")

# The same scenario file, on legs; the checker judges forces, torques, feet and contacts.
result = cv.run("cone", out=folder / "cone", backend="mujoco")
print(
    f"{result.reason} after {result.summary['makespan_s']:.1f} s, {result.summary['falls']} falls"
)
print("clean" if cv.check(folder / "cone").ok else "the checker objects")
