"""Whole runs on a ROS 2 graph: simulated robots, the navigation and an operator, a process each.

    python benchmarks/live_runs.py [SCENARIO ...] [--seeds 1] [--first 0] [--backend ideal]
                                   [--speed 1] [--set KEY=VALUE ...] [--out DIR]

Needs rclpy. The goals of each scenario are published by an operator that is written without
Cavalcade (`tests/live/peers/goal.py`); the run is over when the navigation says that the team has
arrived, or after the scenario's time-out. Contacts are those of the true poses in the simulation,
and the checker judges the navigation's recording. Exit code 1 if a run did not arrive or somebody
touched something.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from live_processes import OPERATOR, Processes

from cavalcade.scenario import Scenario, dump_scenario, load_scenario


def goals_of(scenario: Scenario) -> dict[str, list[list[float]]]:
    """Topics and the poses to send there."""
    if scenario.goals:
        return {f"/robot_{k}/goal_pose": [list(goal)] for k, goal in enumerate(scenario.goals)}
    return {"/team/goals": [list(goal) for goal in scenario.task.goals]}


def one_run(name: str, seed: int, said: argparse.Namespace, out: Path) -> dict:
    """Simulate, navigate and ask for the goals; what came of it."""
    scenario = load_scenario(name, overrides=said.set, seed=seed)
    began = time.monotonic()
    folder = out / "run"
    with Processes(out) as processes:
        file = str(out / "scenario.yaml")
        dump_scenario(scenario, file)
        moved = ("--backend", said.backend, "--speed", str(said.speed))
        simulate = processes.cavalcade("ros2", "simulate", file, *moved)
        navigate = processes.cavalcade("ros2", "navigate", file, "--out", str(folder))
        goals = json.dumps(goals_of(scenario))
        operator = processes.python(str(OPERATOR), goals, str(scenario.execution.timeout))
        operator.wait()
        code = processes.end(navigate)
    judged = processes.cavalcade("check", str(folder))
    checked = judged.wait() == 0
    lines = operator.text.splitlines()
    last = next((line for line in reversed(lines) if line.startswith("{")), "{}")
    return {
        "scenario": name,
        "seed": seed,
        "backend": said.backend,
        "navigate_exit": code,
        "contacts": simulate.text.count(" touches "),
        "checked": checked,
        "check": judged.text.strip().splitlines()[-1:],
        "wall_s": round(time.monotonic() - began, 1),
        **json.loads(last),
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=["square-clutter"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--backend", default="ideal")
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--out", type=Path, default=Path("runs/live"))
    said = parser.parse_args()
    good = True
    for name in said.scenarios:
        for seed in range(said.first, said.first + said.seeds):
            folder = said.out / f"{Path(name).stem}-{said.backend}-{seed:03d}"
            result = one_run(name, seed, said, folder)
            good &= bool(result.get("arrived")) and not result["contacts"] and result["checked"]
            print(json.dumps(result), flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
