"""Ways in and out of places in which a body can hardly turn, such as along a wall.

Searches turn by steps that are too large there. A lead turns as far as the body can and goes
straight on, and again, until there is room.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cavalcade.geometry import Array
from cavalcade.lattice.collision import Scene, move_free
from cavalcade.lattice.primitives import DURATION, LENGTH, TURN, make_move

_TURNS = tuple(math.pi / 8.0 * 0.5**k for k in range(9))
"""Turns to try, the largest first, rad: who can make that one to both sides has room."""

_LENGTHS = (0.25, 0.5, 1.0, 2.0, 4.0, -0.25, -0.5, -1.0, -2.0)
"""Of straight moves, forwards rather than backwards, m."""

_STEPS = 4
"""Turns and straight moves at most."""


def has_room(scene: Scene, pose: Array) -> bool:
    """Whether the body can turn at the pose (x, y, yaw) as searches make it turn."""
    return _room(scene, pose) == _TURNS[0]


def lead_from(scene: Scene, pose: Array, way: float) -> tuple[Array, Array]:
    """Moves `(M, 6)` that lead out of a pose (way 1) or into it (way -1), and their other end.

    There are none if there is room already, or none is found.
    """
    nowhere = np.zeros((0, 6)), np.array(pose, dtype=float)
    rows: list[Array] = []
    place, room = np.array(pose, dtype=float), _room(scene, pose)
    for _ in range(_STEPS):
        if room == _TURNS[0]:
            break
        found = max(_onwards(scene, place, way), key=lambda one: one[0], default=(0.0, None, None))
        if found[1] is None or found[0] <= room:
            return nowhere
        room, turn_and_go, place = found[0], found[1], found[2]
        rows = [*rows, *turn_and_go] if way > 0.0 else [*turn_and_go[::-1], *rows]
    return (np.array(rows), place) if rows and room == _TURNS[0] else nowhere


def lead_free(scene: Scene, start: Array, moves: Array, t: float) -> bool:
    """Whether turns and straight moves `(M, 6)` from `start` at time `t` meet nothing."""
    x, y, yaw = (float(value) for value in start)
    for move in moves:
        if not move_free(scene, (x, y, yaw), move, t, False):
            return False
        yaw += move[TURN]
        x += move[LENGTH] * math.cos(yaw)
        y += move[LENGTH] * math.sin(yaw)
        t += move[DURATION]
    return True


def _onwards(scene: Scene, pose: Array, way: float) -> Iterator[tuple[float, list[Array], Array]]:
    """How much room there is after a turn and a straight move, these, and where that is."""
    x, y, yaw = pose
    turns = [0.0]
    for sign in (1.0, -1.0):
        turns += [sign * turn for turn in _TURNS if _turns(scene, pose, sign * turn)][:1]
    for length in _LENGTHS:
        back = scene.limits.backwards
        if length < 0.0 and back <= 0.0:
            continue
        pieces = max(1, math.ceil(-length / back)) if length < 0.0 else 1
        go = [_move(scene, length / pieces, 0.0)] * pieces
        for turn in turns:
            c, s = math.cos(yaw + turn), math.sin(yaw + turn)
            there = np.array([x + way * length * c, y + way * length * s, yaw + turn])
            begin = np.array([x, y, yaw + turn]) if way > 0.0 else there
            if lead_free(scene, begin, np.array(go), 0.0):
                moves = go if turn == 0.0 else [_move(scene, 0.0, way * turn), *go]
                yield _room(scene, there), moves, there


def _room(scene: Scene, pose: Array) -> float:
    """By how much the body can turn to both sides, rad."""
    for turn in _TURNS:
        if _turns(scene, pose, turn) and _turns(scene, pose, -turn):
            return turn
    return 0.0


def _turns(scene: Scene, pose: Array, turn: float) -> bool:
    x, y, yaw = (float(value) for value in pose)
    return bool(move_free(scene, (x, y, yaw), _move(scene, 0.0, turn), 0.0, False))


def _move(scene: Scene, length: float, turn: float) -> Array:
    """From rest to rest."""
    move = np.zeros(6)
    limits = scene.limits
    speed = limits.speed if length >= 0.0 else limits.backward_speed
    make_move(move, length, turn, 0.0, 0.0, speed, limits)
    return move
