"""A map and a shape of your own: save a map as ROS does, load it, run an arrow through it.

python examples/03_own_map_and_shape.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))
folder.mkdir(parents=True, exist_ok=True)

# Any ROS map_server YAML with its picture will do; this one is made on the spot.
walls: list[cv.Box | cv.Circle] = [cv.Box((5.0, y), (0.3, 1.6)) for y in (0.8, 5.2)]
walls.append(cv.Circle((7.0, 3.4), 0.2))
cv.save_map(cv.OccupancyMap.empty((11.0, 6.0)).with_shapes(walls), folder / "hall.yaml")
print("loaded", cv.load_map(folder / "hall.yaml"))

# Slots in the formation's frame, x forward, the leader's first; springs join the neighbours.
arrow = [[0.8, 0.0], [-0.2, 0.7], [-0.2, -0.7], [-0.8, 0.0]]
starts = [[x + 1.8, y + 3.0, 0.0] for x, y in arrow]
scenario = cv.parse_scenario(
    {
        "version": 1,
        "name": "arrow",
        "world": {"map": str(folder / "hall.yaml")},
        "robots": [{"model": "go1", "start": start} for start in starts],
        "task": {
            "formation": {"shape": "custom", "slots": arrow},
            "goals": [[9.0, 3.0, 0.0]],
        },
    }
)
cv.dump_scenario(scenario, folder / "arrow.yaml")
result = cv.run(scenario, folder / "arrow", force=True)
print(f"{result.reason} after {result.summary['sim_time_s']:.1f} s; see {result.directory}")
