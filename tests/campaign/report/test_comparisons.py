from types import SimpleNamespace

import pytest

from cavalcade.campaign.report.cells import ALL
from cavalcade.campaign.report.charts import draw_comparisons
from cavalcade.campaign.report.comparisons import (
    QUANTITIES,
    compare,
    comparison_tables,
    proportion_text,
    value_text,
)
from cavalcade.campaign.report.wording import NO_DIFFERENCE

TIME, ERROR, GAP = QUANTITIES


@pytest.fixture
def trial(make_line):
    def made(seed, variant, success=True, time=10.0, **changes):
        summary = {"reason": "x", "makespan_s": time, "formation_error_m": {"mean": 0.1}}
        changes = {"success": success, "summary": summary, **changes}
        return make_line(seed, variant=variant, **changes)

    return made


@pytest.fixture
def compared(open_table):
    def both(lines, suite=None):
        table = open_table(lines, suite)
        return compare(table, "variant"), compare(table, "disturbance")

    return both


def test_only_the_same_worlds_are_compared(trial, compared):
    lines = [trial(k, "cavalcade") for k in range(10)] + [trial(k, "other") for k in range(5, 15)]
    (found,), none = compared(lines)
    assert none == []
    assert (found.first, found.second) == ("cavalcade", "other")
    assert found.success.pairs == 5


def test_worlds_that_are_not_feasible_do_not_count_for_success_but_for_collisions(trial, compared):
    lines = [
        trial(k, v, success=False, feasible=False, avoidable=int(v == "other"))
        for k in range(4)
        for v in ("cavalcade", "other")
    ]
    (found,), _ = compared(lines)
    assert found.success is None
    assert found.collision.second_only == 4


def test_problems_without_a_plan_are_not_compared(trial, compared):
    lines = [
        trial(k, v, expected="infeasible", feasible=False)
        for k in range(4)
        for v in ("auto", "cbs")
    ]
    assert compared(lines) == ([], [])


def test_values_are_compared_where_both_succeeded(trial, compared):
    lines = [trial(k, "cavalcade", time=10.0 + k) for k in range(8)]
    lines += [trial(k, "other", time=12.0 + k, success=k < 6) for k in range(8)]
    (found,), _ = compared(lines)
    time = found.values[TIME]
    assert time.pairs == 6
    assert time.mean.value == pytest.approx(2.0)
    assert value_text(time, TIME) == "slower by 2.0 s"
    assert value_text(found.values[ERROR], ERROR) == NO_DIFFERENCE
    assert found.values[GAP] is None  # nobody measured the gap


def test_words_say_which_is_better(trial, compared):
    lines = [trial(k, "cavalcade") for k in range(60)]
    lines += [trial(k, "worse", success=k >= 20) for k in range(60)]
    lines += [trial(k, "alike", success=k >= 1) for k in range(60)]
    (alike, worse), _ = compared(lines)
    assert proportion_text(alike.success, "successes") == NO_DIFFERENCE
    assert proportion_text(worse.success, "successes") == "fewer successes by 33.3 points"
    assert worse.success.p_value < 1e-4


def test_all_scenarios_together_where_there_are_several(make_lines, suite, compared):
    found, _ = compared(make_lines(20), suite)
    assert [(c.scenario, c.second) for c in found] == [
        (s, v) for s in ("clutter", "forest", "all scenarios") for v in ("published", "no-springs")
    ]
    assert found[4].collision.pairs == 40


def test_disturbances_are_compared_for_each_variant(make_lines, suite, compared):
    lines = make_lines(10, ("clutter",), ("none", "late"), ("cavalcade", "published"))
    variants, disturbances = compared(lines, suite)
    assert [(c.setting, c.first, c.second) for c in disturbances] == [
        ("cavalcade", "none", "late"),
        ("published", "none", "late"),
    ]
    assert [(c.setting, c.second) for c in variants] == [
        ("none", "published"),
        ("late", "published"),
    ]


def test_a_variant_may_have_another_reference(trial, compared):
    names = ("cavalcade", "other", "part", "less")
    suite = SimpleNamespace(variants=names, references={"part": "other", "less": "absent"})
    found, _ = compared([trial(k, name) for k in range(3) for name in names], suite)
    assert [(c.first, c.second) for c in found] == [("cavalcade", "other"), ("other", "part")]
    tables = [made for _, made in comparison_tables(found, "variant", "") if made]
    assert all(table.head[:3] == ("scenario", "variant", "reference") for table in tables)
    assert tables[0].rows[1][:3] == ("`a`", "`part`", "`other`")
    assert "with reference" in tables[0].head
    (_, single), *_ = comparison_tables(found[:1], "variant", "")
    assert single.head[3] == "`cavalcade`"


def test_fewer_than_six_pairs_are_too_few_for_an_interval(trial, compared):
    def found_in(pairs):
        lines = [trial(k, "cavalcade") for k in range(pairs)]
        lines += [trial(k, "other", time=12.0 + k) for k in range(pairs)]
        return compared(lines)[0]

    (few,), (enough,) = found_in(5), found_in(6)
    assert value_text(few.values[TIME], TIME) == "too few pairs"
    assert value_text(enough.values[TIME], TIME).startswith("slower by")
    made = dict(comparison_tables([few], "variant", ""))
    assert made["Trials with an avoidable collision"] is None
    time = made["Time, where both succeeded"]
    assert time.rows[0][-1] == "too few pairs"
    assert all("too few pairs" in text for text in time.rows[0][3:])
    assert len(draw_comparisons([few], False).axes) == 4


def test_a_group_called_all_is_a_group_like_others(trial, compared):
    lines = [
        trial(k, variant, scenario=scenario)
        for scenario, number in (("all", 3), ("b", 4))
        for k in range(number)
        for variant in ("cavalcade", "other")
    ]
    found, _ = compared(lines)
    assert [(c.scenario, c.success.pairs) for c in found] == [("all", 3), ("b", 4), (ALL, 7)]


def test_plans_and_formations_in_one_campaign_have_each_their_quantities(trial, compared):
    def plan(seed, disturbance, seconds):
        summary = {"reason": "solved", "planning_time_s": seconds, "min_footprint_gap_m": 0.1}
        return trial(seed, "auto", scenario="b", disturbance=disturbance, summary=summary)

    lines = [trial(k, "cavalcade", disturbance=d) for k in range(6) for d in ("none", "late")]
    lines += [plan(k, d, 1.0 + (d == "late")) for k in range(6) for d in ("none", "late")]
    made = dict(comparison_tables(compared(lines)[1], "disturbance", "variant"))
    planning = made["Planning time, where both succeeded"]
    assert [row[:3] for row in planning.rows] == [
        ("`b`", "`auto`", "`late`"),
        (ALL, "`auto`", "`late`"),
    ]
    assert planning.rows[0][4].startswith("+1.0000")
    assert [row[1] for row in made["Smallest gap, where both succeeded"].rows] == ["`auto`"] * 2
