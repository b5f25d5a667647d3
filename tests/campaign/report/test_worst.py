from cavalcade.campaign.report.trials import Order, Trial
from cavalcade.campaign.report.worst import worst_trials


def trial(name, outcome="arrived", gap=0.1, ratio=2.0, **changes):
    success = outcome == "arrived"
    summary = {"min_footprint_gap_m": gap}
    values = {"success": success, "summary": summary, "time_ratio": ratio if success else None}
    return Trial(
        name=name, scenario="a", variant="cavalcade", outcome=outcome, **(values | changes)
    )


def names(trials, **options):
    return [w.trial.name for w in worst_trials(trials, Order.of(object(), trials), **options)]


GOOD = [trial(f"g{k}", gap=0.1 + k / 100, ratio=2.0 + k / 100) for k in range(20)]


def test_without_failures_the_closest_and_the_slowest():
    assert names(GOOD) == ["g0", "g1", "g2", "g3", "g19", "g18", "g17", "g16"]


def test_failures_first_one_of_each_kind_and_two_places_for_the_others():
    stuck = [trial(f"s{k}", "stuck") for k in range(9)]
    late = [trial(f"t{k}", "timeout") for k in range(9)]
    hit = [trial("c", "collision", gap=0.0, avoidable=1)]
    assert names(stuck + late + GOOD + hit) == ["c", "s0", "t0", "s1", "t1", "s2", "g0", "g19"]


def test_what_failed_where_it_had_to_is_no_failure_unless_it_touched_something():
    hopeless = trial("h", "infeasible", feasible=False)
    touched = trial("x", "collision", feasible=False, avoidable=1)
    assert names([hopeless, touched]) == ["x"]


def test_no_trial_stands_twice_and_none_is_needed():
    assert names([]) == []
    assert names(GOOD[:1]) == ["g0"]
    assert sorted(names(GOOD[:3])) == ["g0", "g1", "g2"]
