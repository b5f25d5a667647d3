"""From primitives to the samples of a trajectory."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import FLIGHT as FLYING
from cavalcade.geometry.trajectory import LANDING, TAKE_OFF, WALK
from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._connect import walk_state
from cavalcade.kinodynamic._leap import leap_state
from cavalcade.kinodynamic._primitives import edge_duration, edge_yaw
from cavalcade.kinodynamic._validity import STILL, stands_still, turn_on_spot, wrapped
from cavalcade.kinodynamic.parameters import CONNECT, END, FLIGHT, KIND, LAND, START, TIME


class _Samples(NamedTuple):
    """Samples, of whose `N` places those up to `last[0]` are taken.

    Attributes:
        time: `(N,)` s.
        states: `(N, 6)`.
        yaws: `(N,)` rad, continuous.
        phases: `(N,)` of the motion from each sample to the next.
        last: `(1,)`.
    """

    time: Array
    states: Array
    yaws: Array
    phases: NDArray[np.int8]
    last: NDArray[np.int64]


@kernel
def sample_path(space, edges, begin, yaw):
    """Times, states `(T, 6)`, yaws and phases of a path at most dt apart, with the ends of phases.

    `begin` `(6,)` is the state at the start, `yaw` `(2,)` that at the start and the goal, rad.
    """
    dt = space.body.dt
    size = 4
    most = 2.0 * math.pi / space.body.yaw_rate
    for k in range(edges.shape[0]):
        size += int((edge_duration(edges[k]) + most) / dt) + 8
    size += int(most / dt)
    samples = _Samples(
        np.empty(size),
        np.empty((size, 6)),
        np.empty(size),
        np.empty(size, np.int8),
        np.zeros(1, np.int64),
    )
    samples.time[0], samples.yaws[0], samples.phases[0] = 0.0, yaw[0], WALK
    copy_to(samples.states[0], begin)
    for k in range(edges.shape[0]):
        edge = edges[k]
        # A turn on the spot where it sets off from rest, and the primitive phase by phase.
        if stands_still(edge[START : START + 6]):
            _add_turn(space, edge_yaw(edge, False), samples)
        if edge[KIND] == CONNECT:
            _add_phase(space, edge, 0.0, edge[TIME], WALK, samples)
        else:
            lift_off = edge[TIME]
            touch_down = lift_off + edge[FLIGHT]
            _add_phase(space, edge, 0.0, lift_off, TAKE_OFF, samples)
            _add_phase(space, edge, lift_off, touch_down, FLYING, samples)
            _add_phase(space, edge, touch_down, touch_down + edge[LAND], LANDING, samples)
            samples.phases[samples.last[0]] = WALK
        copy_to(samples.states[samples.last[0]], edge[END : END + 6])
    _add_turn(space, yaw[1], samples)
    samples.phases[samples.last[0]] = WALK
    count = samples.last[0] + 1
    return (
        samples.time[:count].copy(),
        samples.states[:count].copy(),
        samples.yaws[:count].copy(),
        samples.phases[:count].copy(),
    )


@subroutine
def _add_turn(space, wanted, samples):
    """Append samples of a turn on the spot to a yaw, rad."""
    time, states, yaws, phases, last = samples
    first = last[0]
    turn = turn_on_spot(space, states[first], yaws[first], wanted)
    if math.isnan(turn):
        turn = wrapped(wanted - yaws[first])
    if abs(turn) < 1e-9:
        return
    span = abs(turn) / space.body.yaw_rate
    count = max(int(math.ceil(span / space.body.dt - 1e-9)), 1)
    for k in range(1, count + 1):
        at = first + k
        time[at] = time[first] + span * k / count
        copy_to(states[at], states[first])
        yaws[at] = yaws[first] + turn * k / count
        phases[at - 1] = WALK
    last[0] = first + count


@subroutine
def _add_phase(space, edge, t0, t1, phase, samples):
    """Append samples of a primitive from t0 to t1."""
    time, states, yaws, phases, last = samples
    first = last[0]
    count = max(int(math.ceil((t1 - t0) / space.body.dt - 1e-9)), 1)
    # The state at which a phase begins is that of its primitive, also where speeds jump.
    if t0 == 0.0:
        copy_to(states[first], edge[START : START + 6])
    for k in range(1, count + 1):
        at = first + k
        time[at] = time[first] + (t1 - t0) * k / count
        t, state = t0 + (t1 - t0) * k / count, states[at]
        if phase == WALK:
            walk_state(space, edge, t, state)
        else:
            leap_state(edge, t, state)
        # The yaw follows the velocity; at rest it is that of the primitive's end.
        vx, vy = state[3], state[4]
        if vx * vx + vy * vy > STILL * STILL:
            yaws[at] = yaws[at - 1] + wrapped(math.atan2(vy, vx) - yaws[at - 1])
        elif k == count:
            yaws[at] = yaws[at - 1] + wrapped(edge_yaw(edge, True) - yaws[at - 1])
        else:
            yaws[at] = yaws[at - 1]
        phases[at - 1] = phase
    last[0] = first + count
