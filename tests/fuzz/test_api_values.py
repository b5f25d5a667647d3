"""Odd values for every public call: our own exceptions or an answer without nan, nothing else.

Each call has arguments that fit; one or two of them are replaced by odd values, or damaged.
`CAVALCADE_FUZZ=200` sets the number of cases per call; a few are tried by default.
"""

from __future__ import annotations

import copy
import dataclasses
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import datetime
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cavalcade as cv
from cavalcade.formation import SpringLaw, Springs
from cavalcade.locomotion import GaitSettings
from cavalcade.robots import MODELS, LegModel

CASES = int(os.environ.get("CAVALCADE_FUZZ", "12"))

NUMBERS = [
    0, 1, -1, 3, 0.3, -0.0, 1e-320, 1e-9, 1e6, -1e9, 1e300, 10**400, 2**63, np.nan, np.inf,
    -np.inf, True, np.float32(0.7), np.int8(2), np.float64(np.nan), np.float16(1.5),
]  # fmt: skip
OTHERS = [
    None, "", "kitchen", "1.0", b"go1", "\0", "a" * 5000, [], (), {}, {"x": 1}, {1, 2}, 1 + 2j,
    Fraction(1, 3), datetime(2026, 1, 1), Path("nowhere"), object, object(), len, range(3),
    [1.0, [2.0, 3.0]], [[1, 2], [3]], [None, 1.0], ["a", "b", "c"], [[[]]], [np.nan] * 3,
    [1.0, 2.0], [1.0, 2.0, 3.0], [[1.0, 2.0, 3.0]] * 2, np.zeros(0), np.zeros((0, 3)),
    np.zeros((3, 3), complex), np.array(["a"]), np.array(None), np.array(2.0), np.zeros((2, 2, 2)),
    np.ma.masked, np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0]), np.datetime64("2026-01-01"),
    (k for k in range(3)), "go1", cv.Circle((0.0, 0.0), 1.0), [cv.Circle((0.0, 0.0), 1.0)],
    Ellipsis, NotImplemented, np.zeros(3, [("a", float)]), np.full((2, 3), 1e308), ["go1", "go2"],
]  # fmt: skip


