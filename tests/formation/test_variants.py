"""The variants differ in what their names say, and in nothing else."""

from __future__ import annotations

from dataclasses import fields

import pytest

from cavalcade.errors import InputError
from cavalcade.formation import VARIANTS, Variant
from cavalcade.formation.settings import variant_named

PUBLISHED = Variant("published")
OURS = {"improved", "recovery", "filter"}


def differences(name):
    variant = VARIANTS[name]
    return {
        field.name
        for field in fields(Variant)
        if field.name != "name" and getattr(variant, field.name) != getattr(PUBLISHED, field.name)
    }


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("cavalcade", OURS),
        ("cavalcade-fixed-roles", OURS | {"adaptive_roles"}),
        ("cavalcade-no-lookahead", OURS | {"lookahead"}),
        ("cavalcade-no-springs", OURS | {"springs"}),
        ("cavalcade-no-avoidance", OURS | {"avoidance"}),
        ("cavalcade-no-recovery", OURS - {"recovery"}),
        ("cavalcade-no-filter", OURS - {"filter"}),
        ("published", set()),
        ("fixed-roles", {"adaptive_roles"}),
        ("no-lookahead", {"lookahead"}),
        ("no-springs", {"springs"}),
        ("no-avoidance", {"avoidance"}),
        ("virtual-structure", {"adaptive_roles", "springs", "rigid"}),
        ("behaviour-based", {"adaptive_roles", "springs", "common_plan"}),
    ],
)
def test_each_switches_what_it_says(name, parts):
    assert differences(name) == parts


def test_every_variant_is_known_by_its_own_name():
    for name, variant in VARIANTS.items():
        assert variant_named(name) is variant
        assert variant.name == name


def test_an_unknown_one_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r"'clever'.*published.*behaviour-based"):
        variant_named("clever")
