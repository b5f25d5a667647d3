"""Whole runs on a ROS 2 graph: simulated robots, the navigation and an operator, a process each.

    python benchmarks/live_runs.py [SCENARIO ...] [--seeds 1] [--backend ideal] [--speed 1]
                                   [--set KEY=VALUE ...] [--out DIR]

Needs rclpy. The goals of each scenario are published by an operator that is written without
Cavalcade (`tests/live/peers/goal.py`); the run is over when the navigation says that the team has
arrived, or after the scenario's time-out. Contacts are those of the true poses in the simulation,
and the checker judges the navigation's recording. Exit code 1 if a run did not arrive or somebody
touched something.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from cavalcade.scenario import Scenario, dump_scenario, load_scenario

OPERATOR = Path(__file__).parent.parent / "tests" / "live" / "peers" / "goal.py"
CAVALCADE = [sys.executable, "-m", "cavalcade"]


def goals_of(scenario: Scenario) -> dict[str, list[list[float]]]:
    """Topics and the poses to send there."""
    if scenario.goals:
        return {f"/robot_{k}/goal_pose": [list(goal)] for k, goal in enumerate(scenario.goals)}
    return {"/team/goals": [list(goal) for goal in scenario.task.goals]}


def one_run(name: str, seed: int, domain: int, said: argparse.Namespace, out: Path) -> dict:
    """Simulate, navigate and ask for the goals; what came of it."""
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(out / "log"),
    }
    out.mkdir(parents=True)
    scenario = load_scenario(name, overrides=said.set, seed=seed)
    limit = scenario.execution.timeout
    file = str(out / "scenario.yaml")
    dump_scenario(scenario, file)
    log = out / "simulate.log"
    begun: list[subprocess.Popen[bytes]] = []

    def start(*command: str, log: Path) -> subprocess.Popen[bytes]:
        with log.open("wb") as file:
            process = subprocess.Popen(
                command, stdout=file, stderr=subprocess.STDOUT, env=environment
            )
        begun.append(process)
        return process

    began = time.monotonic()
    try:
        start(
            *CAVALCADE, "ros2", "simulate", file, "--backend", said.backend,
            "--speed", str(said.speed), log=log,
        )  # fmt: skip
        folder = out / "run"
        navigate = start(
            *CAVALCADE, "ros2", "navigate", file, "--out", str(folder),
            log=out / "navigate.log",
        )  # fmt: skip
        operator = start(
            sys.executable, str(OPERATOR), json.dumps(goals_of(scenario)), str(limit),
            log=out / "operator.log",
        )  # fmt: skip
        operator.wait()
        navigate.send_signal(signal.SIGTERM)
        code = navigate.wait(60)
    finally:
        for process in reversed(begun):
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in begun:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
    lines = (out / "operator.log").read_text().splitlines()
    last = next((line for line in reversed(lines) if line.startswith("{")), "{}")
    judged = subprocess.run([*CAVALCADE, "check", str(folder)], capture_output=True, text=True)
    return {
        "scenario": name,
        "seed": seed,
        "navigate_exit": code,
        "contacts": sum(" touches " in line for line in log.read_text().splitlines()),
        "checked": judged.returncode == 0,
        "check": (judged.stdout + judged.stderr).strip().splitlines()[-1:],
        "wall_s": round(time.monotonic() - began, 1),
        **json.loads(last),
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=["square-clutter"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--backend", default="ideal")
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--out", type=Path, default=Path("runs/live"))
    said = parser.parse_args()
    good = True
    number = 0
    for name in said.scenarios:
        for seed in range(said.seeds):
            number += 1
            domain = 1 + (os.getpid() + number) % 100
            folder = said.out / f"{Path(name).stem}-{said.backend}-{seed:03d}-{os.getpid()}"
            result = one_run(name, seed, domain, said, folder)
            good &= bool(result.get("arrived")) and not result["contacts"] and result["checked"]
            print(json.dumps(result), flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
