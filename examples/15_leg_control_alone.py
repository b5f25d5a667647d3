"""Leg control without a simulator: a robot that stands begins to trot, by its torques alone."""

from __future__ import annotations

import numpy as np

from cavalcade.locomotion import LegControl
from cavalcade.robots import robot_model

go1 = robot_model("go1")
robot = go1.description
assert robot is not None
control = LegControl([go1])

# What a robot would measure: trunk (position, quaternion w, x, y, z), joints, rates, feet's forces.
qpos = np.array([[0.0, 0.0, robot.stand_height, 1.0, 0.0, 0.0, 0.0, *robot.standing]])
qvel = np.zeros((1, 18))
feet = np.full((1, 4), robot.mass * 9.81 / 4)

control.begin(0.0, qpos)
for k in range(100):
    time = 0.002 * k
    if k == 50:
        control.command([[0.3, 0.0, 0.0]], time)  # m/s, m/s, rad/s
    torques = control.step(time, qpos, qvel, feet)
    if k in (49, 99):
        print(f"{time:.3f} s, torques in N m (hip, thigh, calf of FL, FR, RL, RR):")
        print(np.round(torques.reshape(4, 3), 2))
print("a front leg swings with the hind leg on the other side")
