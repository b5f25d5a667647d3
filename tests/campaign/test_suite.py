"""Suite files: what is accepted, and the one line about what is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from cavalcade.campaign.definition import check_definition, define_campaign, difference
from cavalcade.campaign.samplers import SAMPLERS, DataFolder
from cavalcade.campaign.suite import load_suite, parse_suite, suite_names
from cavalcade.campaign.trial import trials_of
from cavalcade.errors import InputError

NO_DATA = DataFolder(None)

PROMISED = {
    *("clutter", "forest", "rooms", "corridors", "barn", "real-maps", "sizes"),
    *("disturbed", "events", "ablation", "smoke"),
    *("table1", "swaps", "corridor", "crowd", "terrain", "infeasible", "smoke-plans"),
}


def test_what_is_promised_is_shipped() -> None:
    assert set(suite_names()) >= PROMISED


@pytest.mark.parametrize("name", suite_names())
def test_every_shipped_suite_is_read_and_says_itself_again(name: str) -> None:
    suite = load_suite(name)
    assert suite.suite == suite.name == name
    assert suite.about
    assert parse_suite(suite.to_dict()) == suite


def test_trials_in_their_order() -> None:
    suite = parse_suite(
        {
            "version": 1,
            "suite": "a",
            "seed": 7,
            "variants": ["cavalcade", "published"],
            "disturbances": {"none": {}, "late": {"delay": {"mean": 0.1}}},
            "worlds": [
                {"name": "one", "sampler": "shipped", "scenario": "cone", "seeds": 2},
                {"name": "two", "sampler": "shipped", "scenario": "cone", "seeds": 1},
            ],
        }
    )
    ids = [trial.id for trial in trials_of(suite, (), NO_DATA)]
    assert ids == [
        "one.0007.cavalcade.none",
        "one.0007.published.none",
        "one.0007.cavalcade.late",
        "one.0007.published.late",
        "one.0008.cavalcade.none",
        "one.0008.published.none",
        "one.0008.cavalcade.late",
        "one.0008.published.late",
        "two.0007.cavalcade.none",
        "two.0007.published.none",
        "two.0007.cavalcade.late",
        "two.0007.published.late",
    ]
    trial = next(t for t in trials_of(suite, ("execution.rate=10",), NO_DATA) if "late" in t.id)
    scenario = trial.scenario(trial.instance())
    assert (scenario.planner.variant, scenario.seed) == ("cavalcade", 7)
    assert (scenario.execution.delay.mean, scenario.execution.rate) == (0.1, 10.0)


def test_ids_without_named_disturbances() -> None:
    definition = define_campaign("clutter", seeds=2, seed=9_999)
    assert [trial.id for trial in definition.trials] == [
        "clutter.9999.cavalcade",
        "clutter.10000.cavalcade",
    ]
    assert {trial.disturbance for trial in definition.trials} == {"none"}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("version", 2, "version: expected 1"),
        ("sute", "a", "sute: unknown key; did you mean suite?"),
        ("suite", "a.b", "suite: "),
        ("variants", ["cavalkade"], "variants[0]: unknown value 'cavalkade'; did you mean"),
        ("variants", ["published", "published"], "variants: a variant stands here twice"),
        ("variants", [], "variants: expected at least 1"),
        ("time_limit", -1, "time_limit: "),
        ("disturbances", {"a": {"dely": {}}}, "disturbances.a.dely: unknown key"),
        ("disturbances", {"a": {"delay": {"mean": "x"}}}, "disturbances.a.delay.mean: expected"),
        ("references", {"cavalcade": "cavalkade"}, "references.cavalcade: 'cavalkade' is none of"),
        (
            "references",
            {"cavalcade": "published"},
            "references.cavalcade: 'published' is none of the suite's variants (cavalcade)",
        ),
        ("references", {"no-springs": "cavalcade"}, "references.no-springs: 'no-springs' is none"),
        ("references", {"cavalcade": "cavalcade"}, "references.cavalcade: a variant cannot be"),
        ("references", ["published"], "references: expected "),
        ("worlds", [], "worlds: expected at least 1"),
        ("worlds", "clutter", "worlds: expected a list"),
        (
            "worlds.0.sampler",
            "generate",
            "worlds[0].sampler: unknown value 'generate'; did you mean",
        ),
        ("worlds.0.sampler", None, "worlds[0].sampler: unknown value None"),
        ("worlds.0.name", "a/b", "worlds[0].name: "),
        ("worlds.0.name", None, "worlds[0].name: "),
        ("worlds.0.seeds", 0, "worlds[0].seeds: "),
        ("worlds.0.seeds", "many", "worlds[0].seeds: expected a whole number, got 'many'"),
        ("worlds.0.obstakles", 3, "worlds[0].obstakles: unknown key; did you mean obstacles?"),
        ("worlds.0.kind", "clutta", "worlds[0].kind: unknown value 'clutta'"),
        ("worlds.0.size", [1], "worlds[0].size: "),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, path: str, value: Any, message: str) -> None:
    data: Any = {
        "version": 1,
        "suite": "mine",
        "worlds": [
            {
                "name": "clutter",
                "sampler": "generated",
                "kind": "clutter",
                "size": [14, 10],
                "obstacles": 15,
                "team": {"shape": "square", "side": 1.0},
                "seeds": 3,
            }
        ],
    }
    here = data
    *steps, last = path.split(".")
    for step in steps:
        here = here[int(step) if step.isdigit() else step]
    here[last] = value
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_suite(file)
    text = str(caught.value)
    assert text.startswith(f"{file}: {message}")
    assert "\n" not in text


def test_groups_have_names_of_their_own() -> None:
    group = {"name": "a", "sampler": "shipped", "scenario": "cone", "seeds": 1}
    with pytest.raises(InputError, match=r"worlds\[1\]\.name: 'a' is there already"):
        parse_suite({"version": 1, "suite": "x", "worlds": [group, group]})


def test_groups_without_names_are_not_called_alike() -> None:
    group = {"sampler": "shipped", "scenario": "cone", "seeds": 1}
    with pytest.raises(InputError, match=r"worlds\[0\]\.name: missing"):
        parse_suite({"version": 1, "suite": "x", "worlds": [group, group]})


def test_endless_worlds_need_a_number(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    group = {"name": "a", "sampler": "shipped", "scenario": "cone"}
    file.write_text(yaml.safe_dump({"version": 1, "suite": "own", "worlds": [group]}))
    with pytest.raises(InputError) as caught:
        define_campaign(file)
    assert str(caught.value).startswith(f"{file}: worlds[0].seeds: missing; expected how many")
    assert len(define_campaign(file, seeds=3).trials) == 3


def test_a_scenario_file_that_cannot_be_used_is_refused_at_once(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    (tmp_path / "scenario.yaml").write_text("version: 1\nnaem: x\n", encoding="utf-8")
    group = {"name": "a", "sampler": "shipped", "scenario": "scenario.yaml", "seeds": 2}
    file.write_text(yaml.safe_dump({"version": 1, "suite": "own", "worlds": [group]}))
    with pytest.raises(InputError) as caught:
        define_campaign(file)
    said = f"{file}: worlds[0]: {tmp_path / 'scenario.yaml'}: naem: unknown key"
    assert str(caught.value).startswith(said)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"seeds": 10**11}, "--seeds: expected a whole number from 1 to 1000000, got 100000000000"),
        ({"seed": 2**63}, "--seed: expected a whole number from 0 to 9223372036854775807, got "),
    ],
)
def test_numbers_have_a_limit(numbers: dict[str, int], message: str) -> None:
    with pytest.raises(InputError) as caught:
        define_campaign("clutter", **numbers)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cluter", "cluter: no such file or shipped suite; did you mean clutter?"),
        ("nothing.yaml", "nothing.yaml: no such file or shipped suite (one of: ablation, barn,"),
        ("", "no such file or shipped suite"),
        ("a\nb", "'a\\nb': no such file or shipped suite"),
        ("x" * 5000, "'xxxx"),
    ],
)
def test_no_such_suite(name: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        load_suite(name)
    assert message in str(caught.value)
    assert "clutter" in str(caught.value)


def test_draws_have_names() -> None:
    assert {"generated", "barn", "maps", "events", "shipped"} <= set(SAMPLERS)


def test_the_data_may_be_absent(tmp_path: Path) -> None:
    suite = load_suite("barn")
    assert suite.missing(DataFolder(tmp_path))
    assert load_suite("clutter").missing(NO_DATA) is None


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["planner.lookahed=3"], "--set planner.lookahed: unknown key; did you mean lookahead?"),
        (["planner.lookahead=far"], "--set planner.lookahead: expected a number, got 'far'"),
        (["lookahead=3"], "--set lookahead: unknown key"),
        (["planner.lookahead"], "--set: expected KEY=VALUE"),
        (["world.obstacles[0]=1"], "--set world.obstacles"),
        (["planner={variant: published}"], "--set planner.variant: give it by itself"),
        (["execution.seed=5"], "--set execution.seed: every world has its own; use --seed"),
    ],
)
def test_overrides_are_tried_before_anything_runs(overrides: list[str], message: str) -> None:
    with pytest.raises(InputError) as caught:
        check_definition(define_campaign("clutter", overrides=overrides))
    assert str(caught.value).startswith(message)


def test_a_variant_given_takes_the_place_of_the_suites() -> None:
    definition = define_campaign(
        "smoke", overrides=["planner.variant=published", "execution.rate=10"]
    )
    assert definition.suite.variants == ("published",)
    assert definition.overrides == ("execution.rate=10",)
    check_definition(definition)
    quoted = define_campaign("smoke", overrides=['planner.variant="published"'])
    assert quoted.suite.variants == ("published",)
    with pytest.raises(InputError) as caught:
        define_campaign("smoke", overrides=["planner.variant=publisht"])
    said = "--set planner.variant: unknown value 'publisht'; did you mean published?"
    assert str(caught.value).startswith(said)


def test_a_variant_given_has_no_reference() -> None:
    assert load_suite("ablation").references["no-springs"] == "published"
    definition = define_campaign("ablation", overrides=["planner.variant=no-springs"])
    assert (definition.suite.variants, definition.suite.references) == (("no-springs",), {})


def test_the_fingerprint_tells_campaigns_apart() -> None:
    definitions = [
        define_campaign("clutter"),
        define_campaign("clutter", seeds=5),
        define_campaign("clutter", seed=5),
        define_campaign("clutter", overrides=["execution.rate=10"]),
        define_campaign("forest"),
    ]
    assert len({definition.fingerprint for definition in definitions}) == 5
    assert define_campaign("clutter").fingerprint == definitions[0].fingerprint


def test_close_matches_of_a_trials_name() -> None:
    definition = define_campaign("clutter", seeds=20)
    with pytest.raises(InputError) as caught:
        definition.trial("clutter.0013.cavalkade")
    assert "did you mean clutter.0013.cavalcade or " in str(caught.value)
    with pytest.raises(InputError, match="no such trial: ''"):
        definition.trial("")


FORMER = """\
version: 1
suite: former
worlds:
  - {name: one, draw: shipped, scenario: cone, seeds: 1}
  - {name: two, draw: hopeless, kind: goals-equal, seeds: 1}
"""


def test_former_names_are_read_with_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "former.yaml"
    file.write_text(FORMER, encoding="utf-8")
    with pytest.warns(FutureWarning, match=r"former.yaml: `draw` of worlds is called `sampler`"):
        before = define_campaign(file)
    current = FORMER.replace("draw: hopeless", "sampler: infeasible").replace("draw:", "sampler:")
    file.write_text(current, encoding="utf-8")
    after = define_campaign(file)
    assert before.to_dict() == after.to_dict()
    # The folder of a campaign that was begun with them is that of the same campaign.
    worlds = yaml.safe_load(FORMER)["worlds"]
    for group, now in zip(worlds, after.suite.to_dict()["worlds"], strict=True):
        group |= {key: value for key, value in now.items() if key != "sampler"}
    suite = {**after.suite.to_dict(), "worlds": worlds}
    begun = {**after.to_dict(), "fingerprint": "0", "suite": suite}
    assert difference(after, begun) is None
    worlds[0]["seeds"] = 2
    assert difference(after, begun) == "was begun with other values in suite former: worlds"
