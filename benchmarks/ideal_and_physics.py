"""Whether ideal runs predict physics: the same scenarios with both backends, side by side.

    python benchmarks/ideal_and_physics.py [--scenario NAME ...] [--worlds N]

Shipped formations and seeded clutter worlds with four Go1s; a Markdown table: how it ended, when
the last robot was in place, how near centres came to obstacles and to each other, the smallest
gap of footprints, the formation error, and how far poses at the same time are apart while both
runs last (Go1s that yield to each other in another order are apart for good).
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from cavalcade.jobs import JobResult, run
from cavalcade.scenario.loading import parse_scenario

NAMES = ("square-clutter", "cone", "triangle-lab", "triangle-corridor", "tour-ten", "office")
BACKENDS = ("ideal", "mujoco")
CLUTTER = {
    "version": 1,
    "name": "clutter",
    "robots": [
        {"model": "go1", "start": [x, y, 0.0]} for x, y in ((2, 5.5), (2, 4.5), (1, 4.5), (1, 5.5))
    ],
    "task": {"formation": {"shape": "square", "side": 1.0}, "goals": [[12.5, 5.0, 0.0]]},
}


def main() -> None:
    """Run both and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenario", nargs="+", default=list(NAMES))
    parser.add_argument("--worlds", type=int, default=0, help="seeded clutter worlds besides")
    arguments = parser.parse_args()
    print(
        "| scenario | backend | result | in place, s | obstacle, m | pair, m | gap, m "
        "| error, m | apart: median, p95, m |\n|---|---|---|---|---|---|---|---|---|"
    )
    for name in arguments.scenario:
        compare(name, [run(name, backend=backend) for backend in BACKENDS])
    for seed in range(arguments.worlds):
        world = {"generate": {"kind": "clutter", "size": [14, 10], "obstacles": 25, "seed": seed}}
        scenario = parse_scenario({**CLUTTER, "world": world})
        compare(f"clutter {seed}", [run(scenario, backend=backend) for backend in BACKENDS])


def compare(name: str, results: list[JobResult]) -> None:
    """Print a line for each backend."""
    apart = distances(*results)
    for backend, result in zip(BACKENDS, results, strict=True):
        said: dict[str, Any] = result.summary
        figures = [
            "–" if value is None else f"{value:.3f}"
            for value in (
                said["min_obstacle_distance_m"],
                said["min_robot_distance_m"],
                said["min_footprint_gap_m"],
                said["formation_error_m"]["mean"],
            )
        ]
        last = (
            "" if backend == "ideal" else f"{np.median(apart):.3f}, {np.quantile(apart, 0.95):.3f}"
        )
        time = "–" if said["makespan_s"] is None else f"{said['makespan_s']:.1f}"
        print(
            f"| {name} | {backend} | {said['reason']} | {time} | {' | '.join(figures)} | {last} |",
            flush=True,
        )


def distances(first: JobResult, second: JobResult) -> np.ndarray:
    """`(T, N)` m between the true positions of both runs at the same times."""
    count = min(len(first.recording.time), len(second.recording.time))
    moved = first.recording.poses[:count, :, :2] - second.recording.poses[:count, :, :2]
    return np.hypot(moved[..., 0], moved[..., 1])


if __name__ == "__main__":
    main()
