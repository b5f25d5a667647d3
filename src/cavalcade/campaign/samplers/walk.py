"""Robots that are told how to walk and leap, without a planner, pushed or on terrain."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict

from cavalcade.campaign.samplers.individual_goals import Models, models_in_turn
from cavalcade.campaign.samplers.sampler import DataFolder, Instance, Sampler
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.scenario.commands import Velocity
from cavalcade.scenario.fields import Coordinate, Length, Positive, Speed

Kind = Literal["steady", "random", "push", "rough", "blocks", "stairs", "gap", "step"]

_TAG = 12
_TERRAINS = {"rough": 0.05, "blocks": 0.05, "stairs": 0.08, "gap": 0.0, "step": 0.2}
"""Kinds on terrain and the height of their features, m."""

_DURATIONS = {"steady": 10.0, "random": 20.0, "push": 7.0}
"""s, where nothing else is given."""

_APART, _FREE = 2.0, 2.0
"""Robots' paths, as commanded, keep this distance from each other and from the border, m."""

_CELL, _TERRAIN_CELL = 0.1, 0.02
_GROUND = (6.0, 2.4)
_STAIRS = (7.0, 2.4)
_ENDS = 0.7
"""Terrain: its size, and how far from its ends robots start and stop, m."""

_BEFORE, _BEYOND = (0.8, 1.2), 0.6
"""Robots that leap start so far before the break and are sent so far beyond it, m."""

_FIRST = 0.3
"""Nothing is commanded before, s."""

_HOLDS = (0.3, 2.0)
"""How long a random command holds, s."""

_STILL = 0.1
"""Share of random commands that are to stand."""

_PUSHED = (2.3, 2.8)
"""When the push comes, s, and"""

_STANDING_SHARE = 4
"""every so-manieth robot stands then."""

_ATTEMPTS = 200


