import pytest

from cavalcade.campaign.report.comparisons import (
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
        (s, v) for s in ("clutter", "forest", "all") for v in ("published", "no-springs")
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
