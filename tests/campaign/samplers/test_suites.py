from __future__ import annotations

import warnings

import pytest

from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.suite import load_suite, suite_names
from cavalcade.scenario import build_world, parse_scenario, resolve_scenario
from cavalcade.world import MapWarning

NAMES = (
    "ablation",
    "barn",
    "clutter",
    "corridors",
    "disturbed",
    "events",
    "forest",
    "real-maps",
    "rooms",
    "sizes",
    "smoke",
)


def test_all_are_shipped():
    assert set(NAMES) <= set(suite_names())


@pytest.mark.parametrize("name", NAMES)
def test_every_group_draws(name):
    suite = load_suite(name)
    assert suite.suite == name
    assert suite.about
    data = DataFolder(None)
    for group in suite.worlds:
        if group.sampler.missing(data) is not None:
            assert name in ("barn", "real-maps")
            continue
        instance = group.sampler.sample(0, data)
        assert instance.feasible
        parse_scenario(instance.scenario)


def test_smoke_is_large_enough():
    suite = load_suite("smoke")
    worlds = sum(group.seeds for group in suite.worlds)
    assert worlds * len(suite.variants) >= 20
    assert all(group.sampler.missing(DataFolder(None)) is None for group in suite.worlds)


def test_ablation_takes_every_variant():
    from cavalcade.formation import VARIANTS

    suite = load_suite("ablation")
    assert set(suite.variants) == set(VARIANTS)
    assert sum(group.seeds for group in suite.worlds) == 100


@pytest.mark.parametrize(
    ("name", "folder", "seeds"), [("barn", "barn", 12), ("real-maps", "ros_maps", 8)]
)
def test_on_the_data_of_others(name, folder, seeds, shared_data):
    data = DataFolder(shared_data(folder).parent)
    (group,) = load_suite(name).worlds
    assert group.sampler.missing(data) is None
    feasible = 0
    for seed in range(seeds):
        instance = group.sampler.sample(seed, data)
        feasible += instance.feasible
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            build_world(resolve_scenario(parse_scenario(instance.scenario)))
    assert feasible >= 0.9 * seeds
