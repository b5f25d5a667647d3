"""Robots with goals of their own: plan, look at the plan, let an independent checker judge it.

python examples/09_plan_a_team.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

scenario = cv.parse_scenario(
    {
        "version": 1,
        "name": "crossing",
        "world": {
            "empty": {"size": [10, 8]},
            "obstacles": [{"box": {"center": [5, 6.2], "size": [3.0, 0.6]}}],
        },
        "robots": [
            {"model": "spirit", "start": [1, 4, 0], "goal": [9, 4, 0]},
            {"model": "spirit", "start": [9, 4, 3.14], "goal": [1, 4, 3.14]},
            {"model": "go1", "start": [5, 1, 1.57], "goal": [5, 7.2, 0]},
        ],
        "task": {"goals": "individual"},
    }
)
plan = cv.plan(scenario, folder / "crossing", method="auto", seed=1, force=True)
print(f"{plan.reason}: {sum(plan.summary['path_length_m']):.1f} m of ways")
for robot, (path, feet) in enumerate(zip(plan.trajectories, plan.footholds, strict=True)):
    print(f"robot {robot}: {path.length:.2f} m in {path.duration:.1f} s, {len(feet)} steps")
report = cv.check(folder / "crossing")
print("clean" if report.ok else report.violations[0].message)
print(f"look at {folder / 'crossing' / 'replay.html'}")