def damaged(value: Any, how: int, number: Any) -> Any:
    """A value that is nearly the one given."""
    if isinstance(value, (list, tuple)) and not hasattr(value, "_fields"):
        ways: list[Callable[[], Any]] = [
            lambda: type(value)(value[:-1]),
            lambda: type(value)((*value, number)),
            lambda: type(value)((*value[:-1], number)),
            lambda: type(value)((number, *value[1:])),
            lambda: np.ma.masked_array(np.array(value), mask=True),
            lambda: [value],
            lambda: dict(enumerate(value)),
        ]
    elif isinstance(value, np.ndarray):
        ways = [
            lambda: _with(value, number),
            lambda: value[:-1],
            lambda: value.T,
            lambda: value[None],
            lambda: value.astype(str),
            lambda: value.astype(object),
            lambda: value.astype(np.float32),
            lambda: value.astype(np.int8),
            lambda: value.astype(complex),
            lambda: value.astype(bool),
            lambda: np.ma.masked_array(value, mask=np.arange(value.size).reshape(value.shape) == 0),
            lambda: value.tolist(),
            lambda: value * 1e300,
            lambda: value[..., ::-1],
            lambda: np.asfortranarray(value),
            lambda: -value if value.dtype != bool else ~value,
            lambda: np.full_like(value, 0),
        ]
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        ways = [
            lambda: -value,
            lambda: value * 1e-6,
            lambda: value * 1e6,
            lambda: str(value),
            lambda: [value],
            lambda: np.array([value]),
            lambda: np.array(value),
            lambda: np.float32(value),
            lambda: complex(value),
        ]
    elif hasattr(value, "_fields"):
        name = value._fields[how % len(value._fields)]
        ways = [
            lambda: value._replace(**{name: number}),
            lambda: value._replace(**{name: damaged(getattr(value, name), how // 7, number)}),
            lambda: tuple(value),
        ]
    else:
        ways = [lambda: [value], lambda: (value, number), lambda: type(value), lambda: str(value)]
    return ways[how % len(ways)]()


def _with(array: np.ndarray, number: Any) -> np.ndarray:
    copied = array.astype(float)
    try:
        copied.flat[0] = number
    except (TypeError, ValueError, OverflowError):
        copied = copied.astype(object)
        copied.flat[0] = number
    return copied


class Call(NamedTuple):
    """A function, or a method of what `of` makes, with arguments that fit."""

    function: Callable[..., Any]
    arguments: dict[str, Any]
    slow: int = 1
    """By how much fewer cases are tried."""


GRID = np.zeros((30, 40), np.int8)
GRID[12:18, 18:22] = 100
MAP = cv.OccupancyMap(GRID, 0.1)
SQUARE = cv.Formation.square()
LAW = SpringLaw(4.5, 1.25, 0.4, 0.1, 0.04)
POSES = np.column_stack([SQUARE.placed((1.0, 1.5, 0.0)), np.zeros(4)])
GO1 = cv.robot_model("go1")
HEIGHTS = np.zeros((30, 40))
HEIGHTS[:, 20:] = 0.1
EXPECTED = cv.Imperfections(position=0.01, delay=0.1)
SPEED = np.ones((12, 15))
ATTRIBUTES = {field.name: getattr(GO1, field.name) for field in dataclasses.fields(GO1)}
TINY = {
    "version": 1,
    "name": "tiny",
    "world": {"empty": {"size": [4.0, 4.0]}, "resolution": 0.1},
    "robots": [{"model": "go1", "start": [1.0, 1.0, 0.0]}],
    "task": {
        "formation": {"shape": "custom", "slots": [[0.0, 0.0]]},
        "goals": [[2.0, 2.0, 0.0]],
    },
    "execution": {"timeout": 0.2},
}


@cache
def _scenario() -> cv.Scenario:
    return cv.parse_scenario(TINY)


@cache
def _own_goals() -> cv.Scenario:
    robots = [{"model": "go1", "start": [1.0, 1.0, 0.0], "goal": [2.0, 2.0, 0.0]}]
    return cv.parse_scenario({**TINY, "robots": robots, "task": {"goals": "individual"}})


@cache
def _terrain() -> cv.Terrain:
    return cv.Terrain.from_heights(HEIGHTS, 0.1)


@cache
def _travel() -> cv.TravelGrid:
    return cv.TravelGrid(SPEED, 0.1)


def planner() -> cv.FormationPlanner:
    """One that drives."""
    made = cv.FormationPlanner(MAP, SQUARE, expected=EXPECTED)
    made.set_goal((2.9, 1.5, 0.0))
    made.step(POSES, 1.0)
    return made


def planned(**values: Any) -> Any:
    """A planner of these values, and its first two commands."""
    made = cv.FormationPlanner(**values)
    made.set_goal((2.9, 1.5, 0.0))
    return [made.step(POSES, 0.05 * k) for k in range(2)], made.status


def told(name: str) -> Callable[..., Any]:
    """A method of a planner that drives, and what it does then."""

    def call(**values: Any) -> Any:
        made = planner()
        answer = getattr(made, name)(**values)
        return answer, [made.step(POSES, 1.05 + 0.05 * k) for k in range(2)], made.status

    return call


def filtered(**values: Any) -> Any:
    """What a filter of these values says."""
    return cv.SafetyFilter(**values).apply(_inputs())


@cache
def _inputs() -> cv.SafetyInputs:
    return cv.SafetyInputs.of(MAP, POSES, 0.0 * POSES, 0.2 + 0.0 * POSES, obstacles=[VISITOR])


@cache
def _filter() -> cv.SafetyFilter:
    return cv.SafetyFilter("go1", 0.05)


@cache
def _problem(model: str = "single-integrator") -> cv.TeamProblem:
    return cv.TeamProblem.on_map(MAP, [model], [(0.5, 0.5, 0.0)], [(1.0, 0.5, 0.0)])


def team_planned(**values: Any) -> Any:
    """A plan of a problem on the map."""
    return cv.plan_team(cv.TeamProblem.on_map(**values), settings=SOON)


def legs() -> cv.LegControl:
    """Of one robot that stands."""
    made = cv.LegControl([GO1])
    made.begin(0.0, QPOS)
    return made


def posed(name: str) -> Callable[..., Any]:
    """A posture, taken up by a robot that lies or stands."""

    def call(**values: Any) -> Any:
        made = cv.LegControl([GO1])
        made.begin(0.0, QPOS, standing=name == "lie_down")
        made.step(0.002, QPOS, np.zeros((1, 18)), np.full((1, 4), 30.0))
        return getattr(made, name)(**values)

    return call


def with_legs(name: str) -> Callable[..., Any]:
    return lambda **values: getattr(legs(), name)(**values)


VISITOR = cv.DynamicObstacle(cv.Circle((2.0, 0.4), 0.2), (0.0, 0.1))
SOON = cv.PlanSettings(iterations=2000)
QPOS = np.zeros((1, 19))
QPOS[0, 2:4] = 0.27, 1.0
QPOS[0, 7:] = np.tile([0.0, 0.8, -1.6], 4)
LEGS = GO1.legs
assert LEGS is not None
STEPS = 4
MPC = {
    "state": np.array([0.0] * 5 + [0.27] + [0.0] * 6),
    "reference": np.tile(np.array([0.0] * 5 + [0.27] + [0.0] * 6), (STEPS, 1)),
    "contacts": np.ones((STEPS, 4), np.int64),
    "levers": np.tile(
        [[0.2, 0.1, -0.27], [0.2, -0.1, -0.27], [-0.2, 0.1, -0.27], [-0.2, -0.1, -0.27]],
        (STEPS, 1, 1),
    ),
    "yaws": np.zeros(STEPS),
    "dts": np.full(STEPS, 0.05),
    "inertia": np.diag([0.1, 0.3, 0.3]),
    "mass": 12.0,
    "weights": np.ones(12),
    "force_weight": 1e-5,
    "mu": 0.6,
    "max_force": 300.0,
}
TIMES = np.arange(5) * 0.1
TRACK = np.zeros((5, 2, 3)) + [[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]]
TRAJECTORY = {
    "time": np.arange(4) * 0.03,
    "position": np.zeros((4, 3)),
    "velocity": np.zeros((4, 3)),
    "yaw": np.zeros(4),
    "phase": np.zeros(4, np.int8),
}
POINTS = np.array([[0.5, 0.5], [1.0, 1.0], [2.0, 0.3]])
EXTENT = (4.0, 3.0)
TEAM = {
    "map": MAP,
    "models": ["go1"],
    "starts": [(0.6, 0.6, 0.0)],
    "goals": [(1.2, 0.6, 0.0)],
    "terrain": None,
}
IN = Path(tempfile.gettempdir()) / "cavalcade-fuzz-nothing-here"

CALLS: dict[str, Call] = {
    "OccupancyMap": Call(
        lambda **v: cv.OccupancyMap(**v).occupied,
        {"grid": GRID, "resolution": 0.1, "origin": (0.0, 0.0, 0.0), "unknown": "occupied"},
    ),
    "OccupancyMap.empty": Call(cv.OccupancyMap.empty, {"size": EXTENT, "resolution": 0.1}),
    **{
        f"OccupancyMap.{name}": Call(getattr(MAP, name), {key: value})
        for name, key, value in (
            ("cell_of", "points", POINTS),
            ("to_local", "points", POINTS),
            ("to_map", "points", POINTS),
            ("contains", "points", POINTS),
            ("centers", "cells", np.array([[1, 2], [3, 4]])),
            ("with_shapes", "shapes", [cv.Circle((1.0, 1.0), 0.3)]),
        )
    },
    "Box": Call(cv.Box, {"center": (1.0, 2.0), "size": (0.4, 0.3), "yaw": 0.2}),
    "Circle": Call(cv.Circle, {"center": (1.0, 2.0), "radius": 0.3}),
    "Polygon": Call(cv.Polygon, {"points": [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]}),
    **{
        f"{type(shape).__name__}.{name}": Call(getattr(shape, name), {key: value})
        for shape in (
            cv.Box((1.0, 1.0), (0.3, 0.2)),
            cv.Circle((1.0, 1.0), 0.3),
            cv.Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
        )
        for name, key, value in (("moved", "offset", (0.1, 0.2)), ("distance", "points", POINTS))
    },
    "TravelGrid": Call(
        lambda **v: cv.TravelGrid(**v).field([(0.5, 0.5)]).times,
        {"speed": SPEED, "cell": 0.1, "beside": None},
    ),
    "TravelGrid.field": Call(
        lambda **v: _travel().field(**v).times,
        {"sources": POINTS, "targets": [(1, 1), (2, 3)]},
    ),
    "TravelGrid.from_cells": Call(
        lambda **v: _travel().from_cells(**v), {"cells": [(1, 2)], "targets": [(3, 4)]}
    ),
    **{
        f"TravelGrid.{name}": Call(lambda name=name, **v: getattr(_travel(), name)(**v), arguments)
        for name, arguments in (
            ("cell_of", {"point": (0.5, 0.5)}),
            ("is_free", {"point": (0.5, 0.5)}),
            ("nearest_free", {"point": (0.5, 0.5), "reach": 1.0}),
            ("local_path", {"start": (0.2, 0.2), "goal": (1.0, 0.9), "guess": 2.0}),
        )
    },
    **{
        f"ArrivalField.{name}": Call(
            lambda name=name, **v: getattr(_travel().field([(0.5, 0.5)]), name)(**v), arguments
        )
        for name, arguments in (
            ("eta", {"point": (0.5, 0.5)}),
            ("path", {"start": (0.9, 0.5)}),
            ("reaches", {"cells": [(1, 1)]}),
            ("nearest_reached", {"point": (0.5, 0.5), "reach": 1.0}),
        )
    },
    "arrival_times": Call(
        cv.arrival_times,
        {"speed": SPEED, "sources": [(1, 2)], "cell": 0.1, "targets": [(3, 4)]},
    ),
    "Terrain.from_heights": Call(
        cv.Terrain.from_heights,
        {"heights": HEIGHTS, "resolution": 0.1, "origin": (0.0, 0.0, 0.0)},
    ),
    "Terrain": Call(
        cv.Terrain,
        {
            "height": HEIGHTS,
            "smooth": HEIGHTS,
            "normals": np.dstack([0 * HEIGHTS] * 2 + [HEIGHTS + 1]),
            "traversability": HEIGHTS + 0.5,
            "resolution": 0.1,
            "origin": (0.0, 0.0, 0.0),
        },
    ),
    "Terrain.from_map": Call(cv.Terrain.from_map, {"map": MAP}),
    **{
        f"Terrain.{name}": Call(
            lambda name=name, **v: getattr(_terrain(), name)(**v), {"points": POINTS}
        )
        for name in ("heights_at", "in_hole", "smooth_at", "to_local", "traversability_at")
    },
    "make_ground": Call(cv.make_ground, {"map": MAP, "terrain": None}),
    "Connection": Call(cv.Connection, {"a": 0, "b": 1, "rest_length": 1.0, "law": LAW}),
    "SpringLaw": Call(SpringLaw, dataclasses.asdict(LAW)),
    "Springs": Call(Springs, {"sides": LAW, "diagonals": LAW}),
    "Formation": Call(
        cv.Formation,
        {
            "name": "custom",
            "slots": SQUARE.slots,
            "connections": (cv.Connection(0, 1, 1.0, LAW),),
        },
    ),
    "Formation.square": Call(cv.Formation.square, {"side": 1.0, "springs": Springs(LAW, LAW)}),
    "Formation.triangle": Call(cv.Formation.triangle, {"side": 1.0, "springs": Springs(LAW, LAW)}),
    **{
        f"Formation.{name}": Call(getattr(cv.Formation, name), {"robots": 5, key: 1.0})
        for name, key in (
            ("line", "spacing"),
            ("column", "spacing"),
            ("wedge", "spacing"),
            ("circle", "radius"),
        )
    },
    "Formation.custom": Call(
        cv.Formation.custom,
        {"slots": SQUARE.slots, "connections": [cv.Connection(0, 1, 1.0, LAW)]},
    ),
    "Formation.connected": Call(SQUARE.connected, {"connections": [cv.Connection(0, 1, 1.0, LAW)]}),
    "Formation.placed": Call(SQUARE.placed, {"pose": (1.0, 2.0, 0.3)}),
    "Formation.smaller": Call(SQUARE.smaller, {"robots": 3}),
    "FormationSettings": Call(cv.FormationSettings, dataclasses.asdict(cv.FormationSettings())),
    "FormationSettings.with_values": Call(
        cv.FormationSettings().with_values, {"r_max": 0.3, "lookahead": 2.0}
    ),
    "Imperfections": Call(cv.Imperfections, dataclasses.asdict(EXPECTED)),
    "Imperfections.error": Call(EXPECTED.error, {"period": 0.05, "reach": 0.3}),
    "Imperfections.held": Call(EXPECTED.held, {"period": 0.05}),
    "DynamicObstacle": Call(
        cv.DynamicObstacle, {"shape": cv.Circle((1.0, 1.0), 0.3), "velocity": (0.1, 0.2)}
    ),
    "RobotModel": Call(lambda **v: repr(cv.RobotModel(**v)), ATTRIBUTES),
    "LegModel": Call(LegModel, dataclasses.asdict(LEGS)),
    "robot_model": Call(cv.robot_model, {"model": "go1"}),
    "register_model": Call(cv.register_model, {"model": GO1}),
    "FormationPlanner": Call(
        planned,
        {
            "map": MAP,
            "formation": SQUARE,
            "robots": 4,
            "model": "go1",
            "settings": None,
            "variant": "cavalcade",
            "rate": 20.0,
            "seed": 0,
            "lookahead": 2.0,
            "expected": EXPECTED,
        },
    ),
    **{
        f"FormationPlanner.{name}": Call(told(name), arguments)
        for name, arguments in {
            "step": {"poses": POSES, "time": 1.05, "stamps": np.full(4, 1.05)},
            "set_goal": {"pose": (2.9, 1.5, 0.0)},
            "set_goals": {"goals": [(2.9, 1.5, 0.0), (1.0, 1.5, 0.0)]},
            "set_formation": {"formation": SQUARE},
            "lose": {"robot": 2},
            "rejoin": {"robot": 2},
            "update_map": {"map": MAP},
            "set_dynamic_obstacles": {"obstacles": [VISITOR]},
        }.items()
    },
    "SafetyInputs.of": Call(
        cv.SafetyInputs.of,
        {
            "map": MAP,
            "poses": POSES,
            "velocities": 0.0 * POSES,
            "commands": 0.0 * POSES,
            "obstacles": [VISITOR],
            "clearance": 0.0,
            "rank": np.arange(4),
            "frozen": np.zeros(4, bool),
            "distances": None,
        },
    ),
    "SafetyFilter": Call(filtered, {"model": "go1", "period": 0.05, "expected": EXPECTED}),
    "SafetyFilter.apply": Call(lambda **v: _filter().apply(**v), {"inputs": _inputs()}),
    "SafetyFilter.in_body": Call(
        lambda **v: _filter().in_body(**v), {"poses": POSES, "wanted": 0.0 * POSES}
    ),
    "PlanSettings": Call(
        lambda **v: cv.plan_team(_problem(), settings=cv.PlanSettings(**v)),
        {**dataclasses.asdict(cv.PlanSettings()), "iterations": 2000},
        4,
    ),
    "TeamProblem": Call(
        lambda **v: cv.plan_team(cv.TeamProblem(**v), settings=SOON),
        {
            "ground": cv.make_ground(MAP),
            "models": (cv.robot_model("single-integrator"),),
            "starts": ((0.5, 0.5, 0.0),),
            "goals": ((1.0, 0.5, 0.0),),
            "origin": (0.0, 0.0, 0.0),
        },
        4,
    ),
    "TeamProblem.on_map": Call(team_planned, TEAM, 4),
    "TeamProblem.part": Call(lambda **v: _problem().part(**v), {"robots": [0]}),
    "plan_team": Call(
        cv.plan_team,
        {"problem": _problem(), "method": "sequential", "settings": SOON, "seed": 0},
        4,
    ),
    "BodySettings": Call(
        cv.BodySettings,
        {
            field.name: getattr(cv.BodySettings(), field.name)
            for field in dataclasses.fields(cv.BodySettings)
        },
    ),
    "plan_body": Call(
        cv.plan_body,
        {
            "ground": cv.make_ground(MAP),
            "model": GO1,
            "start": (0.6, 0.6, 0.0),
            "goal": (1.2, 0.6, 0.0),
            "settings": cv.BodySettings(iterations=200),
            "seed": 1,
        },
        12,
    ),
    "LegControl": Call(
        cv.LegControl,
        {"models": [GO1], "ground": None, "origin": (0.0, 0.0, 0.0), "settings": GaitSettings()},
    ),
    "LegControl.begin": Call(with_legs("begin"), {"time": 0.0, "qpos": QPOS, "standing": True}),
    "LegControl.command": Call(
        with_legs("command"), {"velocities": np.array([[0.2, 0.0, 0.0]]), "time": 0.0}
    ),
    "LegControl.lie_down": Call(posed("lie_down"), {"robot": 0, "qpos": QPOS}),
    "LegControl.rise": Call(posed("rise"), {"robot": 0, "qpos": QPOS}),
    "LegControl.step": Call(
        with_legs("step"),
        {"time": 0.002, "qpos": QPOS, "qvel": np.zeros((1, 18)), "feet": np.zeros((1, 4))},
    ),
    "solve_mpc": Call(
        lambda changes, **v: cv.solve_mpc(cv.MpcProblem(**v), changes), {**MPC, "changes": 30}
    ),
    "solve_mpc (problem)": Call(cv.solve_mpc, {"problem": cv.MpcProblem(**MPC), "changes": 30}),
    "check": Call(cv.check, {"directory": IN}),
    "check_motion": Call(
        cv.check_motion,
        {
            "time": TIMES,
            "poses": TRACK,
            "models": [GO1, GO1],
            "size": EXTENT,
            "obstacles": [{"circle": {"center": [3.0, 1.0], "radius": 0.2}}],
        },
    ),
    "Trajectory": Call(lambda **v: cv.Trajectory(**v).length, TRAJECTORY),
    "Trajectory.poses_at": Call(cv.Trajectory(**TRAJECTORY).poses_at, {"times": TIMES}),
    "generate": Call(
        cv.generate,
        {
            "kind": "clutter",
            "size": (12.0, 4.0),
            "seed": 3,
            "resolution": 0.1,
            "radius": 0.3,
            "require_feasible": True,
            "attempts": 3,
            "obstacles": 2,
        },
        2,
    ),
    "generate_terrain": Call(
        cv.generate_terrain, {"kind": "slope", "size": (6.0, 4.0), "seed": 3, "resolution": 0.1}, 2
    ),
    "load_map": Call(cv.load_map, {"path": IN / "map.yaml", "unknown": "free"}),
    "load_terrain": Call(cv.load_terrain, {"path": IN / "hills.yaml", "resolution": 0.1}),
    "load_scenario": Call(
        cv.load_scenario, {"name_or_path": "cone", "overrides": ["execution.rate=10"], "seed": 1}
    ),
    "parse_scenario": Call(cv.parse_scenario, {"data": TINY, "file": None}),
    "build_world": Call(cv.build_world, {"scenario": _scenario()}),
    "dump_scenario": Call(cv.dump_scenario, {"scenario": _scenario(), "path": IN / "s.yaml"}),
    "save_map": Call(
        cv.save_map,
        {"occupancy_map": MAP, "path": IN / "map.yaml", "image": "pgm", "mode": "trinary"},
    ),
    "read_recording": Call(cv.read_recording, {"path": IN / "recording.mcap"}),
    "run": Call(
        cv.run,
        {
            "scenario": _scenario(),
            "out": None,
            "seed": 1,
            "overrides": (),
            "backend": "ideal",
            "sinks": (),
        },
        6,
    ),
    "plan": Call(
        cv.plan,
        {"scenario": _own_goals(), "out": None, "method": "auto", "seed": 1, "overrides": ()},
        6,
    ),
}
"""Types of results, such as `Report` or `Frame`, are not for callers to make."""


def assert_no_nan(value: Any, depth: int = 0) -> None:
    """Nothing in an answer is nan."""
    if isinstance(value, (float, np.floating)):
        assert value == value
    elif isinstance(value, np.ndarray):
        assert value.dtype.kind not in "fc" or not np.isnan(value).any()
    elif isinstance(value, Mapping):
        for part in value.values():
            assert_no_nan(part, depth + 1)
    elif isinstance(value, (list, tuple)):
        for part in value:
            assert_no_nan(part, depth + 1)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type) and depth < 5:
        for field in dataclasses.fields(value):
            assert_no_nan(getattr(value, field.name), depth + 1)


ODD = st.one_of(
    st.sampled_from(NUMBERS).map(lambda value: ("is", value)),
    st.sampled_from(range(len(OTHERS))).map(lambda index: ("is", OTHERS[index])),
    st.tuples(st.just("damaged"), st.integers(0, 500), st.sampled_from([*NUMBERS, None, "x", []])),
)


def attempt(call: Call, picks: list[tuple[int, tuple]]) -> None:
    """Call with odd arguments; anything but an answer or one of our own exceptions fails."""
    arguments = dict(call.arguments)
    names = list(arguments)
    for index, (how, *rest) in picks:
        name = names[index % len(names)]
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                arguments[name] = (
                    rest[0] if how == "is" else damaged(call.arguments[name], rest[0], rest[1])
                )
            except Exception:  # what cannot be damaged so
                return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        try:
            answer = call.function(**arguments)
        except cv.CavalcadeError as error:
            text = str(error)
            assert text, "an error says what is wrong"
            assert "\n" not in text
            assert len(text) < 700, text
            return
    assert_no_nan(answer)


@pytest.mark.parametrize("name", CALLS)
def test_odd_values(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call = CALLS[name]
    before = set(MODELS)

    @settings(
        max_examples=max(3, CASES // call.slow), derandomize=True, deadline=None, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(st.lists(st.tuples(st.integers(0, 20), ODD), min_size=1, max_size=2))
    def check(picks: list[tuple[int, tuple]]) -> None:
        attempt(call, picks)

    check()
    for added in set(MODELS) - before:
        MODELS.remove(added)


# Calls that read a file or folder are left to the tests of what they read: here nothing lies there.
_WITHOUT_FILES = [
    name
    for name, call in CALLS.items()
    if not any(isinstance(value, Path) for value in call.arguments.values())
]


@pytest.mark.parametrize("name", _WITHOUT_FILES)
def test_what_fits_is_taken(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the other test would only see that these calls are refused."""
    monkeypatch.chdir(tmp_path)
    call = CALLS[name]
    assert_no_nan(call.function(**copy.copy(call.arguments)))


PLANNER_CALLS = [name for name in CALLS if name.startswith("FormationPlanner.")]


@settings(
    max_examples=CASES * 4, derandomize=True, deadline=None, database=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
@given(
    st.lists(
        st.tuples(st.sampled_from(PLANNER_CALLS), st.integers(0, 20), ODD),
        min_size=1, max_size=8,
    )
)  # fmt: skip
def test_a_planner_survives_what_it_refuses(calls: list[tuple[str, int, tuple]]) -> None:
    """Whatever it was told before, its commands are finite and obey the limits."""
    made = planner()
    time = 1.0
    for name, index, (how, *rest) in calls:
        arguments = dict(CALLS[name].arguments)
        key = list(arguments)[index % len(arguments)]
        try:
            odd = rest[0] if how == "is" else damaged(arguments[key], rest[0], rest[1])
        except Exception:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            with suppress(cv.CavalcadeError):
                getattr(made, name.partition(".")[2])(**{**arguments, key: odd})
        time += 0.05
        commands = made.step(POSES, time)
        assert np.isfinite(commands).all()
        assert np.abs(commands).max() <= 1.2
        assert_no_nan(made.status)
