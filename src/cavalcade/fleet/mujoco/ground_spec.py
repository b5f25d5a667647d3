"""The ground and its obstacles as parts of a MuJoCo specification."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.ground import Block, PhysicsGround
from cavalcade.world import Terrain

WORLD_TYPE, WORLD_AFFINITY = 1, 0
"""Bits of the ground and obstacles, which do not touch each other; see `robot_spec.robot_bits`."""

AWAY = (0.0, 0.0, -1000.0)
"""Where obstacles are that are not there, m."""

_LEAST, _BODIES = 3, 50
"""Blocks that share a body, at least, and bodies that all blocks make, about, at most."""

_LEVEL = 1e-6
"""Terrain with smaller differences of height is a plane, m."""


def add_ground(spec: Any, ground: PhysicsGround) -> None:
    """Add the ground as the geom `ground` and the obstacles to the world of `spec`.

    Movable obstacles are bodies `obstacle_0`, `obstacle_1`, … whose displacement is the place of
    the body; they are `AWAY` at first.
    """
    world = spec.worldbody
    if ground.terrain is None or np.ptp(ground.terrain.height) < _LEVEL:
        level = 0.0 if ground.terrain is None else float(ground.terrain.height.mean())
        plane = load_mujoco().mjtGeom.mjGEOM_PLANE
        geom = world.add_geom(type=plane, size=(0.0, 0.0, 1.0), pos=(0.0, 0.0, level))
    else:
        geom = _add_terrain(spec, ground.terrain)
    geom.name = "ground"
    geom.rgba = (0.55, 0.56, 0.54, 1.0)
    _finish(geom)
    for group in clusters(ground.fixed):
        body = world.add_body()
        for block in group:
            _add_block(body, block)
    for number, group in enumerate(ground.movable):
        body = world.add_body(name=f"obstacle_{number}", pos=AWAY, mocap=True)
        for block in group:
            _add_block(body, block)


def clusters(blocks: Sequence[Block]) -> list[tuple[Block, ...]]:
    """Blocks in groups of neighbours, one body each, always the same for the same blocks.

    MuJoCo looks at bodies first and at the shapes of those that may meet then. With all blocks in
    one body every link of every robot is compared with many of them; with each in its own every
    step walks through hundreds of bodies. Measured with four robots, the best of both took a
    third to a half less time than either.
    """
    return _split(tuple(blocks), max(_LEAST, math.ceil(len(blocks) / _BODIES)))


def _split(blocks: tuple[Block, ...], size: int) -> list[tuple[Block, ...]]:
    """Halved across their longer extent until no group is larger than `size`."""
    if len(blocks) <= size:
        return [blocks] if blocks else []
    spread = np.ptp([block.pose[:2] for block in blocks], axis=0)
    axis = int(np.argmax(spread))
    ordered = tuple(sorted(blocks, key=lambda block: block.pose[axis]))
    half = len(ordered) // 2
    return [*_split(ordered[:half], size), *_split(ordered[half:], size)]


def _add_terrain(spec: Any, terrain: Terrain) -> Any:
    """A heightfield with a vertex at every cell's centre and one more row around.

    MuJoCo's rows run along its y from low to high, as ours do, and its first and last vertices
    stand on the field's edge. The added row has the height of the nearest cell, so that the
    ground reaches half a cell beyond the terrain's edge.
    """
    heights = np.pad(terrain.height, 1, mode="edge")
    rows, cols = heights.shape
    low, high = float(heights.min()), float(heights.max())
    cell = terrain.resolution
    spec.add_hfield(
        name="ground",
        nrow=rows,
        ncol=cols,
        size=((cols - 1) * cell / 2.0, (rows - 1) * cell / 2.0, high - low, 0.5),
        userdata=((heights - low) / (high - low)).ravel(),
    )
    x, y, yaw = terrain.origin
    width, height = terrain.size
    c, s = math.cos(yaw), math.sin(yaw)
    return spec.worldbody.add_geom(
        type=load_mujoco().mjtGeom.mjGEOM_HFIELD,
        hfieldname="ground",
        pos=(x + (c * width - s * height) / 2.0, y + (s * width + c * height) / 2.0, low),
        quat=_yawed(yaw),
    )


def _add_block(body: Any, block: Block) -> None:
    kinds = load_mujoco().mjtGeom
    x, y, yaw = block.pose
    half = (block.top - block.bottom) / 2.0
    box = block.kind == "box"
    geom = body.add_geom(
        type=kinds.mjGEOM_BOX if box else kinds.mjGEOM_CYLINDER,
        size=(*block.half, half) if box else (block.half[0], half, 0.0),
        pos=(x, y, (block.top + block.bottom) / 2.0),
        quat=_yawed(yaw),
        rgba=(0.45, 0.40, 0.36, 1.0),
    )
    _finish(geom)


def _finish(geom: Any) -> None:
    geom.contype, geom.conaffinity = WORLD_TYPE, WORLD_AFFINITY
    geom.condim = 3


def _yawed(yaw: float) -> tuple[float, float, float, float]:
    return (math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0))
