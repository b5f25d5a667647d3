"""How evenly a team is driven, for minutes: jitter, missed deadlines, age of poses, memory.

    python benchmarks/live_pace.py [SCENARIO] [--minutes 10] [--out DIR]

Needs rclpy. Simulated ideal robots, the navigation and an operator run in processes of their own;
the navigation goes by the wall's clock, as with real robots, and records. The team goes through
the scenario's goals and back until the time is over. Prints the figures of all cycles and the
navigation's memory after each minute. Exit code 1 if something stopped the team.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import threading
import time
from pathlib import Path

import yaml
from live_processes import OPERATOR, Process, Processes

from cavalcade.scenario import dump_scenario, load_scenario


def team_file(scenario_file: Path, robots: int, formation: dict, rate: float) -> Path:
    """A team in the wall's time."""
    file = scenario_file.with_name("team.yaml")
    said = {
        "version": 1,
        "name": "pace",
        "use_sim_time": False,
        "robots": [{"name": f"robot_{k}"} for k in range(robots)],
        "formation": formation,
        "rate": rate,
    }
    file.write_text(yaml.safe_dump(said))
    return file


def memory_of(process: Process) -> float:
    """Resident memory of a process, MiB; 0 of one that has ended."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    found = re.search(r"VmRSS:\s+(\d+) kB", status)
    return int(found[1]) / 1024 if found else 0.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", nargs="?", default="tour-ten")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--out", type=Path, default=Path("runs/live-pace"))
    said = parser.parse_args()
    scenario = load_scenario(said.scenario)
    there = [list(goal) for goal in scenario.task.goals]
    back = [*there[-2::-1], list(there[0])]
    legs, last = 0, {}
    ended = threading.Event()
    with Processes(said.out) as processes:
        file = said.out / "scenario.yaml"
        dump_scenario(scenario, file)
        shape = scenario.task.the_formation.model_dump(mode="json", exclude_none=True)
        team = team_file(file, len(scenario.robots), shape, scenario.execution.rate)
        simulate = processes.cavalcade("ros2", "simulate", str(file))
        navigate = processes.cavalcade(
            "ros2", "navigate", str(team), "--out", str(said.out / "run")
        )
        began = time.monotonic()
        memory: list[float] = []

        def watch() -> None:
            while not ended.wait(60.0):
                memory.append(round(memory_of(navigate), 1))

        threading.Thread(target=watch, daemon=True).start()
        while time.monotonic() - began < 60.0 * said.minutes:
            goals = json.dumps({"/team/goals": there if legs % 2 == 0 else back})
            operator = processes.python(str(OPERATOR), goals, str(scenario.execution.timeout))
            operator.wait()
            last = json.loads(operator.text.splitlines()[-1])
            if not last["arrived"]:
                break
            legs += 1
        ended.set()
        took = time.monotonic() - began
        code = processes.end(navigate)
    if not legs:
        print(simulate.text, navigate.text, file=sys.stderr)
    print(
        json.dumps(
            {
                "wall_s": round(took, 1),
                "legs": legs,
                "navigate_exit": code,
                "memory_mib_by_minute": memory,
                **last,
            }
        )
    )
    return 0 if last.get("arrived") else 1


if __name__ == "__main__":
    sys.exit(main())
