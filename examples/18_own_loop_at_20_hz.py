"""A loop of your own: late and noisy robots at 20 Hz, with stamps, warm-up and supervisor.

python examples/18_own_loop_at_20_hz.py
"""

import time

import numpy as np

import cavalcade as cv
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise

world = cv.OccupancyMap.empty((6.0, 4.0)).with_shapes([cv.Circle((2.6, 0.6), 0.3)])
shape = cv.Formation.triangle(1.15)
expected = cv.Imperfections(position=0.01, heading=0.01, delay=0.15, drop=0.02)
planner = cv.FormationPlanner(world, shape, rate=20.0, expected=expected)
starts = np.column_stack([shape.placed((1.5, 2.0, 0.0)), np.zeros(3)])
planner.set_goal((3.6, 2.0, 0.0))
# Real robots go on while a planner is late: a cycle of more than two deadlines stops them.
team = cv.SupervisedPlanner(planner, cv.Supervision(max_age=0.5, max_speed=0.4, deadline=0.2))
cv.warm_up(planner)  # or the first cycle would compile; before robots listen
# In the place of robots: they are located with noise and hear commands 0.15 s late.
errors = {"noise": LocalisationNoise(0.01, 0.01), "delay": CommandDelay(0.15, 0.0, 0.02)}
robots = IdealFleet([planner.model] * 3, starts, **errors)
due, said = time.monotonic(), ""
try:
    for _ in range(1200):
        seen = robots.observe()  # poses (N, 3), when each was measured (N,), and the time now
        robots.send(team.step(seen.poses, seen.time, seen.stamps))
        if team.status.message != said:  # why they stand, or who does not follow
            print(said := team.status.message)
        if team.status.arrived:
            break
        due = max(due + 1.0 / planner.rate, time.monotonic() - 0.2)
        time.sleep(max(0.0, due - time.monotonic()))
        robots.advance(1.0 / planner.rate)
finally:
    robots.send(np.zeros((3, 3)))  # however the loop ends
print(f"{'arrived' if team.status.arrived else 'gave up'} after {seen.time:.1f} s")
