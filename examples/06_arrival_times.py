"""The solver by itself: how long from everywhere to one place, where walls slow a robot down.

python examples/06_arrival_times.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cavalcade as cv
from cavalcade.eikonal import TravelGrid, surface_distance, velocity_map

folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))
folder.mkdir(parents=True, exist_ok=True)

walls = [cv.Box((4.0, 1.8), (0.3, 3.6)), cv.Box((7.0, 4.2), (0.3, 3.6))]
world = cv.OccupancyMap.empty((11.0, 6.0)).with_shapes(walls)
speed = velocity_map(surface_distance(world.occupied, 0.05), radius=0.30, safe_distance=1.0)

times = cv.arrival_times(speed, [(60, 200)], 0.05)  # seconds to [row, col], inf without a path
print(f"longest: {times[np.isfinite(times)].max():.1f} s")

# The same as a field that can be asked for times and paths between cells.
field = TravelGrid(speed, 0.05).field((10.025, 3.025))
path, remaining = field.path((1.0, 1.0))
print(f"from (1, 1): {remaining[0]:.1f} s over {len(path)} points")

plt.switch_backend("agg")
plt.imshow(np.where(np.isfinite(times), times, np.nan), origin="lower", extent=(0, 11, 0, 6))
plt.colorbar(label="s")
plt.plot(*path.T, "w-")
plt.savefig(folder / "arrival_times.png", dpi=120)
print("wrote", folder / "arrival_times.png")
