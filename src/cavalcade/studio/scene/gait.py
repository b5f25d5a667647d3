"""A trot under robots whose legs nobody knows: feet stand on the ground and step as bodies move."""

from __future__ import annotations

import numpy as np

from cavalcade.geometry import Array, wrap_angle

STRIDE = 0.34
"""How far a body goes while each foot steps once, m."""

_TURN = 0.25
"""A radian of turning on the spot steps as much as so many metres."""

_JUMP = 1.0
"""Bodies that move farther between two moments have not walked there, m."""

_SHIFTS = np.array([0.0, 0.5, 0.5, 0.0])
"""Diagonal pairs of legs step in turns."""

_BRISK = 0.15
"""From this speed on feet are lifted all the way, m/s."""


class Trot:
    """Feet of N robots of one kind.

    Steps count metres instead of seconds, so that feet rest when bodies do.

    Args:
        feet: `(4, 2)` places of the feet under a standing body, m.
        swing: How high feet are lifted, m.
    """

    def __init__(self, feet: Array, swing: float) -> None:
        self._neutral, self._swing = feet, swing
        self._poses: Array | None = None
        self._time = 0.0
        self._gone: Array = np.zeros(0)
        self._way: Array = np.zeros((0, 3))
        self._cycle: Array = np.zeros((0, 4))
        self._planted: Array = np.zeros((0, 4, 2))
        self._lift: Array = np.zeros(0)

    def step(self, time: float, poses: Array) -> tuple[Array, Array]:
        """Places `(N, 4, 2)` of the feet and their heights over the ground `(N, 4)`, m.

        Args:
            time: s.
            poses: `(N, 3)` of the bodies.
        """
        moved = self._moved(time, poses)
        length = np.hypot(moved[:, 0], moved[:, 1]) + _TURN * np.abs(moved[:, 2])
        going = length > 1e-6
        self._way[going] = moved[going] / length[going, None]
        self._gone += length
        if time > self._time:
            brisk = np.minimum(length / (time - self._time) / _BRISK, 1.0)
            self._lift += 0.5 * (brisk - self._lift)
        self._poses, self._time = poses.copy(), time

        phase = self._gone[:, None] / STRIDE + _SHIFTS
        cycle = np.floor(phase)
        share = phase - cycle
        # Feet come down a quarter of a stride ahead of where they belong, and lift as far behind.
        landed = cycle > self._cycle
        self._planted[landed] = self._under((0.25 - share) * STRIDE)[landed]
        self._cycle = cycle
        swung = np.clip(2.0 * share - 1.0, 0.0, 1.0)
        next_place = self._under((1.25 - share) * STRIDE)
        smooth = (swung * swung * (3.0 - 2.0 * swung))[..., None]
        places = self._planted + smooth * (next_place - self._planted)
        return places, self._swing * self._lift[:, None] * np.sin(np.pi * swung)

    def _moved(self, time: float, poses: Array) -> Array:
        """How far each has gone since the last time, `(N, 3)`; whoever has jumped begins anew."""
        if self._poses is None or len(self._poses) != len(poses):
            count = len(poses)
            self._poses, self._time = poses.copy(), time
            self._gone, self._lift = np.zeros(count), np.zeros(count)
            self._way, self._cycle = np.zeros((count, 3)), np.zeros((count, 4))
            self._planted = self._under(np.zeros((count, 4)))
        moved = poses - self._poses
        moved[:, 2] = wrap_angle(moved[:, 2])
        jumped = np.hypot(moved[:, 0], moved[:, 1]) > _JUMP
        if jumped.any():
            self._poses = np.where(jumped[:, None], poses, self._poses)
            self._gone[jumped], self._way[jumped], self._cycle[jumped] = 0.0, 0.0, 0.0
            self._planted[jumped] = self._under(np.zeros((len(poses), 4)))[jumped]
            moved[jumped] = 0.0
        return np.asarray(moved)

    def _under(self, ahead: Array) -> Array:
        """Where the feet belong, `(N, 4, 2)`, once the bodies have gone on by `(N, 4)` m."""
        assert self._poses is not None
        at = self._poses[:, None] + ahead[..., None] * self._way[:, None]
        c, s = np.cos(at[..., 2]), np.sin(at[..., 2])
        x, y = self._neutral.T
        return np.stack([at[..., 0] + c * x - s * y, at[..., 1] + s * x + c * y], axis=-1)
