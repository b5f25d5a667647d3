"""What motors can give, compiled."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def limit_torques(wanted, limits, stall, no_load, rates, dofs, motors, torque_speed, out, ctrl):
    """Cut torques to what motors can give.

    Args:
        wanted: `(N, 12)` N m; values that are not numbers count as 0.
        limits, stall, no_load: `(N, 12)` largest torque, torque at rest (N m), no-load speed
            (rad/s).
        rates: Joint rates at the places `dofs` `(N, 18)` of it, rad/s.
        motors: `(N, 12)` places in `ctrl`.
        torque_speed: Whether torque falls with speed where the motor drives.
        out: `(N, 12)` filled with what is given.
        ctrl: Filled at the places `motors`.
    """
    for k in range(wanted.shape[0]):
        for j in range(12):
            torque = wanted[k, j]
            if torque != torque:
                torque = 0.0
            most = limits[k, j]
            if torque_speed:
                rate = rates[dofs[k, 6 + j]]
                if torque * rate > 0.0:
                    most = min(most, max(stall[k, j] * (1.0 - abs(rate) / no_load[k, j]), 0.0))
            torque = min(max(torque, -most), most)
            out[k, j] = torque
            ctrl[motors[k, j]] = torque
