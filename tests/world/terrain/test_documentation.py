"""What docs/how-to/terrain.md says is so."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from cavalcade.scenario import build_world, parse_scenario
from cavalcade.world import TERRAINS, terrain_options
from cavalcade.world.terrain import filters
from cavalcade.world.terrain.loading import KEYS

_TEXT = (Path(__file__).parents[3] / "docs" / "how-to" / "terrain.md").read_text(encoding="utf-8")


def test_the_example_is_a_scenario() -> None:
    block = re.search(r"```yaml\n(.*?)```", _TEXT, re.DOTALL)
    assert block is not None
    data = {"version": 1, "name": "x", **yaml.safe_load(block[1])}
    assert parse_scenario(data).world.has_heights
    drawn = yaml.safe_load(re.sub(r"(?m)^  terrain:.*\n  # gen", "  gen", block[1]))
    assert build_world(parse_scenario({**data, **drawn})).terrain is not None


def test_every_key_and_option_is_there_with_its_default() -> None:
    for key in KEYS:
        assert f"`{key}`" in _TEXT
    for kind in TERRAINS:
        row = next(line for line in _TEXT.splitlines() if line.startswith(f"| `{kind}` |"))
        for name, default in terrain_options(kind).items():
            assert f"`{name}`" + ("" if default is None else f" {default}") in row


def test_constants_of_the_filters() -> None:
    for constant in (
        filters.SMOOTH_RADIUS,
        filters.NORMAL_RADIUS,
        filters.SMOOTH_NORMAL_RADIUS,
        filters.HOLE_RADIUS,
        filters.PIT_DEPTH,
        filters.PIT_WIDTH,
        filters.LEAST,
    ):
        assert f"{constant:g}" in _TEXT
