"""LEAP: the force profile and ballistics, integrated here by ourselves; symmetry; limits."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.kinodynamic._leap import (
    close_leap,
    leap_duration,
    leap_problem,
    leap_state,
    peak_force,
    reverse_leap,
)
from cavalcade.kinodynamic._leap_over_barrier import Line, find_barrier, leap_over
from cavalcade.kinodynamic._leap_random import random_leap
from cavalcade.kinodynamic.parameters import (
    BRAKE,
    END,
    FLIGHT,
    FORCE,
    KIND,
    LAND,
    LEAP,
    OK,
    SIZE,
    START,
    TIME,
    make_body,
    make_space,
)
from cavalcade.lattice.surface import surface

G = 9.81

component = st.floats(-2.0, 2.0)
span = st.floats(0.1, 0.3)
leaps = st.tuples(
    st.tuples(*[component] * 6),
    st.tuples(component, component, st.floats(1.0, 5.0)),
    st.tuples(component, component, st.floats(1.0, 5.0)),
    span,
    st.floats(0.05, 0.6),
    span,
)


def make_leap(values) -> np.ndarray:
    begin, push, brake, up, flight, down = values
    leap = np.zeros(SIZE)
    leap[KIND] = LEAP
    leap[START : START + 6] = begin
    leap[FORCE : FORCE + 3], leap[BRAKE : BRAKE + 3] = push, brake
    leap[TIME], leap[FLIGHT], leap[LAND] = up, flight, down
    close_leap(leap)
    return leap


def integrated(leap: np.ndarray, until: float) -> np.ndarray:
    """The state at `until` by Runge and Kutta's method, which is exact for these forces.

    Velocities are cubics in time, so Simpson's rule in each of many small steps is exact for
    them; positions are quartics, of which the error falls with the fourth power of the step.
    """
    ends = np.cumsum([leap[TIME], leap[FLIGHT], leap[LAND]])

    def force(t: float) -> np.ndarray:
        if t < ends[0]:
            return 4.0 * leap[FORCE : FORCE + 3] * t * (ends[0] - t) / leap[TIME] ** 2
        if t < ends[1]:
            return np.zeros(3)
        t -= ends[1]
        return 4.0 * leap[BRAKE : BRAKE + 3] * t * (leap[LAND] - t) / leap[LAND] ** 2

    p, v = leap[START : START + 3].copy(), leap[START + 3 : START + 6].copy()
    down = np.array([0.0, 0.0, -G])
    bounds = [0.0, *[e for e in ends if e < until - 1e-12], until]
    for a, b in pairwise(bounds):
        count = 40
        h = (b - a) / count
        for k in range(count):
            t = a + k * h
            inside = [min(max(x, a + 1e-13), b - 1e-13) for x in (t, t + h / 2, t + h)]
            a0, a1, a2 = (G * force(x) + down for x in inside)
            p = p + h * v + h * h / 6.0 * (a0 + 2.0 * a1)
            v = v + h / 6.0 * (a0 + 4.0 * a1 + a2)
    return np.concatenate([p, v])


@settings(max_examples=40, deadline=None)
@given(leaps, st.floats(0.0, 1.0))
def test_it_is_the_integral_of_the_force_profile_and_of_gravity(values, part):
    leap = make_leap(values)
    out = np.empty(6)
    until = part * leap_duration(leap)
    leap_state(leap, until, out)
    assert np.allclose(out, integrated(leap, until), rtol=0.0, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(leaps)
def test_flight_obeys_ballistics_and_keeps_energy_and_momentum(values):
    leap = make_leap(values)
    first, last = np.empty(6), np.empty(6)
    leap_state(leap, leap[TIME], first)
    leap_state(leap, leap[TIME] + leap[FLIGHT] * 0.7, last)
    t = 0.7 * leap[FLIGHT]
    expected = first[:3] + first[3:] * t - [0.0, 0.0, 0.5 * G * t * t]
    assert np.allclose(last[:3], expected, rtol=0.0, atol=1e-9)
    assert np.allclose(last[3:5], first[3:5], rtol=0.0, atol=1e-12)
    energy = [0.5 * s[3:] @ s[3:] + G * s[2] for s in (first, last)]
    assert energy[0] == pytest.approx(energy[1], abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(leaps, st.floats(0.0, 1.0))
def test_reversed_in_time_it_is_the_same_way(values, part):
    leap, back, again = make_leap(values), np.empty(SIZE), np.empty(SIZE)
    reverse_leap(leap, back)
    total = leap_duration(leap)
    one, two = np.empty(6), np.empty(6)
    leap_state(leap, part * total, one)
    leap_state(back, (1.0 - part) * total, two)
    assert np.allclose(one[:3], two[:3], atol=1e-9)
    assert np.allclose(one[3:], -two[3:], atol=1e-9)
    reverse_leap(back, again)
    assert np.array_equal(leap, again)


@settings(max_examples=40, deadline=None)
@given(st.floats(-0.2, 0.4), st.floats(-2.0, 1.0), span)
def test_peak_force_lifts_by_what_was_asked(rise, speed, duration):
    force = peak_force(rise, speed, duration)
    leap = make_leap(((0, 0, 0, 0, 0, speed), (0, 0, force), (0, 0, 1), duration, 0.1, 0.1))
    out = np.empty(6)
    leap_state(leap, duration, out)
    assert out[2] == pytest.approx(rise, abs=1e-9)


@pytest.mark.parametrize(("kind", "options"), [("gap", {"width": 0.4}), ("step", {"height": 0.25})])
@pytest.mark.parametrize("backwards", [False, True])
def test_leaps_cross_what_is_in_the_way(
    make_terrain, reference_problem, model, kind, options, backwards
):
    ground = make_terrain(kind, **options)
    space, line = make_space(ground, make_body(model)), Line(2.0, 2.0, 1.0, 0.0)
    at = 3.1 if backwards else 2.1
    barrier = find_barrier(space, line, at, backwards)
    assert 1.5 < barrier.walk <= barrier.take_off < barrier.landing < 3.5
    rng = np.array([3], dtype=np.uint64)
    leap, scratch, out = np.empty(SIZE), np.empty(12), np.empty(6)
    good = 0
    for attempt in range(100):
        if not leap_over(space, line, barrier, attempt, rng, leap, scratch):
            continue
        good += 1
        assert leap[START] <= 2.0 + barrier.walk + 1e-9
        ends = []
        for t in np.linspace(0.0, leap_duration(leap), 40):
            phase = leap_state(leap, t, out)
            pose = np.array([*out[:3], 0.0])
            if np.abs(t - np.cumsum([leap[TIME], leap[FLIGHT]])).min() > 1e-6:
                ends.append(reference_problem(ground, model, pose, phase, 2e-3))
        assert set(ends) == {""}
        for at_end in (START, END):
            s = leap[at_end : at_end + 6]
            _, along_x, _ = surface(ground, s[0], s[1])
            assert s[5] == pytest.approx(along_x * s[3], abs=0.05)  # no counter-movement
    assert good > 5


def test_random_leaps_are_valid_in_forward_time_from_both_trees(make_flat, spirit):
    body = make_body(spirit, published=True)
    space = make_space(make_flat(), body)
    rng = np.array([5], dtype=np.uint64)
    leap, scratch = np.empty(SIZE), np.empty(12)
    for backwards, x in ((False, 4.1), (True, 4.9)):
        state = np.array([x, 2.0, 0.3, 0.9, 0.0, 0.0])
        good = 0
        for _ in range(400):
            if not random_leap(space, state, backwards, rng, leap, scratch):
                continue
            good += 1
            own = leap[END : END + 3] if backwards else leap[START : START + 3]
            assert np.allclose(own, state[:3], atol=1e-9)
            # The counter-movement: 1-2 m/s below the slope's own speed, mirrored at the end.
            vz = -leap[END + 5] if backwards else leap[START + 5]
            assert -2.0 - 1e-9 <= vz <= -1.0 + 1e-9
            assert leap_problem(space, leap, scratch) == OK
            assert math.hypot(leap[FORCE], leap[FORCE + 1]) <= body.mu * leap[FORCE + 2] + 1e-9
        assert good > 5
