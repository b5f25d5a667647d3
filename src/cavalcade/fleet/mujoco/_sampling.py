"""What happens between two samples of a team in physics, compiled."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def keep_peaks(torques, peaks):
    """Keep of each joint the torque of largest magnitude.

    Args:
        torques: `(N, 12)` of one step, N m.
        peaks: `(N, 12)` so far; changed.
    """
    for k in range(peaks.shape[0]):
        for j in range(peaks.shape[1]):
            if abs(torques[k, j]) > abs(peaks[k, j]):
                peaks[k, j] = torques[k, j]
