"""Contact of swept footprints with obstacles, the map, its border and each other.

The team moves on one clock: between two of its ticks everything moves evenly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cavalcade.checking import distance
from cavalcade.checking.report import Kind, Violation
from cavalcade.checking.solids import Scene, Solid
from cavalcade.checking.sweep import TOUCH, Distance, Rows, closest_approach, first_contact
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.robots import RobotModel

FARTHEST = 1.0
"""Gaps are measured up to here, m; larger ones are of no interest."""

Name = tuple[Kind, str]

_MARGINS = (0.1, 0.3, FARTHEST)
"""How far to look, m: as far as it takes to see something."""


@dataclass(frozen=True)
class Body:
    """One robot's footprint over the intervals of the common clock.

    Attributes:
        index: Which robot.
        half: `(2,)` half of its length and of its width, m; zero for a disc.
        begin: `(T, 3)` pose at the start of each interval.
        change: `(T, 3)` change of the pose over it.
        skin: How far the footprint reaches beyond the rectangle of `half` on all sides, m: the
            radius of a disc, otherwise 0.
    """

    index: int
    half: Array
    begin: Array
    change: Array
    skin: float = 0.0

    @property
    def radius(self) -> float:
        """Of the circle around the footprint, m."""
        return float(np.hypot(*self.half)) + self.skin

    @property
    def turning(self) -> Array:
        """`(T,)` bound on how far a point of the footprint moves about the centre, m."""
        return float(np.hypot(*self.half)) * np.abs(self.change[:, 2])

    @property
    def bounds(self) -> Array:
        """`(T, 4)` boxes x0, y0, x1, y1 around all the footprint covers in an interval, m."""
        ends = np.stack((self.begin[:, :2], self.begin[:, :2] + self.change[:, :2]))
        return np.hstack((ends.min(axis=0) - self.radius, ends.max(axis=0) + self.radius))

    def at(self, interval: Rows, fraction: Array) -> Array:
        """Poses `(M, 3)` at fractions `(M,)` of intervals `(M,)`."""
        return self.begin[interval] + fraction[:, None] * self.change[interval]


@dataclass(frozen=True)
class Pairing:
    """One footprint and something it may touch, over some intervals.

    Attributes:
        name: Kind and obstacle as in `Violation`.
        robots: The robots concerned.
        body: The footprint.
        interval: `(M,)` the intervals, in order; one may occur more than once if the other is
            made of several pieces.
        distance: From candidate and fraction of its interval to the distance.
        reach: `(M,)` bound on how far the distance changes over the interval, m.
        lower: `(M,)` quick lower bound of the distance, m.
    """

    name: Name
    robots: tuple[int, ...]
    body: Body
    interval: Rows
    distance: Distance
    reach: Array
    lower: Array


def common_clock(tracks: tuple[Track, ...], solids: tuple[Solid, ...]) -> Array:
    """Ticks `(T + 1,)` in s, at least two.

    They are all samples, and all moments in between at which an obstacle appears, vanishes or
    changes its motion.
    """
    samples = np.unique(np.concatenate([track.time for track in tracks]))
    knots = [np.concatenate((solid.time, (solid.start, solid.end))) for solid in solids]
    extra = np.concatenate(knots) if knots else np.empty(0)
    extra = extra[(extra > samples[0]) & (extra < samples[-1])]
    ticks = np.unique(np.concatenate((samples, extra)))
    return ticks if len(ticks) > 1 else np.repeat(ticks, 2)


def bodies(
    tracks: tuple[Track, ...], models: tuple[RobotModel, ...], ticks: Array
) -> tuple[Body, ...]:
    """The robots' footprints over the intervals between ticks `(T + 1,)`."""
    result = []
    for k, (track, model) in enumerate(zip(tracks, models, strict=True)):
        half, skin = np.array([model.length, model.width]) / 2.0, 0.0
        if model.round:
            half, skin = np.zeros(2), model.length / 2.0
        pose = track.at(ticks)
        result.append(Body(k, half, pose[:-1], np.diff(pose, axis=0), skin))
    return tuple(result)


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
        (kind, obstacle), (first, *others) = pairing.name, pairing.robots
        other = f"robot {others[0]}" if others else obstacle
        text = (
            f"robot {first} touches {other}; robot {first} is at "
            f"({x:.3f}, {y:.3f}) m, {yaw:.3f} rad"
        )
        yield Violation(kind, time, pairing.robots, text, 0.0, 0.0, obstacle)


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
    size, origin = np.array(scene.ground.size), scene.ground.origin
    every = np.arange(len(body.begin))
    centre = inverse_transform_points(origin, body.begin[:, :2] + body.change[:, :2] / 2.0)
    reach = np.hypot(body.change[:, 0], body.change[:, 1]) + body.turning

    def to_border(rows: Rows, fraction: Array) -> Array:
        pose = body.at(rows, fraction)
        pose[:, :2] = inverse_transform_points(origin, pose[:, :2])
        pose[:, 2] -= origin[2]
        corner = distance.corners(pose, body.half)
        inside: Array = np.minimum(corner, size - corner).min(axis=(1, 2)) - body.skin
        return np.maximum(inside, 0.0)

    lower = np.minimum(centre, size - centre).min(axis=1) - body.radius - reach / 2.0
    name: Name = ("robot-map", "border")
    return Pairing(name, (body.index,), body, every, to_border, reach, lower)


