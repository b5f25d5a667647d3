import pytest

from cavalcade.campaign.report.worst import worst_trials


@pytest.fixture
def trial(make_line):
    def made(name, outcome="arrived", gap=0.1, ratio=2.0, **changes):
        success = outcome == "arrived"
        values = {
            "trial": name,
            "seed": int(name[1:] or 0),
            "summary": {"reason": outcome, "min_footprint_gap_m": gap},
            "measured": {"time_ratio": ratio if success else None},
        }
        return make_line(name, outcome=outcome, **(values | changes))

    return made


@pytest.fixture
def good(trial):
    return [trial(f"g{k}", gap=0.1 + k / 100, ratio=2.0 + k / 100) for k in range(32)]


@pytest.fixture
def names(open_table):
    return lambda lines: [trial.name for trial, _ in worst_trials(open_table(lines))]


def test_without_failures_the_closest_and_the_slowest(good, names):
    assert names(good) == ["g0", "g1", "g2", "g3", "g31", "g30", "g29", "g28"]


def test_failures_first_one_of_each_kind_and_two_places_for_the_others(trial, good, names):
    stuck = [trial(f"s{k}", "stuck") for k in range(9)]
    late = [trial(f"t{k}", "timeout") for k in range(9)]
    hit = [trial("c", "collision", gap=0.0, avoidable=1)]
    assert names(stuck + late + good + hit) == ["c", "s0", "t0", "s1", "t1", "s2", "g0", "g31"]


def test_what_failed_where_it_had_to_is_no_failure_unless_it_touched_something(trial, names):
    hopeless = trial("h", "infeasible", feasible=False)
    touched = trial("x", "collision", feasible=False, avoidable=1)
    assert names([hopeless, touched]) == ["x"]


def test_no_trial_stands_twice_and_none_is_needed(trial, good, names):
    assert names([]) == []
    assert names(good[:1]) == ["g0"]
    twice = [trial(f"g{k}", gap=0.1 + k / 100, ratio=2.0 - k / 100) for k in range(12)]
    assert names(twice) == ["g0", "g1", "g2"]


@pytest.mark.parametrize(
    ("count", "shown"), [(1, 1), (4, 1), (5, 2), (8, 2), (9, 3), (28, 7), (29, 8), (32, 8)]
)
def test_a_campaign_of_few_trials_repeated_them_all(good, names, count, shown):
    assert len(names(good[:count])) == shown


@pytest.mark.parametrize(
    ("count", "shown"),
    [(4, ["s0"]), (8, ["s0", "g0"]), (12, ["s0", "g0", "g9"]), (16, ["s0", "s1", "g0", "g13"])],
)
def test_of_few_the_first_failure_and_then_one_of_each_other_reason(
    trial, good, names, count, shown
):
    failed = [trial(f"s{k}", "stuck") for k in range(2)]
    assert names(failed + good[: count - 2]) == shown
