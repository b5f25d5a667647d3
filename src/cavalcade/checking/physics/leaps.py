"""Where the ground breaks on a robot's way, and whether it leapt that as it should.

A leap is judged strictly, from one robot's recording alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cavalcade.checking.ground import Floor
from cavalcade.checking.heights import Heights, floor_of
from cavalcade.checking.physics.contacts import BODY, hidden_contacts
from cavalcade.checking.physics.feet import TOUCHING
from cavalcade.checking.physics.kinematics import posture
from cavalcade.checking.physics.record import RobotRecord
from cavalcade.checking.physics.rotations import roll_pitch_yaw
from cavalcade.checking.physics.touching import ground_overlaps
from cavalcade.checking.report import Violation, broken, stretches
from cavalcade.geometry import Array
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.scenario import Scenario

SUNK = 0.05
"""No foot is further below the surface on either side, m."""

PITCH = 0.5
"""Largest pitch either way, rad, from the flight's beginning to the end."""

STABLE = 1.5
"""Seconds of standing or trotting after touch-down."""

LANDED = 0.02
"""A foot that carries has landed if its bottom is within this of the surface beyond, m."""

TILT, LOW = 0.5, 0.4
"""Meanwhile the trunk is tilted by less, rad, and higher than this part of its standing height
over the surface beyond: legs give way when they land."""

SETTLED, HIGH = 0.5, 0.6
"""From so long after touch-down, s, it is higher than this part."""

BREAK, LEVEL = 0.05, 0.02
"""Ground that differs by more from that at the end of the way is a break; it ends where the ground
differs by less than the second from there on, m."""

SIDE, GRAIN = 0.15, 0.005
"""Ways beside it tell how the break lies, m; they are looked at every so many m."""

ENDS = 0.1
"""The first and last part of a way are its sides of the break, m."""


@dataclass(frozen=True)
class Leap:
    """What is to be leapt: a gap, or a step.

    Attributes:
        edge: A point `(x, y)` of the far edge of the gap, or of the step's edge, m.
        heading: In which direction that is crossed, rad.
        before, beyond: Heights of the surfaces on both sides, m.
        begin: When the take-off begins, s of the recording.
    """

    edge: tuple[float, float]
    heading: float
    before: float = 0.0
    beyond: float = 0.0
    begin: float = 0.0

    def past(self, places: Array) -> Array:
        """How far `(...)` places `(..., 2)` are past the edge, m; negative before it."""
        direction = np.array([np.cos(self.heading), np.sin(self.heading)])
        return (places - np.array(self.edge)) @ direction


@dataclass(frozen=True)
class LeapVerdict:
    """Whether a leap succeeded.

    Attributes:
        ok: All of it.
        reason: What it fails by, one line; empty if it succeeds.
        flight: Seconds without any foot on the ground, the longest time.
        touch_down: When the last foot landed beyond, s; nan if it never did.
        lowest: Of all feet below the surfaces, m; negative above.
        pitch: Largest either way, rad.
    """

    ok: bool
    reason: str
    flight: float
    touch_down: float
    lowest: float
    pitch: float


def judge_leap(
    record: RobotRecord, description: QuadrupedDescription, leap: Leap, floor: Floor
) -> LeapVerdict:
    """Judge a leap by the strict criterion.

    All feet land beyond the edge and carry there; none is ever further than `SUNK` below the
    surfaces; trunk, hips and thighs touch nothing, by the recording and by geometry; the pitch
    stays below `PITCH`; and after the touch-down of the last foot the robot stays up for `STABLE`
    s, all feet past the edge.

    Args:
        record: From before the take-off to at least `STABLE` s after the touch-down.
        description: Of the robot.
        leap: What is to be leapt.
        floor: The ground, for contacts by geometry.
    """
    links = posture(record, description, floor=floor)
    late = record.time >= leap.begin
    past = leap.past(links.feet[..., :2])
    carries = record.forces[..., 2] > TOUCHING
    flying = stretches(late & ~carries.any(axis=1))
    flights = [float(record.time[end - 1] - record.time[max(k - 1, 0)]) for k, end in flying]
    bottom = links.feet[..., 2] - links.radius
    landed = late[:, None] & carries & (past > 0.0) & (np.abs(bottom - leap.beyond) < LANDED)
    touch_down = math.nan
    if landed.any(axis=0).all():  # when the last of the four feet lands for the first time
        touch_down = float(record.time[landed.argmax(axis=0)].max())
    surface = np.where(past > 0.0, leap.beyond, min(leap.before, leap.beyond))
    sunk = float((surface - bottom)[late].max(initial=-np.inf))
    pitch = float(np.abs(roll_pitch_yaw(record.turn)[late, 1]).max(initial=0.0))

    def verdict(reason: str) -> LeapVerdict:
        return LeapVerdict(not reason, reason, max(flights, default=0.0), touch_down, sunk, pitch)

    if not np.isfinite(touch_down):
        feet = int(landed.any(axis=0).sum())
        return verdict(f"only {feet} feet touch down beyond the edge")
    if sunk > SUNK:
        return verdict(f"a foot is {sunk:.3f} m below the surface")
    body = [touch for touch in record.touches if touch.part in BODY and touch.time >= leap.begin]
    if body:
        return verdict(f"the {body[0].part} touches the {body[0].other} at {body[0].time:.2f} s")
    hidden = hidden_contacts(record, ground_overlaps(links, description, floor))
    unsaid = [violation.message for violation in hidden if violation.time >= leap.begin]
    if unsaid:
        return verdict(unsaid[0])
    if pitch >= PITCH:
        return verdict(f"the trunk is pitched by {pitch:.2f} rad")
    if record.time[-1] < touch_down + STABLE - 1e-9:
        return verdict(f"the recording ends {record.time[-1] - touch_down:.2f} s after touch-down")
    after = (record.time >= touch_down) & (record.time <= touch_down + STABLE + 1e-9)
    if (past[after] <= 0.0).any():
        return verdict("a foot is back before the edge after touch-down")
    height = record.base[after, 2] - leap.beyond
    tilt = np.arccos(np.clip(record.turn[after, 2, 2], -1.0, 1.0))
    least = np.where(record.time[after] < touch_down + SETTLED, LOW, HIGH)
    if tilt.max() > TILT or (height < least * description.stand_height).any():
        return verdict("it does not stay up after touch-down")
    return verdict("")


