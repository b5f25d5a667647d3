"""The safety filter without the planner: any commands in, commands that touch nothing out.

python examples/13_safety_filter_alone.py
"""

import numpy as np

import cavalcade as cv

world = cv.OccupancyMap.empty((8.0, 5.0)).with_shapes([cv.Box((5.5, 2.5), (0.3, 5.0))])
period = 0.05
guard = cv.SafetyFilter("go1", period)

# Two robots that someone steers at each other and at the wall, at full speed; x, y, yaw each.
poses = np.array([[1.5, 2.5, 0.0], [4.0, 2.6, np.pi]])
velocities = np.zeros((2, 3))  # present ones, in the map's frame, as your localisation gives them
asked = np.array([[0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])  # body frame: m/s, m/s, rad/s
visitor = cv.DynamicObstacle(cv.Circle((3.0, 0.5), 0.2), (0.0, 0.1))

distances = None  # of the map: found in the first cycle and kept
for _ in range(500):
    inputs = cv.SafetyInputs.of(
        world, poses, velocities, asked, obstacles=[visitor], distances=distances
    )
    distances = inputs.surroundings.distances
    commands, levels = guard.apply(inputs)  # level 0: only as little changed as needed
    # Here the commands go to your robots; these perfect ones obey at once.
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    velocities[:, 0] = c * commands[:, 0] - s * commands[:, 1]
    velocities[:, 1] = s * commands[:, 0] + c * commands[:, 1]
    velocities[:, 2] = commands[:, 2]
    poses += period * velocities
    x, y = visitor.shape.center
    visitor = cv.DynamicObstacle(cv.Circle((x, y + 0.1 * period), 0.2), (0.0, 0.1))

apart = float(np.hypot(*(poses[0] - poses[1])[:2]))
print(
    f"asked for 0.5 m/s each, they stand {apart:.2f} m apart; commands {commands.round(2).tolist()}"
)
