"""`plan.npz`: one robot's planned motion, read from arrays and nothing that could run code.

What is judged is complete, finite and in order of time.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from cavalcade.checking.report import Kind, Violation, broken, excesses
from cavalcade.checking.tracks import Track
from cavalcade.errors import RecordingError
from cavalcade.geometry import Array
from cavalcade.robots import RobotModel

WALK, TAKE_OFF, FLIGHT, LANDING = 0, 1, 2, 3
NAMES = ("walk", "take-off", "flight", "landing")

SPEED_ROUNDING = 1e-4
"""Of velocities, and of changes of position per interval's time, m/s or rad/s."""

POSITION_ROUNDING = 2e-5
"""Of changes of position, m."""

LONGEST_STEP = 0.03
"""Between two samples, s."""

_SHAPES = {"t": (), "position": (3,), "velocity": (3,), "yaw": (), "phase": ()}
_KEY = re.compile(rf"({'|'.join(_SHAPES)}|footholds)_(\d+)")
_LARGEST = 1e6
_TINY = 1e-6
_MOST_BYTES = 2_000_000_000

_FOLLOWS = {
    WALK: (WALK, TAKE_OFF),
    TAKE_OFF: (TAKE_OFF, FLIGHT),
    FLIGHT: (FLIGHT, LANDING),
    LANDING: (LANDING, WALK, TAKE_OFF),
}
"""What may come after each phase; one leap may follow another."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples that are complete, finite and in order of time; afterwards the robot stands.

    Attributes:
        robot: Which.
        time: `(T,)` s, from 0.
        position, velocity: `(T, 3)` m and m/s, map frame.
        yaw: `(T,)` rad, without jumps.
        phase: `(T,)` of the motion from this sample to the next.
        footholds: `(M, 6)` t_down, t_up, leg, x, y, z; s and m.
    """

    robot: int
    time: Array
    position: Array
    velocity: Array
    yaw: Array
    phase: NDArray[np.int64]
    footholds: Array

    @property
    def steps(self) -> Array:
        """`(T - 1,)` time between samples, s."""
        return np.diff(self.time)

    @property
    def speed(self) -> Array:
        """`(T,)` seen from above, m/s."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])

    @property
    def mean_velocity(self) -> Array:
        """`(T - 1, 2)` over each interval, from positions, m/s."""
        return np.diff(self.position[:, :2], axis=0) / self.steps[:, None]

    @property
    def acceleration(self) -> Array:
        """`(T - 1, 3)` mean over each interval, m/s²."""
        return np.diff(self.velocity, axis=0) / self.steps[:, None]

    @property
    def yaw_rate(self) -> Array:
        """`(T - 1,)` mean over each interval, rad/s."""
        return np.diff(self.yaw) / self.steps

    @property
    def track(self) -> Track:
        """The motion seen from above."""
        return Track(self.time, np.column_stack((self.position[:, :2], self.yaw)))

    def phase_at(self, time: float) -> int:
        """The phase at a time in s; walking, which includes standing, outside the plan."""
        if not self.time[0] <= time < self.time[-1]:
            return WALK
        return int(self.phase[np.searchsorted(self.time, time, side="right") - 1])

    def excesses(
        self,
        kind: Kind,
        value: Array,
        limit: Array | float,
        words: str,
        slack: Array | float = 0.0,
        *,
        excess: Array | None = None,
    ) -> list[Violation]:
        """As `report.excesses`, of values at samples `(T,)` or over intervals `(T - 1,)`."""
        time = self.time[: len(value)]
        return excesses(kind, self.robot, time, value, limit, words, slack, excess=excess)


def read_plan(path: str | Path) -> dict[str, NDArray[Any]]:
    """All arrays of a `plan.npz`, by name, as they are.

    Raises:
        RecordingError: The file is missing, damaged, too large or holds other things than plain
            arrays.
    """
    path = Path(path)
    if not path.is_file():
        raise RecordingError("there is no such file", file=path)
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise RecordingError(f"{size} bytes of arrays are too many", file=path)
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except RecordingError:
        raise
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise RecordingError(f"cannot be read: {reason}", file=path) from error
    except Exception as error:
        # A damaged archive surfaces as whatever the unpacking tripped over.
        raise RecordingError(f"not a readable NPZ file ({error})", file=path) from error


def read_motions(
    arrays: Mapping[str, NDArray[Any]], models: tuple[RobotModel, ...]
) -> tuple[tuple[Motion | None, ...], list[Violation]]:
    """The robots' motions, None where there is none that could be judged; and what is wrong.

    A robot without any array is no violation here: a plan that was not found may lack some.
    """
    violations: list[Violation] = []
    known = range(len(models))
    numbers = {int(match[2]) for name in arrays if (match := _KEY.fullmatch(name))}
    for robot in sorted(numbers - set(known)):
        text = f"there is motion of robot {robot}; the scenario has {len(models)} robots"
        violations.append(Violation("plan", 0.0, (robot,), text, robot, len(models) - 1))
    motions: list[Motion | None] = []
    for robot, model in enumerate(models):
        motion = None
        if robot in numbers:
            wrong = _malformed(arrays, robot, model)
            if wrong is None:
                motion = _motion(arrays, robot)
                wrong = _disordered(motion)
            if wrong is not None:
                violations.append(wrong)
                motion = None
        motions.append(motion)
    for motion, model in zip(motions, models, strict=True):
        if motion is not None:
            violations += _long_steps(motion) + _odd_phases(motion, model)
    return tuple(motions), violations


def _malformed(
    arrays: Mapping[str, NDArray[Any]], robot: int, model: RobotModel
) -> Violation | None:
    """The first array of a robot that cannot be used."""

    def bad(text: str) -> Violation:
        return broken("plan", 0.0, robot, f"robot {robot}: {text}")

    count = None
    for name, rest in _SHAPES.items():
        key = f"{name}_{robot}"
        if key not in arrays:
            return bad(f"there is no {key}")
        array = arrays[key]
        if array.dtype.kind not in "fiu":
            return bad(f"{key} holds no numbers")
        if array.ndim != 1 + len(rest) or array.shape[1:] != rest or not len(array):
            expected = f"(T, {rest[0]})" if rest else "(T,)"
            return bad(f"{key} has the shape {array.shape}, expected {expected}")
        count = len(array) if count is None else count
        if len(array) != count:
            return bad(f"{key} has {len(array)} samples, t_{robot} has {count}")
        if not _measured(array):
            return bad(f"{key} is not finite or beyond all measure")
    key = f"footholds_{robot}"
    if key not in arrays:
        return bad(f"there is no {key}") if model.drive == "legged" else None
    array = arrays[key]
    if array.dtype.kind not in "fiu" or array.ndim != 2 or array.shape[1] != 6:
        return bad(f"{key} has the shape {array.shape}, expected (M, 6)")
    return None if _measured(array) else bad(f"{key} is not finite or beyond all measure")


def _measured(array: NDArray[Any]) -> bool:
    # Written so that nan is bad too.
    return bool((np.abs(array.astype(float)) < _LARGEST).all())


def _motion(arrays: Mapping[str, NDArray[Any]], robot: int) -> Motion:
    def table(name: str) -> NDArray[np.float64]:
        return np.asarray(arrays[f"{name}_{robot}"], dtype=float)

    phase, yaw = table("phase"), np.unwrap(table("yaw"))
    whole = np.where(np.isin(phase, range(4)), phase, -1).astype(np.int64)
    steps = table("footholds") if f"footholds_{robot}" in arrays else np.empty((0, 6))
    return Motion(robot, table("t"), table("position"), table("velocity"), yaw, whole, steps)


def _disordered(motion: Motion) -> Violation | None:
    robot, time = motion.robot, motion.time
    if abs(time[0]) > _TINY:
        text = f"the plan of robot {robot} begins at {time[0]:.3f} s instead of 0"
        return broken("samples", time[0], robot, text, time[0])
    for k in np.flatnonzero(motion.steps <= 0.0)[:1]:
        text = f"the times of robot {robot} do not increase"
        return broken("samples", time[k + 1], robot, text, motion.steps[k])
    for k in np.flatnonzero(motion.phase < 0)[:1]:
        text = f"robot {robot} is in a phase that is none of 0 to 3"
        return broken("phase", time[k], robot, text, 0.0, 3.0)
    return None


def _long_steps(motion: Motion) -> list[Violation]:
    robot, wide = motion.robot, np.flatnonzero(motion.steps > LONGEST_STEP + _TINY)
    if not len(wide):
        return []
    worst = motion.steps.max()
    text = f"robot {robot} has samples {worst:.4f} s apart; at most {LONGEST_STEP} s"
    return [broken("samples", motion.time[wide[0]], robot, text, worst, LONGEST_STEP)]


def _odd_phases(motion: Motion, model: RobotModel) -> list[Violation]:
    """Phases that cannot follow each other, or that the robot does not have."""
    robot, phase, time = motion.robot, motion.phase, motion.time

    def odd(k: SupportsIndex, text: str) -> Violation:
        return broken("phase", time[k], robot, f"robot {robot} {text}", phase[k])

    if model.drive != "legged":
        leaps = np.flatnonzero(phase != WALK)[:1]
        return [odd(k, f"leaps, but is a {model.drive}") for k in leaps]
    result = []
    if phase[0] not in (WALK, TAKE_OFF):
        result.append(odd(0, f"begins in {NAMES[phase[0]]}"))
    for k in np.flatnonzero(np.diff(phase)) + 1:
        before, after = int(phase[k - 1]), int(phase[k])
        if after not in _FOLLOWS[before]:
            result.append(odd(k, f"goes from {NAMES[before]} to {NAMES[after]}"))
    if phase[-1] not in (WALK, LANDING):
        result.append(odd(len(phase) - 1, f"ends in {NAMES[phase[-1]]}"))
    return result