def find_leap(ground: Floor, start: Array, end: Array, begin: float) -> Leap | None:
    """What is to be leapt on a straight way; None where the ground does not break.

    The way goes from `start` to `end`, `(2,)` m; the take-off begins at `begin` s at the earliest.
    """
    way = end - start
    length = math.hypot(*way)
    if length < 2.0 * ENDS:
        return None
    along = way / length
    side = np.array([-along[1], along[0]])
    marks = np.arange(0.0, length, GRAIN)
    offsets = np.array([-SIDE, 0.0, SIDE])
    places = start + marks[:, None, None] * along + offsets[:, None] * side
    heights = ground.heights_at(places)
    beyond = np.median(heights[marks > length - ENDS], axis=0)
    before = float(np.median(heights[marks < ENDS, 1]))
    if (np.abs(heights - beyond) <= BREAK).all():
        return None
    off = np.abs(heights - beyond) > LEVEL
    far = [float(marks[column].max()) + GRAIN if column.any() else 0.0 for column in off.T]
    turn = -math.atan((far[2] - far[0]) / (2.0 * SIDE))
    edge = start + far[1] * along
    heading = math.atan2(along[1], along[0]) + turn
    return Leap((float(edge[0]), float(edge[1])), heading, before, float(beyond[1]), begin)


def check_leaps(
    scenario: Scenario, records: Sequence[RobotRecord], heights: Heights | None
) -> list[Violation]:
    """Leaps that robots were commanded, by the strict criterion of `judge_leap`."""
    result: list[Violation] = []
    for record, model in zip(records, scenario.models, strict=True):
        own = [one for one in scenario.task.commands or () if one.robot in (None, record.robot)]
        ends = [*(one.at for one in own[1:]), math.inf]
        for command, end in zip(own, ends, strict=True):
            if command.leap is None or heights is None or model.description is None:
                continue
            part = _between(record, command.at, end)
            point = np.array(command.leap)
            reason = leap_reason(part, model.description, heights, point, command.at)
            if reason:
                text = f"robot {record.robot} does not leap as it should: {reason}"
                result.append(broken("leap", command.at, record.robot, text, 0.0, 1.0))
    return result


def leap_reason(
    record: RobotRecord,
    description: QuadrupedDescription,
    heights: Heights,
    end: Array,
    begin: float,
) -> str:
    """What the leap of a robot from where it is at `begin` s towards a point fails by; else empty.

    Also of a way without a break, and of a run that ended before, there is nothing to say.
    """
    if not len(record.time):
        return ""
    first = int(np.searchsorted(record.time, begin))
    start = record.base[min(first, len(record.time) - 1), :2]
    around = np.concatenate([record.base[:, :2], [end]])
    ground = floor_of(heights, around)
    leap = find_leap(ground, start, end, begin)
    return "" if leap is None else judge_leap(record, description, leap, ground).reason


def _between(record: RobotRecord, begin: float, end: float) -> RobotRecord:
    """The part of a record up to `end` s, from a moment before `begin` on."""
    chosen = (record.time >= begin - 0.1) & (record.time <= end)
    names = ("time", "base", "joints", "rates", "torques", "forces")
    touches = tuple(touch for touch in record.touches if begin - 0.1 <= touch.time <= end)
    return replace(record, touches=touches, **{k: getattr(record, k)[chosen] for k in names})
