"""Plans of one robot over Quad-SDK's test grounds: how many succeed, how soon, how long they are.

python benchmarks/terrain_body.py [--meshes ../shared/data/terrain/quad_sdk] [--seeds 50]
    [--robots spirit go1 go2] [--variant cavalcade] [--seconds 1] [--random]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cavalcade.kinodynamic.obstruction import obstruction
from cavalcade.kinodynamic.parameters import make_body, make_space
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import OccupancyMap, Terrain
from cavalcade.world.terrain import load_terrain

GROUNDS = (
    "flat",
    "gap_20cm",
    "gap_40cm",
    "step_10cm",
    "step_20cm",
    "step_25cm",
    "slope_20",
    "rough_25cm",
)
MESHES = Path(__file__).resolve().parents[2] / "shared/data/terrain/quad_sdk"
Pose = tuple[float, float, float]


def fixed(terrain: Terrain, seeds: int) -> Iterator[tuple[Pose, Pose]]:
    """5 m along the middle."""
    y = 0.5 * terrain.size[1]
    return (((2.0, y, 0.0), (7.0, y, 0.0)) for _ in range(seeds))


def random_poses(
    ground: Ground, terrain: Terrain, model: RobotModel, seeds: int
) -> Iterator[tuple[Pose, Pose]]:
    """Valid poses near both ends, with any yaw."""
    space = make_space(ground, make_body(model, margin=0.01))
    width, height = terrain.size
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        poses: list[Pose] = []
        for low, high in ((0.5, 1.6), (width - 1.6, width - 0.5)):
            for _ in range(1_000):
                y = rng.uniform(0.6, height - 0.6)
                pose = (rng.uniform(low, high), y, rng.uniform(-math.pi, math.pi))
                if not obstruction(space, pose):
                    poses.append(pose)
                    break
        if len(poses) == 2:
            yield (poses[1], poses[0]) if seed % 2 else (poses[0], poses[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--meshes", type=Path, default=MESHES)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--robots", nargs="+", default=["spirit", "go1", "go2"])
    parser.add_argument("--variant", default="cavalcade")
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--random", action="store_true", help="draw start and goal")
    options = parser.parse_args()
    settings = BodySettings(iterations=10**7, seconds=options.seconds, variant=options.variant)
    for name in GROUNDS:
        terrain = load_terrain(options.meshes / name / f"{name}.stl")
        empty = np.zeros(terrain.height.shape, dtype=bool)
        ground = make_ground(OccupancyMap(empty, terrain.resolution), terrain)
        for robot in options.robots:
            model = robot_model(robot)
            problems = list(
                random_poses(ground, terrain, model, options.seeds)
                if options.random
                else fixed(terrain, options.seeds)
            )
            plan_body(ground, model, *problems[0], BodySettings(iterations=300))  # compiles
            plans = [
                plan_body(ground, model, start, goal, settings, seed)
                for seed, (start, goal) in enumerate(problems)
            ]
            good = [
                (plan, math.dist(start[:2], goal[:2]))
                for plan, (start, goal) in zip(plans, problems, strict=True)
                if plan.trajectory is not None
            ]
            line = f"{name:10s} {robot:6s} {len(good)} of {len(plans)}"
            if good:
                times = np.array([plan.planning_time for plan, _ in good])
                lengths = np.array([plan.trajectory.length for plan, _ in good])
                ratios = lengths / np.array([way for _, way in good])
                line += (
                    f", {np.sum(times < 0.2)} within 0.2 s, median {1e3 * np.median(times):.2f} ms,"
                    f" slowest {1e3 * times.max():.1f} ms, length {np.median(lengths):.3f} m,"
                    f" over the straight line {np.median(ratios):.3f}, largest {ratios.max():.3f}"
                )
            print(line, flush=True)


if __name__ == "__main__":
    main()
