"""Run a shipped scenario: three robots cross a cluttered laboratory in a triangle.

python examples/01_run_a_shipped_scenario.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

print("shipped:", ", ".join(cv.scenario_names()))
result = cv.run("triangle-lab", folder / "triangle-lab", seed=1, force=True)

summary = result.summary
print(f"{result.reason} after {summary['sim_time_s']:.1f} s")
print(f"nearest to an obstacle: {summary['min_obstacle_distance_m']:.2f} m")
print(f"nearest to each other:  {summary['min_robot_distance_m']:.2f} m")
print(f"mean formation error:   {summary['formation_error_m']['mean']:.2f} m")
for file in result.files:
    print("wrote", file)