def _with_fixed(body: Body, scene: Scene, margin: float) -> Iterator[Pairing]:
    fixed = [solid for solid in scene.solids if not solid.moves]
    path = body.bounds
    if fixed:
        boxes = np.array([solid.bounds for solid in fixed])
        near, which = distance.overlapping(path, boxes, margin)
        for k in np.unique(which):
            solid = fixed[k]
            name: Name = ("robot-obstacle", solid.key)
            yield _with_points(body, near[which == k], solid.points, solid.radius, name)
    if len(scene.blocks):
        boxes = np.hstack((scene.blocks.min(axis=1), scene.blocks.max(axis=1)))
        near, which = distance.overlapping(path, boxes, margin)
        yield _with_points(body, near, scene.blocks[which], 0.0, ("robot-map", "map"))


def _with_points(body: Body, interval: Rows, points: Array, radius: float, name: Name) -> Pairing:
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
    return Pairing(name, (body.index,), body, interval, to_piece, reach, lower)


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
    near = np.flatnonzero(there & (lower <= margin))
    reach, lower = reach[near], lower[near]

    def to_solid(rows: Rows, fraction: Array) -> Array:
        at = near[rows]
        place = before[at] + fraction[:, None] * shift[at]
        seen = distance.seen_from(body.at(at, fraction), solid.points + place[:, None])
        return _footprint_to(body, seen, solid.radius)

    name: Name = ("robot-obstacle", solid.key)
    return Pairing(name, (body.index,), body, near, to_solid, reach, lower)


def _with_robot(one: Body, two: Body, margin: float) -> Pairing:
    relative = one.change[:, :2] - two.change[:, :2]
    reach = np.hypot(relative[:, 0], relative[:, 1]) + one.turning + two.turning
    centre = one.begin[:, :2] - two.begin[:, :2] + relative / 2.0
    lower = np.hypot(centre[:, 0], centre[:, 1]) - one.radius - two.radius - reach / 2.0
    near = np.flatnonzero(lower <= margin)
    reach, lower = reach[near], lower[near]
    skin = one.skin + two.skin

    def to_other(rows: Rows, fraction: Array) -> Array:
        at = near[rows]
        other = distance.corners(two.at(at, fraction), two.half)
        seen = distance.seen_from(one.at(at, fraction), other)
        return np.maximum(distance.to_polygons(one.half, seen) - skin, 0.0)

    robots = (one.index, two.index)
    return Pairing(("robot-robot", ""), robots, one, near, to_other, reach, lower)


def _footprint_to(body: Body, seen: Array, radius: float) -> Array:
    """Distance `(M,)` of what is seen at points `(M, P, 2)`: a disc if P is 1."""
    if seen.shape[1] == 1:
        return np.maximum(distance.to_points(body.half, seen[:, 0]) - radius - body.skin, 0.0)
    return np.maximum(distance.to_polygons(body.half, seen) - body.skin, 0.0)
