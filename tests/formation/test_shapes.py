"""Shapes: slots, sides, springs, and the smaller shapes of a team that lost someone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cavalcade.checking.arrival import slots_of
from cavalcade.errors import InputError
from cavalcade.formation import (
    LABORATORY_SPRINGS,
    SIMULATION_SPRINGS,
    Connection,
    Formation,
)
from cavalcade.scenario import FormationSection

SIZES = st.integers(1, 32)
LENGTHS = st.floats(0.4, 3.0)
ANY = {
    "line": (Formation.line, "spacing"),
    "column": (Formation.column, "spacing"),
    "wedge": (Formation.wedge, "spacing"),
    "circle": (Formation.circle, "radius"),
}
FIXED = {"square": (Formation.square, 4), "triangle": (Formation.triangle, 3)}
kinds = st.sampled_from(sorted(ANY))


def distances(slots):
    return np.linalg.norm(slots[:, None] - slots[None], axis=-1)


def same_places(a, b):
    """Whether two shapes have the same slots, in whatever order."""
    apart = np.linalg.norm(a[:, None] - b[None], axis=-1)
    return len(a) == len(b) and max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-9


def connected(shape):
    """Whether one can get from every slot to every other along springs."""
    reached, frontier = {0}, [0]
    while frontier:
        here = frontier.pop()
        for c in shape.connections:
            for there in {c.a, c.b} - reached if here in (c.a, c.b) else ():
                reached.add(there)
                frontier.append(there)
    return len(reached) == shape.size


@settings(max_examples=80, deadline=None)
@given(kinds, SIZES, LENGTHS)
def test_laws_of_all_shapes(kind, robots, length):
    shape = ANY[kind][0](robots, length)
    assert (shape.name, shape.size) == (kind, robots)
    assert shape.slots[:, 0].mean() == pytest.approx(0.0, abs=1e-9)
    # Nobody stands ahead of the leader's slot, which lies on the axis where there is a middle.
    assert shape.slots[0, 0] >= shape.slots[:, 0].max() - 1e-9
    if kind != "line" or robots % 2:
        assert shape.slots[0, 1] == pytest.approx(0.0, abs=1e-9)
    assert connected(shape)
    for c in shape.connections:
        assert c.rest_length == pytest.approx(distances(shape.slots)[c.a, c.b])
        assert c.a != c.b
    assert len({frozenset((c.a, c.b)) for c in shape.connections}) == len(shape.connections)


@example("circle", 1, 1.0)
@example("wedge", 4, 1.0)
@settings(max_examples=60, deadline=None)
@given(kinds, SIZES, LENGTHS)
def test_the_checker_places_the_same_slots(kind, robots, length):
    make, key = ANY[kind]
    section = FormationSection.model_validate({"shape": kind, key: length})
    assert same_places(make(robots, length).slots, slots_of(section, robots))


@pytest.mark.parametrize("kind", FIXED)
def test_the_checker_places_the_same_polygons(kind):
    make, robots = FIXED[kind]
    section = FormationSection.model_validate({"shape": kind, "side": 1.3})
    assert same_places(make(1.3).slots, slots_of(section, robots))


@pytest.mark.parametrize(("kind", "robots"), [("line", 5), ("column", 4), ("wedge", 7)])
def test_neighbours_stand_one_spacing_apart(kind, robots):
    shape = ANY[kind][0](robots, 0.8)
    assert shape.spacing == pytest.approx(0.8)
    sides = [c for c in shape.connections if c.law == SIMULATION_SPRINGS.sides]
    assert len(sides) == robots - 1
    assert [c.rest_length for c in sides] == pytest.approx([0.8] * (robots - 1))


def test_the_square_of_the_paper():
    square = Formation.square(1.0)
    assert square.slots[0] == pytest.approx((np.sqrt(0.5), 0.0))
    sides = [c for c in square.connections if c.law == SIMULATION_SPRINGS.sides]
    diagonals = [c for c in square.connections if c.law == SIMULATION_SPRINGS.diagonals]
    assert [c.rest_length for c in sides] == pytest.approx([1.0] * 4)
    assert [c.rest_length for c in diagonals] == pytest.approx([np.sqrt(2.0)] * 2)
    assert {frozenset((c.a, c.b)) for c in diagonals} == {frozenset((0, 2)), frozenset((1, 3))}


def test_the_triangle_of_the_paper():
    triangle = Formation.triangle(1.15, LABORATORY_SPRINGS)
    assert [c.rest_length for c in triangle.connections] == pytest.approx([1.15] * 3)
    assert triangle.slots[0] == pytest.approx((1.15 / np.sqrt(3.0), 0.0))
    assert {c.law for c in triangle.connections} == {LABORATORY_SPRINGS.sides}


def test_a_line_stands_across_and_a_column_along_the_way():
    assert np.ptp(Formation.line(5).slots[:, 0]) == 0.0
    assert np.ptp(Formation.column(5).slots[:, 1]) == 0.0
    # The leader of a line stands in its middle, so that the others have it between them.
    assert Formation.line(5).slots[0] == pytest.approx((0.0, 0.0))


def test_the_arms_of_a_wedge_stand_at_right_angles():
    slots = Formation.wedge(5, 1.0).slots - Formation.wedge(5, 1.0).slots[0]
    assert slots[1] @ slots[2] == pytest.approx(0.0)
    assert slots[3] == pytest.approx(2.0 * slots[1])


@pytest.mark.parametrize("robots", [3, 8, 20])
def test_a_circle_is_one(robots):
    shape = Formation.circle(robots, 1.7)
    np.testing.assert_allclose(np.hypot(*shape.slots.T), 1.7)
    sides = [c for c in shape.connections if c.law == SIMULATION_SPRINGS.sides]
    assert len(sides) == robots


def test_one_robot_stands_in_the_middle_and_has_no_springs():
    for kind in ANY:
        shape = ANY[kind][0](1)
        assert shape.slots.tolist() == [[0.0, 0.0]]
        assert shape.connections == ()
        assert shape.spacing == 0.0


def test_a_placed_shape():
    np.testing.assert_allclose(
        Formation.column(2, 2.0).placed((3.0, 4.0, np.pi / 2)), [[3.0, 5.0], [3.0, 3.0]]
    )


class TestCustom:
    SLOTS = ((1.0, 0.0), (0.0, 0.0), (-2.0, 0.0))

    def test_default_springs_hold_far_slots_too(self):
        shape = Formation.custom(self.SLOTS)
        assert {frozenset((c.a, c.b)) for c in shape.connections} == {
            frozenset((0, 1)),
            frozenset((1, 2)),
        }

    @settings(max_examples=40, deadline=None)
    @given(SIZES, st.integers(0, 2**32 - 1))
    def test_any_shape_hangs_together(self, robots, seed):
        slots = np.random.default_rng(seed).uniform(-4.0, 4.0, (robots, 2))
        assert connected(Formation.custom(slots))

    def test_own_springs_replace_the_default_ones(self):
        spring = Connection(0, 2, 2.5, LABORATORY_SPRINGS.sides)
        assert Formation.custom(self.SLOTS, [spring]).connections == (spring,)
        assert Formation.custom(self.SLOTS, []).connections == ()

    @pytest.mark.parametrize(("a", "b"), [(0, 3), (-1, 0), (1, 1)])
    def test_springs_between_unknown_slots(self, a, b):
        with pytest.raises(InputError, match=r"connections: .*0\.\.2"):
            Formation.custom(self.SLOTS, [Connection(a, b, 1.0, SIMULATION_SPRINGS.sides)])

    @pytest.mark.parametrize(
        ("slots", "message"),
        [
            ([], "slots"),
            ([1.0, 2.0], "slots"),
            ([[1.0, 2.0, 3.0]], "slots"),
            ([[0.0, np.nan]], "finite"),
            ([[0.0, np.inf]], "finite"),
            ([[0.0, 0.0], [0.0, 0.0]], "one spot"),
        ],
    )
    def test_malformed_slots(self, slots, message):
        with pytest.raises(InputError, match=message):
            Formation.custom(slots)

    def test_slots_cannot_be_changed_afterwards(self):
        given_slots = np.array(self.SLOTS)
        shape = Formation.custom(given_slots)
        given_slots[0] = 9.0
        assert shape.slots[0].tolist() == [1.0, 0.0]
        with pytest.raises(ValueError, match="read-only"):
            shape.slots[0] = 9.0


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf, "1"])
def test_malformed_lengths(length):
    for make in (Formation.square, Formation.triangle):
        with pytest.raises(InputError, match="side"):
            make(length)
    for make, key in ANY.values():
        with pytest.raises(InputError, match=key):
            make(3, length)


@pytest.mark.parametrize("robots", [0, -1, 2.5, "3"])
def test_malformed_numbers_of_robots(robots):
    for make, _ in ANY.values():
        with pytest.raises(InputError, match="robots"):
            make(robots)


class TestSmaller:
    @settings(max_examples=60, deadline=None)
    @given(kinds, st.integers(2, 32), LENGTHS, st.data())
    def test_it_has_as_many_slots_as_are_asked_for(self, kind, robots, length, data):
        shape = ANY[kind][0](robots, length)
        left = data.draw(st.integers(1, robots))
        smaller = shape.smaller(left)
        assert smaller.size == left
        if left > 1:
            assert smaller.spacing == pytest.approx(shape.spacing)
        assert connected(smaller)

    @pytest.mark.parametrize(
        ("shape", "left", "name"),
        [
            (Formation.square(), 3, "triangle"),
            (Formation.square(), 2, "column"),
            (Formation.triangle(), 2, "column"),
            (Formation.wedge(5), 3, "wedge"),
            (Formation.circle(6), 5, "circle"),
            (Formation.line(4), 3, "line"),
            (Formation.custom([[1, 0], [0, 1], [0, -1], [-1, 0]]), 3, "custom"),
        ],
    )
    def test_the_kind_stays_where_it_makes_sense(self, shape, left, name):
        assert shape.smaller(left).name == name

    def test_all_of_them_is_the_shape_itself(self):
        square = Formation.square()
        assert square.smaller(4) is square

    def test_it_keeps_the_laws_of_the_springs(self):
        smaller = Formation.square(1.0, LABORATORY_SPRINGS).smaller(3)
        assert {c.law for c in smaller.connections} == {LABORATORY_SPRINGS.sides}
