"""A team planned on a map of one's own: no scenario file, no folder, just trajectories.

python examples/12_plan_team_without_files.py
"""

import numpy as np

from cavalcade.coordination import PlanSettings, TeamProblem, plan_team
from cavalcade.world import OccupancyMap

# A hall of 8 x 6 m with a wall that has a door, cells of 0.05 m: any array of booleans will do.
occupied = np.zeros((120, 160), dtype=bool)
occupied[:50, 78:82] = occupied[70:, 78:82] = True

problem = TeamProblem.on_map(
    OccupancyMap(occupied, 0.05),
    models=["spirit", "go1", "unicycle"],
    starts=[(1.5, 3.0, 0.0), (6.5, 3.0, np.pi), (1.5, 1.0, 0.0)],
    goals=[(6.5, 3.0, 0.0), (1.5, 3.0, np.pi), (6.5, 1.0, 0.0)],
)
plan = plan_team(problem, "auto", PlanSettings(iterations=200_000), seed=1)
print(f"{plan.reason} by {plan.method}, {plan.iterations} iterations")

times = np.arange(0.0, max(path.duration for path in plan.trajectories), 0.05)
poses = np.stack([path.poses_at(times) for path in plan.trajectories])  # (3, K, 3) x, y, yaw
apart = min(np.hypot(*(poses[i] - poses[j]).T[:2]).min() for i, j in ((0, 1), (0, 2), (1, 2)))
print(f"all at their goals after {times[-1]:.1f} s; centres never nearer than {apart:.2f} m")
