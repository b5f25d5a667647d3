"""After the warm-up no plan waits for a kernel."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import pkgutil, sys
from importlib import import_module
import numpy as np
import cavalcade.kinodynamic
from cavalcade.kinodynamic import BodySettings, plan_body, warm_up
from cavalcade.lattice import make_ground
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap
from cavalcade.world.terrain import generate_terrain

def compiled():
    names = [m.name for m in pkgutil.iter_modules(cavalcade.kinodynamic.__path__)]
    modules = [import_module(f"cavalcade.kinodynamic.{name}") for name in names]
    kernels = {k for module in modules for k in vars(module).values() if hasattr(k, "signatures")}
    return {k.__name__: len(k.signatures) for k in kernels}

warm_up()
before = compiled()
assert before["search"] == 1, before
walls = OccupancyMap.empty((9.0, 4.0)).with_shapes([Box((3.0, 1.2), (0.4, 2.4))])
for terrain in (None, generate_terrain("gap", (9.0, 4.0), width=0.3)):
    ground = make_ground(walls, terrain)
    for variant in ("cavalcade", "published"):
        for discs in (np.zeros((0, 3)), [[6.0, 1.0, 0.3]]):
            settings = BodySettings(iterations=300, improve=50, variant=variant, discs=discs)
            plan_body(ground, robot_model("go1"), (1.5, 1.2, 0.0), (7.0, 2.0, 1.0), settings)
after = compiled()
assert before == after, {k: (before[k], n) for k, n in after.items() if before[k] != n}
"""


def test_a_plan_after_the_warm_up_compiles_nothing():
    subprocess.run([sys.executable, "-c", CODE], check=True)
