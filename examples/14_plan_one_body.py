"""One body's motion over uneven ground by itself: a map with heights in, a timed trajectory out.

python examples/14_plan_one_body.py
"""

import numpy as np

import cavalcade as cv
from cavalcade.kinodynamic import BodySettings, plan_body
from cavalcade.lattice import make_ground

# A trench 0.4 m wide from side to side, and a box on this side of it.
terrain = cv.generate_terrain("gap", (9.0, 4.0), width=0.4)
boxes = [cv.Box((3.0, 1.2), (0.4, 1.6))]
ground = make_ground(cv.OccupancyMap.empty((9.0, 4.0)).with_shapes(boxes), terrain)

spirit = cv.robot_model("spirit")
start, goal = (1.5, 1.2, 0.0), (7.0, 2.0, 0.0)  # x, y in m, yaw in rad
settings = BodySettings(iterations=5_000)
plan = plan_body(ground, spirit, start, goal, settings, seed=1)

path = plan.trajectory
if path is None:
    raise SystemExit(f"{plan.reason}: {plan.detail}")
speed = np.hypot(path.velocity[:, 0], path.velocity[:, 1])
airborne = path.time[path.phase == 2]
print(f"{plan.reason}: {path.length:.2f} m in {path.duration:.1f} s, at most {speed.max():.2f} m/s")
print(f"it leaps from {airborne[0]:.2f} s on")

# The same without leaps: that there is no path is an answer, too.
afoot = plan_body(ground, spirit, start, goal, BodySettings(leaps=False))
print(f"on foot: {afoot.reason}, {afoot.detail}")
