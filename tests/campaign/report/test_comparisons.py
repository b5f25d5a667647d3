import pytest
from cavalcade.campaign.report.blocks import Table
from cavalcade.campaign.report.comparison_chart import draw_comparisons
from cavalcade.campaign.report.comparison_tables import comparison_tables

from cavalcade.campaign.report.comparisons import (
    ALL,
    QUANTITIES,
    compare_disturbances,
    compare_variants,
)
from cavalcade.campaign.report.trials import Order, Trial, read_trials
from cavalcade.campaign.report.wording import NO_DIFFERENCE, success_words, value_words


def trial(seed, variant, success=True, time=10.0, **changes):
    summary = {"makespan_s": time, "formation_error_m": {"mean": 0.1}}
    values = {"scenario": "a", "disturbance": "none", "summary": summary, **changes}
    name = f"{values['scenario']}.{seed}.{variant}.{values['disturbance']}"
    return Trial(name=name, seed=seed, variant=variant, success=success, **values)


def compare(trials):
    order = Order.of(object(), trials)
    return compare_variants(trials, order), compare_disturbances(trials, order)


def test_only_the_same_worlds_are_compared():
    trials = [trial(k, "cavalcade") for k in range(10)] + [trial(k, "other") for k in range(5, 15)]
    (found,), none = compare(trials)
    assert none == []
    assert (found.first, found.second) == ("cavalcade", "other")
    assert found.success.pairs == 5


def test_worlds_that_are_not_feasible_do_not_count_for_success_but_for_collisions():
    trials = [
        trial(k, v, success=False, feasible=False, avoidable=int(v == "other"))
        for k in range(4)
        for v in ("cavalcade", "other")
    ]
    (found,), _ = compare(trials)
    assert found.success is None
    assert found.collision.second_only == 4


def test_values_are_compared_where_both_succeeded():
    trials = [trial(k, "cavalcade", time=10.0 + k) for k in range(8)]
    trials += [trial(k, "other", time=12.0 + k, success=k < 6) for k in range(8)]
    (found,), _ = compare(trials)
    time = found.values[0]
    assert time.pairs == 6
    assert time.mean.value == pytest.approx(2.0)
    assert value_words(time, QUANTITIES[0]) == "slower by 2.0 s"
    assert value_words(found.values[1], QUANTITIES[1]) == NO_DIFFERENCE
    assert found.values[2] is None  # nobody measured the gap


def test_words_say_which_is_better():
    trials = [trial(k, "cavalcade") for k in range(60)]
    trials += [trial(k, "worse", success=k >= 20) for k in range(60)]
    trials += [trial(k, "alike", success=k >= 1) for k in range(60)]
    (alike, worse), _ = compare(trials)
    assert success_words(alike.success) == NO_DIFFERENCE
    assert success_words(worse.success) == "fewer successes by 33.3 points"
    assert worse.success.p_value < 1e-4


def test_all_scenarios_together_where_there_are_several(make_lines, suite):
    trials = read_trials(make_lines(20))
    found = compare_variants(trials, Order.of(suite, trials))
    assert [(c.scenario, c.second) for c in found] == [
        (s, v) for s in ("clutter", "forest", "all scenarios") for v in ("published", "no-springs")
    ]
    assert found[4].collision.pairs == 40


def test_disturbances_are_compared_for_each_variant(make_lines, suite):
    lines = make_lines(10, ("clutter",), ("none", "late"), ("cavalcade", "published"))
    trials = read_trials(lines)
    found = compare_disturbances(trials, Order.of(suite, trials))
    assert [(c.setting, c.first, c.second) for c in found] == [
        ("cavalcade", "none", "late"),
        ("published", "none", "late"),
    ]
    variants = compare_variants(trials, Order.of(suite, trials))
    assert [(c.setting, c.second) for c in variants] == [
        ("none", "published"),
        ("late", "published"),
    ]


def test_a_variant_may_have_another_reference():
    names = ("cavalcade", "other", "part", "less")
    trials = [trial(k, variant) for k in range(3) for variant in names]
    references = {"part": "other", "less": "absent"}
    order = Order(("a",), names, ("none",), references)
    found = compare_variants(trials, order)
    assert [(c.first, c.second) for c in found] == [("cavalcade", "other"), ("other", "part")]
    tables = [b for b in comparison_tables(found, "variant", "") if isinstance(b, Table)]
    assert all(table.head[:3] == ("scenario", "variant", "reference") for table in tables)
    assert tables[0].rows[1][:3] == ("`a`", "`part`", "`other`")
    assert "with reference" in tables[0].head
    (single,) = {t.head[3] for t in comparison_tables(found[:1], "variant", "")[1:2]}
    assert single == "`cavalcade`"


def test_fewer_than_six_pairs_are_too_few_for_an_interval(tmp_path):
    def found_in(pairs):
        trials = [trial(k, "cavalcade") for k in range(pairs)]
        trials += [trial(k, "other", time=12.0 + k) for k in range(pairs)]
        return compare(trials)[0]

    (few,), (enough,) = found_in(5), found_in(6)
    assert value_words(few.values[0], QUANTITIES[0]) == "too few pairs"
    assert value_words(enough.values[0], QUANTITIES[0]).startswith("slower by")
    time = comparison_tables([few], "variant", "")[4]
    assert time.rows[0][-1] == "too few pairs"
    assert all("too few pairs" in text for text in time.rows[0][3:])
    assert draw_comparisons([few], False, tmp_path, "few").png


def test_a_group_called_all_is_a_group_like_others():
    trials = [
        trial(k, variant, scenario=scenario)
        for scenario, number in (("all", 3), ("b", 4))
        for k in range(number)
        for variant in ("cavalcade", "other")
    ]
    found, _ = compare(trials)
    assert [(c.scenario, c.success.pairs) for c in found] == [("all", 3), ("b", 4), (ALL, 7)]
