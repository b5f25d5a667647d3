"""Events: an obstacle that crosses, a new shape, a robot that is lost, a goal that changes.

python examples/04_change_the_world_on_the_way.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import cavalcade as cv

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))

trolley = {"circle": {"center": [6.0, 0.6], "radius": 0.25}, "to": [6.0, 5.4], "speed": 0.4}
starts = [[2.2, 3.0, 0.0], [1.5, 3.7, 0.0], [0.8, 3.0, 0.0], [1.5, 2.3, 0.0]]
scenario = cv.parse_scenario(
    {
        "version": 1,
        "name": "changes",
        "world": {"empty": {"size": [12, 6]}},
        "robots": [{"model": "go1", "start": start} for start in starts],
        "task": {"formation": {"shape": "square", "side": 1.0}, "goals": [[10.0, 3.0, 0.0]]},
        "execution": {
            "events": [
                {"at": 4.0, "move": trolley},
                {"at": 8.0, "formation": {"shape": "column", "spacing": 0.9}},
                {"at": 12.0, "lose": 2},
                {"at": 16.0, "goals": [[9.0, 4.5, 1.57]]},
            ]
        },
    }
)
result = cv.run(scenario, folder / "changes", force=True)
print(f"{result.reason} after {result.summary['sim_time_s']:.1f} s")
for time, note in result.recording.notes:
    print(f"{time:5.1f} s  {note}")
