"""A seeded set of scenario files that between them touch every kind of world, team and trouble.

They use the contract of scenario files alone; the same number and seed give the same files.
"""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Any

import yaml

Data = dict[str, Any]

VARIANTS = (
    "cavalcade",
    "published",
    "cavalcade-no-springs",
    "virtual-structure",
    "cavalcade-fixed-roles",
    "cavalcade-no-filter",
    "behaviour-based",
    "cavalcade-no-lookahead",
    "fixed-roles",
    "cavalcade-no-avoidance",
    "no-lookahead",
    "cavalcade-no-standoffs",
    "no-springs",
    "no-avoidance",
)
"""Of the formation's planner."""

FORMATIONS: tuple[tuple[Data, int], ...] = (
    ({"shape": "triangle", "side": 1.0}, 3),
    ({"shape": "square", "side": 1.0}, 4),
    ({"shape": "column", "spacing": 0.9}, 2),
    ({"shape": "wedge", "spacing": 0.9}, 5),
    ({"shape": "line", "spacing": 0.9}, 3),
    ({"shape": "circle", "radius": 1.0}, 6),
    ({"shape": "custom", "slots": [[0.5, 0.0], [-0.4, 0.6], [-0.4, -0.6]]}, 3),
    ({"shape": "line", "spacing": 0.9}, 1),
)
"""Shapes and their team sizes."""

METHODS = (
    ("auto", "cavalcade"),
    ("cbs", "cavalcade"),
    ("sequential", "published"),
    ("joint", "cavalcade"),
    ("auto", "published"),
    ("cbs", "published"),
    ("sequential", "cavalcade"),
)
"""Planners of individual goals and their variants."""

OBSTACLES: dict[str, Data] = {
    "clutter": {"kind": "clutter", "size": [13, 8], "obstacles": 14},
    "forest": {"kind": "forest", "size": [12, 7], "trees": 12},
    "corridor": {"kind": "corridor", "size": [12, 8], "width": 1.4},
    "rooms": {"kind": "rooms", "size": [8, 4], "room": 4.0, "door": 1.4},
    "maze": {"kind": "maze", "size": [8, 5], "passage": 1.6, "loops": 0.2},
}
TERRAINS: dict[str, Data] = {
    "gap": {"kind": "gap", "size": [9, 4], "width": 0.3},
    "step": {"kind": "step", "size": [9, 4], "height": 0.15},
    "stairs": {"kind": "stairs", "size": [9, 4], "steps": 3, "height": 0.08, "tread": 0.5},
    "slope": {"kind": "slope", "size": [9, 4], "angle": 0.3},
    "rough": {"kind": "rough", "size": [9, 4], "height": 0.12},
    "blocks": {"kind": "blocks", "size": [9, 4], "height": 0.06},
    "stepping-stones": {"kind": "stepping-stones", "size": [9, 4]},
}
"""All kinds of `world.generate`, with and without heights."""

_NARROW = ("rooms", "maze")
_CYCLE = (
    *("formation:clutter", "individual:clutter", "formation:forest", "terrain:gap"),
    *("formation:corridor", "individual:forest", "terrain:step", "formation:rooms"),
    *("commands", "terrain:rough", "formation:maze", "formation:empty", "individual:empty"),
    *("terrain:stairs", "terrain:slope", "formation:clutter", "terrain:blocks"),
    *("individual:corridor", "terrain:stepping-stones"),
)


