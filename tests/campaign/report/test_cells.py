import math

import numpy as np
import pytest

from cavalcade.campaign.report.cells import cells_of, in_order


def test_the_order_is_the_suites(make_lines, suite, open_table):
    table = open_table(make_lines(3)[::-1], suite)
    assert table.order.scenarios == ("clutter", "forest")
    assert table.order.variants == ("cavalcade", "published", "no-springs")
    assert [t.name for t in table.trials()] == [line["trial"] for line in make_lines(3)]


def test_names_the_suite_does_not_know_follow(make_line, open_table):
    lines = [
        make_line(0, variant=v, disturbance=d)
        for v in ("z", "b", "cavalcade")
        for d in ("x", "none")
    ]
    order = open_table(lines).order
    assert order.variants == ("cavalcade", "b", "z")
    assert order.disturbances == ("none", "x")


def test_cells_count_what_they_should(make_lines, suite, open_table):
    lines = make_lines(80)
    cells = cells_of(open_table(lines, suite))
    assert [(c.scenario, c.variant) for c in cells] == [
        (s, v) for s in ("clutter", "forest") for v in ("cavalcade", "published", "no-springs")
    ]
    for cell in cells:
        mine = [
            line
            for line in lines
            if (line["scenario"], line["variant"]) == (cell.scenario, cell.variant)
        ]
        feasible = [line for line in mine if line["feasible"]]
        assert cell.trials == cell.ran == 80
        assert cell.feasible == len(feasible)
        assert cell.feasible_successes == sum(line["success"] for line in feasible)
        assert cell.hit == sum(line["avoidable"] > 0 for line in mine)
        assert sum(cell.outcomes.values()) == 80
        assert sum(cell.failures.values()) == cell.feasible - cell.feasible_successes
        assert sum(cell.excused.values()) == 80 - cell.feasible
        low, high = cell.interval
        assert low <= cell.feasible_successes / cell.feasible <= high


def test_spreads_are_those_that_numpy_finds(make_lines, suite, open_table):
    lines = make_lines(80, ("clutter",), variants=("cavalcade",))
    (cell,) = cells_of(open_table(lines, suite))
    gaps = [line["summary"]["min_footprint_gap_m"] for line in lines]
    times = [line["summary"]["makespan_s"] for line in lines if line["success"]]
    for name, values in (("gap", gaps), ("time", times)):
        found = cell.spreads[name]
        shares = {"least": 0, "p5": 5, "p25": 25, "median": 50, "p75": 75, "p95": 95, "p99": 99,
                  "most": 100}  # fmt: skip
        for end, share in shares.items():
            assert getattr(found, end) == pytest.approx(np.percentile(values, share), rel=1e-12)
        assert found.mean == pytest.approx(np.mean(values), rel=1e-12)


def test_what_nobody_measured_has_no_spread(make_line, open_table):
    (cell,) = cells_of(open_table([make_line(k) for k in range(3)]))
    assert cell.spreads["gap"].median is None
    assert cell.spreads["time"].mean is None


def test_all_scenarios_can_be_counted_together(make_lines, suite, open_table):
    table = open_table(make_lines(20), suite)
    found = cells_of(table, over_scenarios=True)
    assert [(c.scenario, c.variant, c.trials) for c in found] == [
        ("all scenarios", variant, 40) for variant in suite.variants
    ]


def test_collisions_are_bounded_by_the_trials_that_ran(make_line, open_table):
    lines = [make_line(k) for k in range(30)]
    lines += [make_line(k, outcome="crashed", summary={}) for k in range(30, 60)]
    (cell,) = cells_of(open_table(lines))
    assert cell.ran == 30
    assert cell.hit_bound == pytest.approx(1.0 - 0.05 ** (1 / 30))


def test_time_is_of_successes_only_and_falls_back_on_the_end(make_line, open_table):
    done = {"reason": "arrived", "makespan_s": None, "sim_time_s": 40.0}
    (cell,) = cells_of(open_table([make_line(0, summary=done)]))
    assert cell.spreads["time"].median == 40.0
    failed = make_line(0, outcome="stuck", summary={"reason": "stuck", "makespan_s": 3.0})
    (cell,) = cells_of(open_table([failed]))
    assert cell.spreads["time"].median is None


def test_a_length_is_known_only_where_that_of_every_robot_is(make_line, open_table):
    lengths = {"whole": [1.0, 2.5], "part": [1.0, None], "empty": [], "none": None}
    lines = [
        make_line(k, scenario=name, summary={"reason": "solved", "path_length_m": values})
        for k, (name, values) in enumerate(lengths.items())
    ]
    found = {c.scenario: c.spreads["length"].most for c in cells_of(open_table(lines))}
    assert found == {"whole": 3.5, "part": None, "empty": None, "none": None}


def test_lines_that_lack_everything_are_still_trials(open_table):
    table = open_table([{"trial": "x"}])
    (found,) = table.trials()
    assert (found.name, *table.order.scenarios, found.outcome) == ("x", "?", "unknown")
    assert not found.success
    assert not found.ran
    assert found.gap is None
    odd = {"trial": "x", "level": math.nan, "measured": None, "summary": None, "success": None}
    (found,) = open_table([odd]).trials()
    assert found.level is None
    assert not found.success


def test_a_folder_may_be_called_like_a_pattern(make_line, tmp_path):
    from cavalcade.campaign.report.trials import TrialTable
    from cavalcade.campaign.table import write_table

    folder = tmp_path / "it's [1]*" / "seed=3"
    folder.mkdir(parents=True)
    with TrialTable(write_table(folder, [make_line(7)]), None) as table:
        assert table.rows("SELECT seed FROM trials") == [(7,)]


def test_unknown_outcomes_come_last():
    assert list(in_order({"zzz": 1, "crashed": 2, "arrived": 3})) == ["arrived", "crashed", "zzz"]
