"""Ground with heights: a gap that must be leapt over, and what each foot does there.

python examples/10_plan_on_terrain.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

scenario = cv.parse_scenario(
    {
        "version": 1,
        "name": "over-the-gap",
        "world": {"generate": {"kind": "gap", "size": [9, 4], "width": 0.3}},
        "robots": [{"model": "spirit", "start": [2, 2, 0], "goal": [7, 2, 0]}],
        "task": {"goals": "individual"},
    }
)
plan = cv.plan(scenario, folder / "gap", seed=0, force=True)
path, feet = plan.trajectories[0], plan.footholds[0]
air = path.time[path.phase == 2]
print(f"{plan.reason}: {path.length:.2f} m in {path.duration:.1f} s")
print(f"in flight from {air[0]:.2f} s on, highest at {path.position[:, 2].max():.2f} m")
terrain = cv.build_world(scenario).terrain
off = np.abs(feet[:, 5] - terrain.heights_at(feet[:, 3:5])).max()
print(f"{len(feet)} footholds, at most {off:.3f} m off the ground")
print(f"look at {folder / 'gap' / 'figures' / 'profile.png'}")
