import pytest
from cavalcade.campaign.report.verdict import Spread, cells_of, in_order

from cavalcade.campaign.report.trials import Order, Trial, read_trials


def trial(number=0, **changes):
    values = {"scenario": "a", "variant": "cavalcade", "outcome": "arrived", "success": True}
    values |= {"name": f"a.{number}.{changes.get('variant', '')}", "seed": number, **changes}
    return Trial(**values)


def test_the_order_is_the_suites(make_lines, suite):
    trials = read_trials(reversed(make_lines(3)))
    order = Order.of(suite, trials)
    assert order.scenarios == ("clutter", "forest")
    assert order.variants == ("cavalcade", "published", "no-springs")
    assert [t.name for t in order.sorted(trials)] == [line["trial"] for line in make_lines(3)]


def test_names_the_suite_does_not_know_follow():
    trials = [
        trial(0, variant=v, disturbance=d) for v in ("z", "b", "cavalcade") for d in ("x", "none")
    ]
    order = Order.of(object(), trials)
    assert order.variants == ("cavalcade", "b", "z")
    assert order.disturbances == ("none", "x")


def test_cells_count_what_they_should(make_lines, suite):
    lines = make_lines(80)
    trials = read_trials(lines)
    cells = cells_of(trials, Order.of(suite, trials))
    assert [(c.scenario, c.variant) for c in cells] == [
        (s, v) for s in ("clutter", "forest") for v in ("cavalcade", "published", "no-springs")
    ]
    for cell in cells:
        mine = [
            line
            for line in lines
            if (line["scenario"], line["variant"]) == (cell.scenario, cell.variant)
        ]
        assert len(cell.trials) == 80
        assert len(cell.feasible) == sum(line["feasible"] for line in mine)
        assert cell.feasible_successes == sum(line["success"] and line["feasible"] for line in mine)
        assert cell.hit == sum(line["avoidable"] > 0 for line in mine)
        assert sum(cell.outcomes.values()) == 80
        low, high = cell.interval
        assert low <= cell.feasible_successes / len(cell.feasible) <= high
        gaps = [line["summary"]["min_footprint_gap_m"] for line in mine]
        assert cell.spread("min_footprint_gap_m").least == min(gaps)


def test_collisions_are_bounded_by_the_trials_that_ran():
    trials = [trial(k, summary={"sim_time_s": 1.0}) for k in range(30)]
    trials += [trial(k, outcome="crashed", success=False) for k in range(30, 60)]
    (cell,) = cells_of(trials, Order.of(object(), trials))
    assert len(cell.run) == 30
    assert cell.hit_bound == pytest.approx(1.0 - 0.05 ** (1 / 30))


def test_time_is_of_successes_only_and_falls_back_on_the_end():
    done = trial(summary={"makespan_s": None, "sim_time_s": 40.0})
    assert done.time == 40.0
    assert trial(success=False, summary={"makespan_s": 3.0}).time is None


def test_lines_that_lack_everything_are_still_trials():
    (found,) = read_trials([{"trial": "x"}])
    assert found.name == "x"
    assert not found.success
    assert found.number("a.b") is None
    odd = {"trial": "x", "level": float("nan"), "measured": None, "summary": None, "success": None}
    (found,) = read_trials([odd])
    assert found.level is None
    assert found.summary == {}


def test_spread_without_values():
    assert Spread.of([None]).median is None
    assert Spread.of([1.0, 2.0, 3.0]).median == 2.0


def test_unknown_outcomes_come_last():
    assert list(in_order({"zzz": 1, "crashed": 2, "arrived": 3})) == ["arrived", "crashed", "zzz"]
