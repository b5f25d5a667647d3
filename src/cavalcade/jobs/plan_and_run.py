"""Runs of robots with goals of their own: plan, then carry the plan out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.coordination.result import TeamPlan
from cavalcade.drawing.physics.drawing import add_figures, replay_in_physics
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.progress import ProgressSink
from cavalcade.execution.simulation import Simulated, simulate
from cavalcade.execution.time_scaling import EXACT, WALKING
from cavalcade.execution.tracking_fleet import tracking_fleet
from cavalcade.fleet import Fleet, IdealFleet, LeapingFleet
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.jobs.output_folder import FIGURES, PLAN, RECORDING, REPLAY, OutputFolder
from cavalcade.jobs.plan_reporter import PlanReporter
from cavalcade.jobs.planning import make_plan
from cavalcade.jobs.reporter import Reporter
from cavalcade.jobs.running import RunResult
from cavalcade.metrics.plan_result import PlanResult
from cavalcade.metrics.summary import rounded, summarise
from cavalcade.recording.frames import Recording
from cavalcade.recording.plan_file import write_plan
from cavalcade.scenario import Scenario, World
from cavalcade.scenario.settings import Budget


def carry_out(
    scenario: Scenario,
    world: World,
    folder: OutputFolder | None,
    reporter: Reporter,
    sink: ProgressSink | None,
    *,
    realtime: bool = False,
    figures: bool = True,
    replay: bool = True,
    quiet: bool = True,
    fleet: Callable[[Scenario], Fleet] | None = None,
) -> RunResult:
    """Plan for a resolved scenario and let its robots follow the plan.

    Without a plan nobody moves, and the run ends at once with the planner's reason. Arguments as
    of `cavalcade.jobs.running.run`.
    """
    made = make_plan(scenario, world, reporter=PlanReporter(scenario, quiet))
    done, follower = _simulated(scenario, world, made, sink, realtime, fleet)
    summary = _summary(scenario, world, made, done, follower)
    files: tuple[Path, ...] = ()
    if folder is not None:
        from cavalcade.recording.mcap_writer import write_recording

        stage = folder.stage
        write_recording(stage / RECORDING, done.recording, scenario.models, done.maps)
        write_plan(stage / PLAN, made.trajectories, made.footholds)
        shown = replace(made, summary=summary)
        if made.solved:
            shown = replace(shown, plan=_as_driven(made, done.recording, follower))
        if figures:
            from cavalcade.drawing.plans import make_plan_figures

            reporter.say("Drawing the figures ...")
            make_plan_figures(scenario, world, shown, stage / FIGURES)
            add_figures(scenario, done.recording, stage / FIGURES)
        if replay and not replay_in_physics(
            scenario, world, done.recording, summary, stage / REPLAY
        ):
            from cavalcade.drawing.replay.plan import write_plan_replay

            write_plan_replay(scenario, world, shown, stage / REPLAY)
        files = folder.commit(scenario, summary)
    reporter.finish(summary, files)
    return RunResult(summary, done.recording, None if folder is None else folder.path, files)


def _simulated(
    scenario: Scenario,
    world: World,
    made: PlanResult,
    sink: ProgressSink | None,
    realtime: bool,
    fleet: Callable[[Scenario], Fleet] | None,
) -> tuple[Simulated, PlanFollower]:
    refusal = None if made.solved else made.summary["detail"] or made.reason
    robots = tracking_fleet(scenario, made.trajectories) if fleet is None else fleet(scenario)
    follower = PlanFollower(
        made.trajectories,
        scenario.models,
        scenario.starts,
        scenario.goals,
        scenario.execution.rate,
        refusal,
        EXACT if isinstance(robots, IdealFleet) else WALKING,
        robots if isinstance(robots, LeapingFleet) else None,
        world.terrain,
    )
    # The budget was the search's.
    free = scenario.planner.model_copy(update={"budget": Budget()})
    unbounded = scenario.model_copy(update={"planner": free})
    done = simulate(unbounded, world, follower, robots, realtime=realtime, progress=sink)
    if made.solved:
        return done, follower
    outcome = replace(
        done.outcome,
        reason=made.reason,
        detail=made.summary["detail"] or "",
        involved=made.plan.involved,
    )
    return replace(done, outcome=outcome), follower


def _summary(
    scenario: Scenario, world: World, made: PlanResult, done: Simulated, follower: PlanFollower
) -> dict[str, Any]:
    """Of the run; planning is that of the plan, and what formations alone have is null.

    Beyond a formation's keys there is `delay_s`: how much later than planned each robot was sent
    to the end of its way, null for one that never was; and the plan's `margin_m`.
    """
    summary = summarise(scenario, world, done.recording, done.outcome)
    planned = made.summary
    return summary | {
        "wall_time_s": round(summary["wall_time_s"] + planned["wall_time_s"], 6),
        "leader_changes": None,
        "role_changes": None,
        "planning_time_s": planned["planning_time_s"],
        "lower_bound_m": planned["lower_bound_m"],
        "goal_moved_m": planned["goal_moved_m"],
        "margin_m": planned["margin_m"],
        "delay_s": [rounded(delay) for delay in follower.delays],
    }


def _as_driven(made: PlanResult, recording: Recording, follower: PlanFollower) -> TeamPlan:
    """The plan with the poses that were driven, at the heights and phases of the robots' progress.

    A robot's ends with the cycle in which its plan ends, or with the run.
    """
    driven: list[Trajectory | None] = []
    delays = follower.delays_at(recording.time)
    for robot, path in enumerate(made.trajectories):
        if path is None:
            driven.append(None)
            continue
        progress = recording.time - delays[:, robot]
        cycles = 1 + int(np.searchsorted(progress, path.duration - 1e-9))
        time, progress = recording.time[:cycles], progress[:cycles]
        poses = recording.poses[:cycles, robot]
        height = np.interp(progress, path.time, path.position[:, 2])
        position = np.column_stack([poses[:, :2], height])
        before = np.clip(np.searchsorted(path.time, progress + 1e-9) - 1, 0, len(path.time) - 1)
        velocity = np.gradient(position, time, axis=0) if len(time) > 1 else np.zeros((1, 3))
        driven.append(
            Trajectory(time, position, velocity, np.unwrap(poses[:, 2]), path.phase[before])
        )
    return replace(made.plan, trajectories=tuple(driven))
