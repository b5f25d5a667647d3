"""Threads that call everything of a live team's navigation at any time: errors and torn states.

    python benchmarks/live_threads.py [--threads 10] [--seconds 60]

Three robots of a fleet in memory are driven in real time; each thread calls methods at random and
reads the status after each call. Prints how many calls were made, errors and statuses that are not
of one moment. Exit code 1 if there were any, or if the team does not arrive afterwards.
"""

from __future__ import annotations

import argparse
import json
import logging
import random
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from cavalcade.live.navigator import TeamNavigator
from cavalcade.live.status import TeamStatus
from cavalcade.live.team_file import parse_team
from cavalcade.world import Box, OccupancyMap

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "live"))
from fake_fleet import FakeFleet

STARTS = ((1.5, 2.0, 0.0), (1.5, 3.0, 0.0), (1.5, 4.0, 0.0))
NAMES = ("anna", "bert", "cleo")
GOAL = (4.0, 3.0, 0.0)
TEAM = {
    "version": 1,
    "robots": [{"name": name} for name in NAMES],
    "formation": {"shape": "line", "spacing": 1.0},
    "supervision": {"deadline": 2.0},  # ten threads of Python's leave little to the planner's
}


def calls_of(live: TeamNavigator, ground: OccupancyMap) -> dict[str, Callable[[], object]]:
    """Everything that may be called, by name."""
    box = ground.with_shapes([Box((3.0, 1.0), (0.3, 0.3))])
    return {
        "a goal": lambda: live.set_formation_goals([GOAL]),
        "goals": lambda: live.set_formation_goals([(2.0, 3.0, 0.0), GOAL]),
        "a robot's goal": lambda: live.set_robot_goal("bert", (2.0, 3.0, 0.0)),
        "another's": lambda: live.set_robot_goal("cleo", (2.5, 4.5, 1.0)),
        "a map": lambda: live.set_map(box),
        "the map": lambda: live.set_map(ground),
        "pause": live.pause,
        "resume": live.resume,
        "resume again": live.resume,
        "cancel": live.cancel,
        "stop": live.stop,
        "reset_stop": live.reset_stop,
        "lose": lambda: live.lose("anna"),
        "rejoin": lambda: live.rejoin("anna"),
        "a shape": lambda: live.set_formation({"shape": "line", "spacing": 0.9}),
        "the shape": lambda: live.set_formation({"shape": "line"}),
        "refuse": lambda: live.refuse("a word"),
        "map": lambda: live.map.grid.sum(),
        "frame": lambda: live.frame is not None and live.frame.commands.sum(),
    }


def torn(status: TeamStatus) -> str:
    """Which parts of a status contradict each other; empty if none do."""
    json.dumps(status.to_dict(), allow_nan=False)
    own = [robot.goal for robot in status.robots if robot.goal is not None]
    going = any(any(robot.command) for robot in status.robots)
    found = {
        "stopped without a cause": (status.state == "stopped") != bool(status.cause),
        "a cause, and all is well": bool(status.cause) == status.ok,
        "stopped, and commanded": not status.ok and going,
        "stopped, and not said": not status.ok and not status.message.startswith("stopped: "),
        "two kinds of goals": bool(status.goals and own),
        "idle with a goal": status.state == "idle" and bool(status.goals or own),
    }
    return ", ".join(text for text, holds in found.items() if holds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=60.0)
    said = parser.parse_args()
    ground = OccupancyMap.empty((6.0, 6.0), 0.1)
    logging.getLogger("cavalcade").setLevel(logging.CRITICAL)  # of what is refused on purpose
    counts, states, errors, contradictions = Counter(), Counter(), Counter(), Counter()
    slowest, lock = dict.fromkeys(("status",), 0.0), threading.Lock()
    with TeamNavigator(parse_team(TEAM), FakeFleet(STARTS, speed=1.0), map=ground) as live:
        calls = calls_of(live, ground)
        names, end = sorted(calls), time.monotonic() + said.seconds

        def work(seed: int) -> None:
            pick = random.Random(seed)
            while (began := time.monotonic()) < end:
                name, wrong, lie, state = pick.choice(names), "", "", ""
                called = began
                try:
                    calls[name]()
                    called = time.monotonic()
                    status = live.status
                    lie, state = torn(status), status.state
                except Exception as error:
                    wrong = f"{name}: {type(error).__name__}: {error}"
                with lock:
                    counts[name] += 1
                    states[state] += 1
                    errors[wrong] += bool(wrong)
                    contradictions[lie] += bool(lie)
                    slowest[name] = max(slowest.get(name, 0.0), called - began)
                    slowest["status"] = max(slowest["status"], time.monotonic() - called)

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(said.threads)]
        for thread in threads:
            thread.start()
        while time.monotonic() < end:  # an operator, without whom they would mostly be stopped
            time.sleep(0.2)
            live.reset_stop()
            live.resume()
        for thread in threads:
            thread.join()
        arrived = arrives(live)
        message = live.status.message
    print(f"{said.threads} threads, {said.seconds:g} s: {counts.total()} calls", end=", ")
    print(f"{errors.total()} errors, {contradictions.total()} torn states")
    print(f"states: {dict(states)}")
    worst = sorted(slowest.items(), key=lambda item: -item[1])[:6]
    print("slowest calls: " + ", ".join(f"{name} {took:.3f} s" for name, took in worst))
    for text, count in (*errors.items(), *contradictions.items()):
        if text:
            print(f"{count} x {text}")
    print("the team arrives afterwards" if arrived else f"the team does not arrive: {message}")
    return int(bool(errors.total() or contradictions.total() or not arrived))


def arrives(live: TeamNavigator) -> bool:
    """Whether the team still does what it is told to."""
    live.rejoin("anna")
    live.reset_stop()
    live.set_map(OccupancyMap.empty((6.0, 6.0), 0.1))
    live.set_formation({"shape": "line"})
    live.set_formation_goals([GOAL])
    end = time.monotonic() + 60.0
    while not live.status.arrived and time.monotonic() < end:
        if not live.status.ok or live.status.state == "paused":
            live.resume()
        time.sleep(0.1)
    return live.status.arrived


if __name__ == "__main__":
    sys.exit(main())
