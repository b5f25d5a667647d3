"""Methods as the variants of suites whose robots have goals of their own."""

from __future__ import annotations

from typing import Any

import pytest

from cavalcade.campaign.definition import check_definition, define_campaign
from cavalcade.campaign.methods import (
    FORMATION_VARIANTS,
    METHOD_VARIANTS,
    changed,
    planner_settings,
)
from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.suite import Suite, parse_suite
from cavalcade.campaign.trial import trials_of
from cavalcade.coordination import METHODS
from cavalcade.errors import InputError
from cavalcade.scenario.settings import TEAM_METHODS

FORMATION = {"name": "drive", "sampler": "shipped", "scenario": "cone", "seeds": 1}
PLAN = {"name": "swap", "sampler": "shipped", "scenario": "head-on", "seeds": 1}


def suite_of(*groups: dict[str, Any], **head: Any) -> Suite:
    return parse_suite({"version": 1, "suite": "mine", "worlds": list(groups), **head})


def ids(suite: Suite) -> list[str]:
    return [trial.id for trial in trials_of(suite, (), DataFolder(None))]


def test_the_methods_are_those_of_coordination_and_of_scenarios() -> None:
    plain = {name for name in METHOD_VARIANTS if "-" not in name}
    assert plain == set(METHODS) == set(TEAM_METHODS)
    assert not set(METHOD_VARIANTS) & set(FORMATION_VARIANTS)


def test_variants_by_default_are_those_of_the_kind() -> None:
    assert ids(suite_of(PLAN)) == ["swap.0000.auto"]
    assert ids(suite_of(FORMATION)) == ["drive.0000.cavalcade"]
    both = suite_of(FORMATION, PLAN)
    assert ids(both) == ["drive.0000.cavalcade", "swap.0000.auto"]
    assert both.variants == ("cavalcade", "auto")


def test_a_group_may_name_its_own() -> None:
    suite = suite_of(PLAN, PLAN | {"name": "again", "variants": ["joint"]}, variants=["cbs"])
    assert ids(suite) == ["swap.0000.cbs", "again.0000.joint"]
    assert suite.variants == ("cbs", "joint")
    assert parse_suite(suite.to_dict()) == suite


def test_a_suite_of_one_kind_says_itself_as_ever() -> None:
    plain = suite_of(FORMATION).to_dict()
    assert "variants" not in plain["worlds"][0]


@pytest.mark.parametrize("name", METHOD_VARIANTS)
def test_a_variant_sets_method_and_options(name: str) -> None:
    suite = suite_of(PLAN, variants=[name])
    trial = next(trials_of(suite, (), DataFolder(None)))
    scenario = trial.scenario(trial.instance())
    published = name.endswith("-published")
    assert scenario.planner.method == name.removesuffix("-published")
    assert scenario.planner.variant == ("published" if published else "cavalcade")
    assert scenario.planner.constraints == ("static" if published else "timed")
    assert scenario.planner.conflict == ("first" if published else "costly")
    assert planner_settings(name, True)["method"] == scenario.planner.method


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            {"variants": ["cavalcade"], "worlds": [PLAN]},
            "variants[0]: 'cavalcade' is for formations, not for individual goals",
        ),
        (
            {"variants": ["auto", "cbs"], "worlds": [FORMATION]},
            "variants[0]: 'auto' is for individual goals, not for formations",
        ),
        (
            {"worlds": [PLAN | {"variants": ["cbs-publisht"]}]},
            "worlds[0].variants[0]: unknown value 'cbs-publisht'; did you mean cbs-published?",
        ),
        (
            {"variants": ["nothing"], "worlds": [PLAN | {"variants": ["cbs"]}]},
            "variants[0]: unknown value 'nothing'",
        ),
        ({"worlds": [PLAN | {"variants": []}]}, "worlds[0].variants: expected at least 1"),
        (
            {"worlds": [PLAN | {"variants": ["cbs", "cbs"]}]},
            "worlds[0].variants: a variant stands here twice",
        ),
    ],
)
def test_bad_variants_are_one_line(said: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_suite({"version": 1, "suite": "mine", **said})
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_methods_are_changed_each_once() -> None:
    names = ("auto", "cbs", "cbs-published")
    assert changed(names, None, "published") == ("auto-published", "cbs-published")
    assert changed(names, "joint", None) == ("joint", "joint-published")
    assert changed(names, "joint", "published") == ("joint-published",)
    assert changed(names, None, None) == names


def test_a_method_given_takes_the_place_of_the_suites() -> None:
    definition = define_campaign(
        "swaps", overrides=["planner.method=cbs", "planner.leaps=false"], seeds=1
    )
    assert definition.suite.variants == ("cbs",)
    assert definition.overrides == ("planner.leaps=false",)
    check_definition(definition)
    paper = define_campaign("table1", overrides=["planner.variant=published"], seeds=1)
    assert all(name.endswith("-published") for name in paper.suite.variants)
    for key, value in (("method", "cbz"), ("variant", "no-springs")):
        with pytest.raises(InputError, match=f"--set planner.{key}: unknown value '{value}'"):
            define_campaign("swaps", overrides=[f"planner.{key}={value}"])
    with pytest.raises(InputError, match=r"--set planner.method: give it by itself"):
        check_definition(
            define_campaign("swaps", overrides=["planner={method: cbs, variant: cavalcade}"])
        )
