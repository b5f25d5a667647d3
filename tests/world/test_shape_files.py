from __future__ import annotations

import json

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.world import Box, Circle, Polygon, shape_from_mapping, shape_to_mapping

number = st.floats(-1e5, 1e5)
positive = st.floats(1e-5, 1e5)


@given(
    st.one_of(
        st.builds(Box, st.tuples(number, number), st.tuples(positive, positive), number),
        st.builds(Circle, st.tuples(number, number), positive),
        st.just(Polygon(((0, 0), (1, 0.1), (0.3, 1)))),
    )
)
def test_there_and_back_through_yaml_and_json(shape):
    mapping = shape_to_mapping(shape)
    assert shape_from_mapping(mapping) == shape
    assert shape_from_mapping(json.loads(json.dumps(mapping))) == shape
    assert shape_from_mapping(yaml.safe_load(yaml.safe_dump(mapping))) == shape


def test_yaw_may_be_left_out():
    assert shape_from_mapping({"box": {"center": [4, 2], "size": [1.0, 0.4]}}) == Box(
        (4, 2), (1.0, 0.4)
    )


@pytest.mark.parametrize(
    ("mapping", "key"),
    [
        ({}, None),
        ([], None),
        ("circle", None),
        ({"circle": {}, "box": {}}, None),
        ({"disc": {}}, None),
        ({3: {}}, None),
        ({"circle": [1, 2]}, "circle"),
        ({"circle": {"radius": 1}}, "circle.center"),
        ({"circle": {"center": [0, 0], "radius": 1, "yaw": 0}}, "circle.yaw"),
        ({"circle": {"center": None, "radius": 1}}, "circle.center"),
        ({"circle": {"center": [0, 0], "radius": None}}, "circle.radius"),
        ({"box": {"center": [0, 0], "size": 1}}, "box.size"),
        ({"polygon": {"points": 5}}, "polygon.points"),
        ({"polygon": {"points": [1, 2, 3]}}, "polygon.points[0]"),
    ],
)
def test_bad_mappings(mapping, key):
    with pytest.raises(InputError) as caught:
        shape_from_mapping(mapping)
    assert caught.value.key == key