class WalkSampler(Sampler):
    """Robots under commands: `steady` at one `velocity` (forwards, to the left, m/s; yaw rate,
    rad/s), towards a random side; `random` velocities up to these, each for 0.3 to 2 s; `push` by
    `impulse`, N s within 0.1 s, to a random side, every fourth robot while it stands, the others
    at a random velocity; straight across `rough` ground, `blocks` or `stairs` with features of
    `height`, m (stairs down if negative), at `speed`, m/s; in one leap over a `gap` of `width`, m,
    or up or down a `step` of `height`.

    Several robots walk at random out of each other's way.
    """

    sampler: Literal["walk"]
    kind: Kind
    velocity: Velocity = (0.5, 0.2, 1.0)
    speed: Speed = 0.4
    height: Coordinate | None = None
    width: Length = 0.3
    impulse: Positive = 25.0
    duration: Positive | None = None
    robots: Annotated[int, Strict(), Field(ge=1, le=16)] = 1
    models: Models = ("go1",)

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """Commands number `seed`."""
        rng = np.random.default_rng([seed, _TAG])
        if self.kind in _TERRAINS:
            return Instance(self._on_terrain(rng, seed), True)
        duration = _DURATIONS[self.kind] if self.duration is None else self.duration
        commands, events, starts, paths = self._commands(rng, seed, duration)
        low = (np.floor((paths.min(axis=(0, 1)) - _FREE) / _CELL) * _CELL).tolist()
        high = (np.ceil((paths.max(axis=(0, 1)) + _FREE) / _CELL) * _CELL).tolist()
        size = [math.ceil((b - a) / _CELL) * _CELL for a, b in zip(low, high, strict=True)]
        world = {
            "empty": {"size": [round(s, 3) for s in size], "origin": [round(v, 3) for v in low]},
            "resolution": _CELL,
        }
        task = {"commands": commands, "duration": duration}
        return Instance(self._scenario(seed, world, starts, task, events), True)

    def _commands(
        self, rng: np.random.Generator, seed: int, duration: float
    ) -> tuple[list[dict[str, Any]], list[dict[str, Any]], Array, Array]:
        """Commands and events as a scenario says them, starts `(N, 3)` and paths `(T, N, 2)`."""
        for _ in range(_ATTEMPTS):
            yaws = rng.uniform(-math.pi, math.pi, self.robots)
            side = math.ceil(math.sqrt(self.robots))
            cells = [(2.0 * _APART * (k % side), 2.0 * _APART * (k // side)) for k in range(99)]
            starts = np.array([[*cells[k], round(float(yaws[k]), 4)] for k in range(self.robots)])
            commands, events = [], []
            for robot in range(self.robots):
                commands += self._commands_of(
                    rng, robot, (seed + robot) % _STANDING_SHARE == 0, duration
                )
                if self.kind == "push":
                    at, side_of = rng.uniform(*_PUSHED), rng.uniform(-math.pi, math.pi)
                    impulse = [
                        round(self.impulse * part, 4)
                        for part in (math.cos(side_of), math.sin(side_of))
                    ]
                    push = {"robot": robot, "impulse": impulse, "duration": 0.1}
                    events.append({"at": round(float(at), 2), "push": push})
            paths = _paths(starts, commands, duration)
            off = paths[:, :, None] - paths[:, None]
            near = np.hypot(off[..., 0], off[..., 1]) + 1e9 * np.eye(self.robots)
            if near.min() >= _APART:
                return commands, events, starts, paths
        raise InputError(f"no paths of {self.robots} robots keep apart", key="robots")

    def _commands_of(
        self, rng: np.random.Generator, robot: int, stands: bool, duration: float
    ) -> list[dict[str, Any]]:
        """The commands of one robot."""
        limits = np.array(self.velocity)
        if self.kind == "steady":
            return [_command(_FIRST, robot, limits)]
        if self.kind == "push":
            return [_command(_FIRST, robot, 0.0 * limits if stands else _random(rng, limits))]
        commands, at = [], _FIRST
        while at < duration:
            still = rng.random() < _STILL
            commands.append(_command(at, robot, 0.0 * limits if still else _random(rng, limits)))
            at += float(rng.uniform(*_HOLDS))
        return commands

    def _on_terrain(self, rng: np.random.Generator, seed: int) -> dict[str, Any]:
        height = _TERRAINS[self.kind] if self.height is None else self.height
        size = _STAIRS if self.kind == "stairs" else _GROUND
        if self.robots > 1:
            raise InputError("one robot at a time walks there", key="robots")
        if self.kind in ("gap", "step"):
            return self._leaping(rng, seed, height)
        source: dict[str, Any] = {"kind": self.kind, "size": list(size), "height": height}
        if self.kind == "stairs":
            source |= {"steps": 5, "tread": 0.35}
        else:
            source |= {"seed": seed}
            source |= {"spacing": 0.3} if self.kind == "rough" else {"side": 0.25}
        middle, way = size[1] / 2.0, size[0] - 2.0 * _ENDS
        across = middle + float(rng.uniform(-0.3, 0.3))
        start = np.array([[_ENDS, round(across, 4), round(float(rng.uniform(-0.1, 0.1)), 4)]])
        to = {"at": _FIRST, "to": [_ENDS + way, middle], "speed": self.speed}
        world = {"generate": source, "resolution": _TERRAIN_CELL}
        scenario = self._scenario(seed, world, start, {"commands": [to]})
        scenario["execution"]["timeout"] = round(1.6 * way / self.speed + 5.0, 3)
        return scenario

    def _leaping(self, rng: np.random.Generator, seed: int, height: float) -> dict[str, Any]:
        """One leap in the middle; robots start askew and at different distances."""
        gap = self.kind == "gap"
        half = self.width / 2.0 if gap else 0.0
        source: dict[str, Any] = {"kind": self.kind, "size": list(_GROUND)}
        source |= {"width": self.width} if gap else {"height": height}
        middle, across = (float(side) / 2.0 for side in _GROUND)
        off = rng.uniform([_BEFORE[0], -0.2, -0.15], [_BEFORE[1], 0.2, 0.15])
        start = np.array([[middle - half - off[0], across + off[1], off[2]]]).round(4)
        leap = {"at": _FIRST, "leap": [round(middle + half + _BEYOND, 4), float(start[0, 1])]}
        world = {"generate": source, "resolution": _TERRAIN_CELL}
        return self._scenario(seed, world, start, {"commands": [leap]})

    def _scenario(
        self,
        seed: int,
        world: Mapping[str, Any],
        starts: Array,
        task: Mapping[str, Any],
        events: Sequence[dict[str, Any]] = (),
    ) -> dict[str, Any]:
        models = models_in_turn(self.models, seed, self.robots)
        return {
            "version": 1,
            "name": f"walk-{self.kind}-{seed}",
            "world": dict(world),
            "robots": [
                {"model": model, "start": [float(value) for value in start]}
                for model, start in zip(models, starts, strict=True)
            ],
            "task": dict(task),
            "execution": {"seed": seed, "events": list(events)},
        }


def _random(rng: np.random.Generator, limits: Array) -> Array:
    return np.asarray(rng.uniform(-1.0, 1.0, 3) * limits)


def _command(at: float, robot: int, velocity: Array) -> dict[str, Any]:
    return {
        "at": round(at, 3),
        "robot": robot,
        "velocity": [round(float(value), 4) + 0.0 for value in velocity],
    }


def _paths(starts: Array, commands: list[dict[str, Any]], duration: float) -> Array:
    """Where ideal robots without inertia would be, every 0.1 s: `(T, N, 2)`."""
    pose, step = starts.copy(), 0.1
    velocity = np.zeros_like(pose)
    due = sorted(commands, key=lambda one: float(one["at"]))
    found = [pose[:, :2].copy()]
    for k in range(math.ceil(duration / step)):
        while due and due[0]["at"] <= k * step:
            one = due.pop(0)
            velocity[one["robot"]] = one["velocity"]
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        pose[:, 0] += step * (c * velocity[:, 0] - s * velocity[:, 1])
        pose[:, 1] += step * (s * velocity[:, 0] + c * velocity[:, 1])
        pose[:, 2] += step * velocity[:, 2]
        found.append(pose[:, :2].copy())
    return np.array(found)
