"""Recorded motion of robots that followed commands: whether they end where they were sent."""

from __future__ import annotations

import math

from cavalcade.checking.report import Violation
from cavalcade.checking.tracks import Track
from cavalcade.scenario import Scenario

AWAY = 0.25
"""A robot that was sent to a point ends no farther from it than this, m; it stands as soon as it is
within 0.10 m, and its stopping distance and sway are left to it."""


def check_commands(scenario: Scenario, tracks: tuple[Track, ...]) -> list[Violation]:
    """What contradicts the claim that the task is done.

    It has lasted as long as it should, and every robot ends where it was sent last, if anywhere.
    """
    task = scenario.task
    end = max(float(track.time[-1]) for track in tracks)
    length = task.length - 1e-6
    result = []
    if end < length:
        text = f"the task claims to be done after {end:.2f} s of {task.length:.2f} s"
        result.append(Violation("arrival", end, tuple(range(len(tracks))), text, end, length))
    places: list[tuple[float, float] | None] = [None] * len(tracks)
    for command in task.commands or ():
        for robot in range(len(tracks)):
            if command.robot is None or command.robot == robot:
                places[robot] = command.to
    for robot, (place, track) in enumerate(zip(places, tracks, strict=True)):
        away = 0.0 if place is None else math.dist(place, track.pose[-1, :2])
        if away > AWAY:
            text = f"robot {robot} claims to have arrived but ends {away:.3f} m from its point"
            result.append(Violation("arrival", end, (robot,), text, away, AWAY))
    return result