def write_worlds(folder: Path, count: int, seed: int) -> list[Path]:
    """Write that many scenario files; their names say what they are."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for number in range(count):
        kind, _, ground = _CYCLE[number % len(_CYCLE)].partition(":")
        rng = random.Random(f"{seed}-{number}")
        turn = number // len(_CYCLE)
        make = {
            "formation": _formation,
            "individual": _individual,
            "terrain": _terrain,
            "commands": _commands,
        }[kind]
        data = {"version": 1, **make(rng, ground, number + turn)}
        file = folder / "-".join(part for part in (f"{number:03d}", kind, ground) if part)
        file = file.with_name(f"{file.name}.yaml")
        data["name"] = file.stem
        data["execution"]["seed"] = rng.randrange(10_000)
        file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
        files.append(file)
    return files


def _world(rng: random.Random, ground: str) -> tuple[Data, float, float]:
    """The world of a file, its width and its height."""
    if ground == "empty":
        boxes: list[Data] = [
            {"box": {"center": [5.0, 1.4], "size": [0.6, 2.6], "yaw": round(rng.uniform(0, 1), 2)}},
            {"circle": {"center": [6.5, round(rng.uniform(3, 6), 2)], "radius": 0.3}},
            {"polygon": {"points": [[5, 6], [6.2, 6.4], [5.4, 7.4]]}},
        ]
        return {"empty": {"size": [12, 8]}, "obstacles": boxes}, 12.0, 8.0
    source = {**OBSTACLES[ground], "seed": rng.randrange(1000)}
    return {"generate": source}, float(source["size"][0]), float(source["size"][1])


def _formation(rng: random.Random, ground: str, turn: int) -> Data:
    formation, robots = FORMATIONS[2 if ground in _NARROW else turn % len(FORMATIONS)]
    world, width, height = _world(rng, ground)
    if ground in _NARROW:
        starts = [[0.5, 0.5, 0.0], [1.2, 1.1, 0.0]]
        goals = [[6.0 if ground == "rooms" else 7.0, 2.0 if ground == "rooms" else 0.8, 0.0]]
    else:
        places = [(x, height / 2 + dy) for dy in (0.0, 0.8, -0.8) for x in (1.6, 0.7)]
        starts = [[*place, 0.0] for place in places[:robots]]
        goals = [[width - 1.5, height / 2, 0.0]]
        if rng.random() < 0.3:
            goals.append([width - 1.2, height / 2 + 1.0, round(math.pi / 2, 4)])
    execution: Data = {"timeout": 40, "rate": rng.choice([10, 20])}
    if rng.random() < 0.4:
        execution["noise"] = {"position": 0.02, "heading": 0.02}
    if rng.random() < 0.4:
        execution["delay"] = {"mean": 0.08, "jitter": 0.03, "drop": 0.05}
    if rng.random() < 0.7:
        execution["events"] = _events(rng, robots, width, height)
    planner: Data = {"variant": VARIANTS[turn % len(VARIANTS)]}
    if rng.random() < 0.5:
        planner |= {"preset": rng.choice(["simulation", "laboratory"]), "lookahead": 3.0}
    model = rng.choice(["go1", "go2"])
    return {
        "world": world,
        "robots": [{"model": model, "start": start} for start in starts],
        "task": {"formation": formation, "goals": goals},
        "planner": planner,
        "execution": execution,
    }


def _events(rng: random.Random, robots: int, width: float, height: float) -> list[Data]:
    middle = [round(width / 2, 2), round(height / 2, 2)]
    moving = {"circle": {"center": [middle[0], 0.6], "radius": 0.25}, "to": [middle[0], height - 1]}
    added = {"circle": {"center": middle, "radius": 0.2}}
    choices: list[list[Data]] = [
        [{"at": 3.0, "add": added}, {"at": 9.0, "remove": added}],
        [{"at": 2.0, "move": {**moving, "speed": 0.3}}],
        [{"at": 5.0, "goals": [[width - 2.0, height / 2 - 0.5, 0.5]]}],
    ]
    if robots > 1:
        choices.append([{"at": 4.0, "formation": {"shape": "column", "spacing": 0.9}}])
        choices.append([{"at": 3.0, "lose": robots - 1}, {"at": 8.0, "rejoin": robots - 1}])
    return sorted((event for one in rng.sample(choices, 2) for event in one), key=_at)


def _at(event: Data) -> float:
    return float(event["at"])


def _individual(rng: random.Random, ground: str, turn: int) -> Data:
    world, width, height = _world(rng, ground)
    robots = []
    for k in range(2 + turn % 3):
        y = height / 2 + (0.0, 0.9, -0.9, 1.8)[k]
        west, east = [1.0, y, 0.0], [width - 1.0, y, 0.0]
        if k % 2:
            west, east = [1.0, y, round(math.pi, 6)], [width - 1.0, y, round(math.pi, 6)]
            west, east = east, west
        model = rng.choice(["spirit", "go1", "go2"])
        robots.append({"model": model, "start": west, "goal": east})
    return _own_goals(rng, world, robots, turn)


def _terrain(rng: random.Random, ground: str, turn: int) -> Data:
    source = {**TERRAINS[ground], "seed": rng.randrange(1000)}
    robots = [{"model": "spirit", "start": [0.7, 1.5, 0.0], "goal": [8.3, 1.5, 0.0]}]
    if turn % 2:
        yaw = round(math.pi, 6)
        robots.append({"model": "go2", "start": [8.3, 2.7, yaw], "goal": [0.7, 2.7, yaw]})
    return _own_goals(rng, {"generate": source}, robots, turn)


def _own_goals(rng: random.Random, world: Data, robots: list[Data], turn: int) -> Data:
    method, variant = METHODS[turn % len(METHODS)]
    # In iterations alone: seconds would make results those of a busy machine.
    planner: Data = {"method": method, "variant": variant, "budget": {"iterations": 20_000}}
    # Keys only where they have an effect.
    if rng.random() < 0.3 and variant != "published" and method != "joint":
        planner["improve"] = 2_000
    if rng.random() < 0.3 and method not in ("joint", "sequential"):
        planner["conflict"] = rng.choice(["costly", "earliest", "first"])
    return {
        "world": world,
        "robots": robots,
        "task": {"goals": "individual"},
        "planner": planner,
        "execution": {"timeout": 90},
    }


def _commands(rng: random.Random, ground: str, turn: int) -> Data:
    commands: list[Data] = [
        {"at": 0.5, "velocity": [round(rng.uniform(0.2, 0.5), 2), 0, 0]},
        {"at": 4.0, "robot": 0, "velocity": [0.2, 0.1, 0.5]},
        {"at": 4.0, "robot": 1, "to": [5.5, 4.0], "speed": 0.4},
    ]
    return {
        "world": {"empty": {"size": [8, 5]}},
        "robots": [{"start": [1.0, 1.5, 0.0]}, {"start": [1.0, 3.5, 0.0]}],
        "task": {"duration": 12.0, "commands": commands},
        "execution": {"backend": "ideal", "timeout": 60},
    }
