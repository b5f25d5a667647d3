"""Contact of swept footprints with obstacles, the map, its border and each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cavalcade.checking import distance
from cavalcade.checking.motion import Body
from cavalcade.checking.report import Kind, Violation
from cavalcade.checking.solids import Scene, Solid
from cavalcade.checking.sweep import TOUCH, Distance, Rows, closest_approach, first_contact
from cavalcade.geometry import Array, inverse_transform_points

FARTHEST = 1.0
"""Gaps are measured up to here, m; larger ones are of no interest."""

_MARGINS = (0.1, 0.3, FARTHEST)
"""How far to look, m: as far as it takes to see something."""


@dataclass(frozen=True)
class Pairing:
    """One footprint and something it may touch, over some intervals.

    Attributes:
        kind, robots, obstacle: As in `Violation`.
        body: The footprint.
        interval: `(M,)` the intervals, in order; one may occur more than once if the other is
            made of several pieces.
        distance: From candidate and fraction of its interval to the distance.
        reach: `(M,)` bound on how far the distance changes over the interval, m.
        lower: `(M,)` quick lower bound of the distance, m.
    """

    kind: Kind
    robots: tuple[int, ...]
    obstacle: str
    body: Body
    interval: Rows
    distance: Distance
    reach: Array
    lower: Array


def find_contacts(
    scene: Scene, team: tuple[Body, ...], ticks: Array, among: bool = True
) -> tuple[list[Violation], float]:
    """Every contact, and the smallest gap in m, at most `FARTHEST`.

    A contact that lasts is one violation, at its first moment. The intervals end at `ticks`
    `(T + 1,)` s; robots are seen by each other only if they are `among` what may be touched.
    """
    for margin in _MARGINS:
        violations: list[Violation] = []
        gap = FARTHEST
        for pairing in _pairings(scene, team, ticks, margin, among):
            found = closest_approach(pairing.distance, pairing.reach, pairing.lower, gap)
            gap = found.gap
            if len(found.contact):
                violations += _events(pairing, found.contact, found.fraction, ticks)
        if gap <= margin:
            break
    return violations, 0.0 if gap <= TOUCH else gap


def _events(pairing: Pairing, contact: Rows, fraction: Array, ticks: Array) -> Iterator[Violation]:
    """One violation per run of intervals in contact."""
    order = np.argsort(pairing.interval[contact], kind="stable")
    contact, fraction = contact[order], fraction[order]
    interval = pairing.interval[contact]
    starts = np.flatnonzero(np.diff(interval, prepend=-2) > 1)
    for k in starts:
        # Of the pieces touched in this interval the first one counts.
        same = interval == interval[k]
        moment = min(
            first_contact(pairing.distance, float(pairing.reach[row]), int(row), seen)
            for row, seen in zip(contact[same], fraction[same], strict=True)
        )
        begin, end = ticks[interval[k]], ticks[interval[k] + 1]
        time = float(begin + moment * (end - begin))
        x, y, yaw = pairing.body.at(interval[k : k + 1], np.array([moment]))[0]
        first = pairing.robots[0]
        other = f"robot {pairing.robots[1]}" if len(pairing.robots) > 1 else pairing.obstacle
        text = (
            f"robot {first} touches {other}; robot {first} is at "
            f"({x:.3f}, {y:.3f}) m, {yaw:.3f} rad"
        )
        yield Violation(pairing.kind, time, pairing.robots, text, 0.0, 0.0, pairing.obstacle)


def _pairings(
    scene: Scene, team: tuple[Body, ...], ticks: Array, margin: float, among: bool
) -> Iterator[Pairing]:
    for body in team:
        yield _with_border(body, scene)
        yield from _with_fixed(body, scene, margin)
        for solid in scene.solids:
            if solid.moves:
                yield _with_moving(body, solid, ticks, margin)
    for one, two in combinations(team, 2) if among else ():
        yield _with_robot(one, two, margin)


def _with_border(body: Body, scene: Scene) -> Pairing:
    size, yaw = np.array(scene.size), scene.origin[2]
    every = np.arange(len(body.begin))
    centre = inverse_transform_points(scene.origin, body.begin[:, :2] + body.change[:, :2] / 2.0)
    reach = np.hypot(body.change[:, 0], body.change[:, 1]) + body.turning

    def to_border(rows: Rows, fraction: Array) -> Array:
        pose = body.at(rows, fraction)
        pose[:, :2] = inverse_transform_points(scene.origin, pose[:, :2])
        pose[:, 2] -= yaw
        corner = distance.corners(pose, body.half)
        inside: Array = np.minimum(corner, size - corner).min(axis=(1, 2)) - body.skin
        return np.maximum(inside, 0.0)

    lower = np.minimum(centre, size - centre).min(axis=1) - body.radius - reach / 2.0
    return Pairing("robot-map", (body.index,), "border", body, every, to_border, reach, lower)


def _with_fixed(body: Body, scene: Scene, margin: float) -> Iterator[Pairing]:
    fixed = [solid for solid in scene.solids if not solid.moves]
    path = body.bounds
    if fixed:
        near, which = distance.overlapping(
            path, np.array([solid.bounds for solid in fixed]), margin
        )
        for k in np.unique(which):
            solid = fixed[k]
            name: tuple[Kind, str] = ("robot-obstacle", solid.key)
            yield _with_points(body, near[which == k], solid.points, solid.radius, name)
    if len(scene.blocks):
        boxes = np.hstack((scene.blocks.min(axis=1), scene.blocks.max(axis=1)))
        near, which = distance.overlapping(path, boxes, margin)
        yield _with_points(body, near, scene.blocks[which], 0.0, ("robot-map", "map"))


def _with_points(
    body: Body, interval: Rows, points: Array, radius: float, name: tuple[Kind, str]
) -> Pairing:
    """With something that stays: `points` `(P, 2)`, or `(M, P, 2)` one piece per interval."""
    change = body.change[interval]
    reach = np.hypot(change[:, 0], change[:, 1]) + body.turning[interval]
    pieces = points if points.ndim == 3 else np.broadcast_to(points, (len(interval), *points.shape))

    def to_piece(rows: Rows, fraction: Array) -> Array:
        seen = distance.seen_from(body.at(interval[rows], fraction), pieces[rows])
        return _footprint_to(body, seen, radius)

    low, high = pieces.min(axis=1), pieces.max(axis=1)
    centre = body.begin[interval, :2] + change[:, :2] / 2.0
    away = np.maximum(np.maximum(low - centre, centre - high), 0.0)
    lower = np.hypot(away[:, 0], away[:, 1]) - radius - body.radius - reach / 2.0
    kind, key = name
    return Pairing(kind, (body.index,), key, body, interval, to_piece, reach, lower)


def _with_moving(body: Body, solid: Solid, ticks: Array, margin: float) -> Pairing:
    middle = (ticks[:-1] + ticks[1:]) / 2.0
    before, after = solid.offset_at(ticks[:-1]), solid.offset_at(ticks[1:])
    shift = after - before
    relative = body.change[:, :2] - shift
    reach = np.hypot(relative[:, 0], relative[:, 1]) + body.turning
    low, high = solid.points.min(axis=0) + before, solid.points.max(axis=0) + before
    centre = body.begin[:, :2] + relative / 2.0
    away = np.maximum(np.maximum(low - centre, centre - high), 0.0)
    lower = np.hypot(away[:, 0], away[:, 1]) - solid.radius - body.radius - reach / 2.0
    there = (middle >= solid.start) & (middle < solid.end)
    interval = np.flatnonzero(there & (lower <= margin))

    def to_solid(rows: Rows, fraction: Array) -> Array:
        at = interval[rows]
        place = before[at] + fraction[:, None] * shift[at]
        seen = distance.seen_from(body.at(at, fraction), solid.points + place[:, None])
        return _footprint_to(body, seen, solid.radius)

    return Pairing(
        "robot-obstacle",
        (body.index,),
        solid.key,
        body,
        interval,
        to_solid,
        reach[interval],
        lower[interval],
    )


def _with_robot(one: Body, two: Body, margin: float) -> Pairing:
    relative = one.change[:, :2] - two.change[:, :2]
    reach = np.hypot(relative[:, 0], relative[:, 1]) + one.turning + two.turning
    centre = one.begin[:, :2] - two.begin[:, :2] + relative / 2.0
    lower = np.hypot(centre[:, 0], centre[:, 1]) - one.radius - two.radius - reach / 2.0
    interval = np.flatnonzero(lower <= margin)
    skin = one.skin + two.skin

    def to_other(rows: Rows, fraction: Array) -> Array:
        at = interval[rows]
        other = distance.corners(two.at(at, fraction), two.half)
        seen = distance.seen_from(one.at(at, fraction), other)
        return np.maximum(distance.to_polygons(one.half, seen) - skin, 0.0)

    return Pairing(
        "robot-robot",
        (one.index, two.index),
        "",
        one,
        interval,
        to_other,
        reach[interval],
        lower[interval],
    )


def _footprint_to(body: Body, seen: Array, radius: float) -> Array:
    """Distance `(M,)` of what is seen at points `(M, P, 2)`: a disc if P is 1."""
    if seen.shape[1] == 1:
        return np.maximum(distance.to_points(body.half, seen[:, 0]) - radius - body.skin, 0.0)
    return np.maximum(distance.to_polygons(body.half, seen) - body.skin, 0.0)
