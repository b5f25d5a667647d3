import pytest

from cavalcade.campaign.report.canvas import series_color, series_marker
from cavalcade.campaign.report.cells import BINS, cells_of, curves_of


@pytest.fixture
def curve(open_table, make_line):
    def made(levels, **changes):
        lines = [
            make_line(k, level=level, level_name="robots", **changes)
            for k, level in enumerate(levels)
        ]
        table = open_table(lines)
        found = curves_of(table, cells_of(table))
        return found["a"][0] if found else None

    return made


def test_few_levels_stand_for_themselves(curve):
    found = curve([2.0] * 8 + [4.0, 16.0])
    assert found.axis == "robots"
    assert [(point.label, point.cell.trials) for point in found.points] == [
        ("2", 8),
        ("4", 1),
        ("16", 1),
    ]


@pytest.mark.parametrize("highest", [29, 30, 33, 50, 115])
def test_whole_levels_are_binned_evenly_and_each_once(curve, highest):
    levels = [float(level) for level in range(15, highest + 1)]
    points = curve(levels).points
    assert len(points) == BINS
    assert sum(point.cell.trials for point in points) == len(levels)
    widths = [point.high - point.low for point in points]
    assert max(widths) - min(widths) <= 1
    assert (points[0].low, points[-1].high) == (15.0, highest)


def test_other_levels_are_binned_each_once(curve):
    levels = [0.1 + k / 37.0 for k in range(38)]
    points = curve(levels).points
    assert sum(point.cell.trials for point in points) == len(levels)
    assert len(points) == BINS


def test_nothing_to_draw_without_two_levels_in_feasible_worlds(curve):
    assert curve([3.0] * 20) is None
    assert curve([None] * 20) is None
    assert curve([3.0, 4.0] * 10, feasible=False) is None
    assert curve([3.0, 4.0] * 10, expected="infeasible") is None
    assert curve([3.0, 4.0]) is None  # too few to say anything


def test_every_line_of_a_crowded_chart_looks_different():
    looks = {(series_color(k), series_marker(k)) for k in range(24)}
    assert len(looks) == 24
