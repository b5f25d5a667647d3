"""Smallest distances between robots' centres, and from these to obstacles."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from cavalcade.checking.contact import FARTHEST, find_contacts
from cavalcade.checking.motion import bodies
from cavalcade.checking.solids import Scene
from cavalcade.checking.tracks import Track
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel


def pair_distance(tracks: tuple[Track, ...], ticks: Array) -> float:
    """Smallest distance in m of two robots' centres that move evenly; inf for one robot."""
    least = np.inf
    places = [track.at(ticks)[:, :2] for track in tracks]
    for one, two in combinations(places, 2):
        begin, change = (one - two)[:-1], np.diff(one - two, axis=0)
        square = np.maximum((change * change).sum(axis=1), 1e-300)
        part = np.clip(-(begin * change).sum(axis=1) / square, 0.0, 1.0)
        closest = np.hypot(*(begin + part[:, None] * change).T)
        least = min(least, float(closest.min()))
    return least


def obstacle_distance(
    scene: Scene, tracks: tuple[Track, ...], models: tuple[RobotModel, ...], ticks: Array
) -> float:
    """Smallest distance in m of a centre to obstacles, map and border; inf beyond 1 m."""
    points = tuple(replace(model, length=0.0, width=0.0, round=True) for model in models)
    _, gap = find_contacts(scene, bodies(tracks, points, ticks), ticks, among=False)
    return gap if gap < FARTHEST else np.inf
