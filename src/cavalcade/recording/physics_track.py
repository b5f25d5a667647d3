"""What is recorded of a team in physics, in memory: bodies, joints, forces, contacts, falls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import RecordingError
from cavalcade.geometry import Array

LEGS, JOINTS = 4, 12

LOADED = 2.0
"""A foot carries from this force on, N."""

_TAILS: dict[str, tuple[int, ...]] = {
    "base": (7,),
    "joints": (JOINTS,),
    "joint_rates": (JOINTS,),
    "torques": (JOINTS,),
    "foot_forces": (LEGS, 3),
}


def yaw_of(quaternions: Array) -> Array:
    """`(...,)` rad: the headings of unit quaternions `(..., 4)` w, x, y, z."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


@dataclass(frozen=True)
class ContactEvent:
    """A contact that is not a foot on the ground; said anew every 20 ms while it lasts.

    Attributes:
        time: s.
        robot: Which.
        part: `trunk`, `hip`, `thigh`, `calf` or `foot`.
        other: `ground`, `obstacle` or `robot k`.
    """

    time: float
    robot: int
    part: str
    other: str


@dataclass(frozen=True)
class FallEvent:
    """A robot fell; `time` in s."""

    time: float
    robot: int


@dataclass(frozen=True, eq=False)
class PhysicsTrack:
    """N robots at T samples, usually 50 a second; map frame, SI units.

    Legs are front left, front right, rear left, rear right; a leg's joints are hip, thigh, calf.

    Attributes:
        time: `(T,)` s, increasing.
        base: `(T, N, 7)` the trunk's frame: x, y, z and the unit quaternion w, x, y, z.
        joints: `(T, N, 12)` rad.
        joint_rates: `(T, N, 12)` rad/s.
        torques: `(T, N, 12)` N m: those of largest magnitude since the sample before.
        foot_forces: `(T, N, 4, 3)` N: mean force on each foot since the sample before.
        contacts: Of anything but feet on the ground, in order of time.
        falls: In order of time.

    Raises:
        RecordingError: An array has the wrong shape or holds what is not finite, the times do not
            increase, or an event names a robot that is not there.
    """

    time: Array
    base: Array
    joints: Array
    joint_rates: Array
    torques: Array
    foot_forces: Array
    contacts: tuple[ContactEvent, ...] = ()
    falls: tuple[FallEvent, ...] = ()

    def __post_init__(self) -> None:
        time = np.asarray(self.time)
        if time.ndim != 1:
            raise RecordingError(f"expected shape (T,), got {time.shape}", key="time")
        if not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
            raise RecordingError("expected finite times that increase", key="time")
        base = np.asarray(self.base)
        robots = base.shape[1] if base.ndim == 3 else 0
        for name, tail in _TAILS.items():
            values = np.asarray(getattr(self, name))
            if values.ndim != 2 + len(tail) or values.shape != (len(time), robots, *tail):
                wanted = ", ".join(map(str, (len(time), robots or "N", *tail)))
                raise RecordingError(f"expected shape ({wanted}), got {values.shape}", key=name)
            if not np.all(np.isfinite(values)):
                raise RecordingError("expected finite numbers", key=name)
        for name in ("contacts", "falls"):
            for event in getattr(self, name):
                if not 0 <= event.robot < robots:
                    raise RecordingError(f"there is no robot {event.robot}", key=name)

    @property
    def size(self) -> int:
        """Number of robots."""
        return int(self.base.shape[1])

    @property
    def duration(self) -> float:
        """From the first sample to the last, s."""
        return float(self.time[-1] - self.time[0]) if len(self.time) else 0.0

    @property
    def flying(self) -> NDArray[np.bool_]:
        """`(T, N)` whether no foot carried since the sample before; not of robots that fell."""
        lifted = np.asarray((self.foot_forces[..., 2] < LOADED).all(axis=2))
        beside = np.zeros_like(lifted)
        # Two samples in a row, so that a stumble of one is no flight.
        beside[1:] |= lifted[:-1]
        beside[:-1] |= lifted[1:]
        found: NDArray[np.bool_] = lifted & beside
        for fall in self.falls:
            found[self.time >= fall.time, fall.robot] = False
        return found

    def thinned(self, stride: int) -> PhysicsTrack:
        """Every so many-th sample: its forces are means and its torques peaks since the last."""
        if stride <= 1 or len(self.time) < 2:
            return self
        kept = np.arange(0, len(self.time), stride)
        starts = np.concatenate([[0], kept[:-1] + 1])
        counts = np.diff(np.append(starts, kept[-1] + 1))
        end = int(kept[-1]) + 1
        forces = np.add.reduceat(self.foot_forces[:end], starts, axis=0)
        high = np.maximum.reduceat(self.torques[:end], starts, axis=0)
        low = np.minimum.reduceat(self.torques[:end], starts, axis=0)
        return replace(
            self,
            time=self.time[kept],
            base=self.base[kept],
            joints=self.joints[kept],
            joint_rates=self.joint_rates[kept],
            torques=np.where(high >= -low, high, low),
            foot_forces=forces / counts[:, None, None, None],
        )
