"""Trials of robots with goals of their own: planned, and judged by the independent checker."""

from __future__ import annotations

from dataclasses import replace

from cavalcade.campaign.samplers.sampler import EXPECTED, SOLVED
from cavalcade.campaign.verdict import Verdict, contacts_of, verdict_of
from cavalcade.checking import judge_plan
from cavalcade.coordination import TeamProblem, plan_team, problem_of
from cavalcade.jobs import JobResult
from cavalcade.jobs.planning import settings_of
from cavalcade.recording.plan_file import plan_arrays
from cavalcade.scenario import Scenario, World

_ALONE = "cbs"
"""Of a single robot: the course that all methods but the joint one begin with."""


def judged_plan(result: JobResult, expected: str = SOLVED) -> Verdict:
    """The verdict on a plan; nothing is written or read back.

    Args:
        result: What planning came to.
        expected: As in `Instance`: where there is no plan, refusing is the success.
    """
    # Also of a plan whose own summary finds contact, all that the coordinator claims is judged.
    claimed = {**result.summary, "success": result.plan is not None and result.plan.solved}
    arrays = plan_arrays(result.trajectories, result.footholds)
    report = judge_plan(result.scenario, arrays, claimed)
    solved = result.solved and not report.violations
    detail, avoidable = result.summary.detail or "", len(contacts_of(report))
    found = verdict_of(report, result.reason, detail, success=solved, avoidable=avoidable)
    if expected == SOLVED:
        return found
    return replace(found, success=found.outcome in EXPECTED[expected])


def measured_plan(result: JobResult) -> dict[str, float | None]:
    """Figures beside those of the summary; null where there is no plan, or only one robot.

    `length_ratio`: the summed lengths over the summed lower bounds; `makespan_ratio`: the
    makespan over that of the slowest robot planned alone with the same options;
    `single_time_ratio`: the planning time over that of all these single plans.
    """
    summary = result.summary
    found: dict[str, float | None] = {
        "time_ratio": None,
        "length_ratio": None,
        "makespan_ratio": None,
        "single_time_ratio": None,
    }
    if not result.solved:
        return found
    lengths, bounds = summary["path_length_m"], summary["lower_bound_m"]
    if None not in bounds and sum(bounds) > 0.0:
        found["length_ratio"] = round(sum(lengths) / sum(bounds), 6)
    if len(result.scenario.robots) < 2:
        return found
    durations, seconds = _alone(result.scenario, result.world)
    slowest = max((time for time in durations if time is not None), default=0.0)
    if None not in durations and slowest > 0.0:
        found["makespan_ratio"] = round(summary["makespan_s"] / slowest, 6)
    if seconds > 0.0:
        found["single_time_ratio"] = round(summary["planning_time_s"] / seconds, 6)
    return found


def _alone(scenario: Scenario, world: World) -> tuple[list[float | None], float]:
    """Durations of the robots' plans if each were alone, s, and the time to plan them all, s."""
    problem, settings = problem_of(scenario, world), settings_of(scenario)
    durations: list[float | None] = []
    seconds = 0.0
    for k in range(len(problem.models)):
        single: TeamProblem = replace(
            problem,
            models=problem.models[k : k + 1],
            starts=problem.starts[k : k + 1],
            goals=problem.goals[k : k + 1],
        )
        found = plan_team(single, _ALONE, settings, scenario.seed)
        seconds += found.planning_time
        path = found.trajectories[0]
        durations.append(path.duration if found.solved and path is not None else None)
    return durations, seconds
