"""Call the planner from a loop of your own: a ROS node, another simulator, a notebook.

python examples/02_step_the_planner_yourself.py
"""

import numpy as np

import cavalcade as cv

world = cv.OccupancyMap.empty((8.0, 5.0)).with_shapes([cv.Circle((4.0, 2.6), 0.3)])
shape = cv.Formation.square(1.0)
planner = cv.FormationPlanner(world, shape, model="go1", rate=20.0, lookahead=3.0)
planner.set_goal((6.4, 2.5, 0.0))
team = cv.SupervisedPlanner(planner)  # stops all of them when a pose is lost, jumps or is nonsense

# Poses (N, 3) come from your localisation: x, y in m and yaw in rad, in the map's frame.
poses = np.column_stack([shape.placed((1.5, 2.5, 0.0)), np.zeros(4)])
for cycle in range(1200):
    command = team.step(poses, cycle / planner.rate)  # (N, 3) body-frame m/s, m/s, rad/s
    status = team.status
    if cycle % 100 == 0:
        roles = status.roles.tolist()
        print(f"{cycle / 20:5.1f} s  {status.state:8} leader {status.leader:2}  roles {roles}")
    if status.arrived:
        print(f"arrived after {cycle / planner.rate:.1f} s")
        break
    # Here the commands go to your robots; these perfect ones obey at once.
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    poses[:, 0] += (c * command[:, 0] - s * command[:, 1]) / planner.rate
    poses[:, 1] += (s * command[:, 0] + c * command[:, 1]) / planner.rate
    poses[:, 2] += command[:, 2] / planner.rate
