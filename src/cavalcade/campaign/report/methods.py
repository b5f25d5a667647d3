"""What a reader has to know to use the figures of a report."""

from __future__ import annotations

from collections.abc import Sequence

from cavalcade.campaign.report.trials import Order, Trial

_SHARES = (
    "**Intervals of shares** are Wilson's score intervals with 95 % confidence. **Upper bounds** "
    "of collisions are one-sided Clopper–Pearson bounds over the trials that ran; without a "
    "collision in n trials they are about 3/n (the rule of three).",
    "**Comparisons** are paired: the same worlds, seeds and settings; of means and medians there "
    "is none with fewer than 6 pairs. Differences of shares have "
    "Newcombe's paired interval (1998, method 10) and McNemar's exact p; means have Student's t "
    "interval, medians the sign test's. Where the interval of the difference of shares or means "
    "includes zero, the words are “no difference shown”: that is no proof of equality, the "
    "interval says how large a difference may still be.",
    "Each interval stands for itself: there is no correction for the number of comparisons, so "
    "about one in twenty excludes the truth by chance.",
)
"""What holds of every campaign."""

NOTES = (
    "A world is **feasible** if a disc gets from each robot's start to its place at the goal. The "
    "planner has no part in this test. It is necessary, not sufficient: a team may still not fit.",
    "A trial is a **success** if the team arrived and the independent checker found neither an "
    "avoidable collision nor any other violation.",
    "Every collision counts as **avoidable** but, where things happen on the way, three kinds: a "
    "robot that is lost was hit by what moved or appeared after its loss; an obstacle appeared in "
    "a robot, or in its way nearer than it could brake, and was touched while it would have "
    "braked; an obstacle moved, and from 3 s before the contact the robot could neither have "
    "stood still nor gone aside in any of 16 directions. "
    "Contact with what stands, with the map or with another robot is none of these.",
    *_SHARES,
    "**Time** is when the last robot was at its place for good, of successful trials. Its **lower "
    "bound** is the longest of the robots' shortest ways, each alone, at top speed, on the ground "
    "as it was at the start and to the last goal by way of those only that were reached before: "
    "where the goal changes on the way it may be far too low. **Formation error** is the mean "
    "distance of the robots to their slots of the best-fitting placed shape over one trial, of "
    "successful trials. Comparing these between settings that succeed in different worlds favours "
    "the one that fails in the hard ones; the paired tables do not.",
    "**Clearances** are the smallest of each trial that ran, true poses against exact shapes. "
    "**Cycle times** are medians over trials of each trial's p50 and p99, and the slowest of all; "
    "they depend on the machine and on what else it did.",
)
"""One paragraph each."""

DISTURBED = (
    "**Disturbances** are known to the planner: noise, delay and loss are what it is told to "
    "expect, unless `planner.expect` says otherwise."
)
"""The same, of campaigns with disturbances."""

PLAN_NOTES = (
    "A problem is **feasible** if a disc of half its body's width gets each robot from its start "
    "to its goal past what is solid; generated terrain can be crossed by its construction. The "
    "planner has no part in this. Worlds in the table of problems without a plan are infeasible by "
    "construction: there, refusing is the success, and they count nowhere else.",
    "A trial is a **success** if the method said that it had solved the problem and the "
    "independent checker found nothing: no contact of swept bodies, also after parking, no broken "
    "limit, start and goal met.",
    "**Length** is the sum over the robots of the way of the body's centre, in space, of "
    "successful trials; its **lower bound** the sum of the shortest ways of discs of half "
    "the body's width, each alone. **Makespan** is when the last robot is at its goal for good; it "
    "is compared with that of the slowest robot planned alone with the same options, where there "
    "are several. "
    "Comparing these between methods that succeed in different worlds favours the one that fails "
    "in the hard ones; the paired tables do not.",
    "**Planning time** is wall time of one thread, of all trials that ran, without reading the "
    "scenario, footholds and files; it depends on the machine and on what else it did. **Over "
    "single plans**: the same over the time to plan each robot alone.",
)
"""The same, of plans for goals of single robots."""

COMMAND_NOTES = (
    "Robots under commands have no planner. A trial is a **success** if the task's time passed, "
    "every robot has been where it was sent, and the independent checker found nothing.",
    "**Errors of mean speed and yaw rate** are those of the means in the direction of the command "
    "from 2 s after it was given until the next one, where that is 1 s at least; the largest of "
    "all robots and trials. **Spread**: root mean square of that speed less the command over the "
    "same time, with the sway of each step.",
)
"""The same, of robots under commands."""

PHYSICS_NOTES = (
    "**In physics** collisions are of bodies, footprints may overlap; contacts, falls, torques "
    "and forces are judged from the recorded bodies and joints by the checker's own account of "
    "them. **Bound**: 95 % upper bound of the share of trials with a fall. **Tilt** is the largest "
    "angle of a trunk from upright; **torque** is in shares of the joint's limit. Of gaps and "
    "steps **strictly** is the share of the robots that came across whose feet, trunk and pitch "
    "kept to the criterion of leaps (`cavalcade.checking.physics.judge_leap`). Simulated over wall "
    "time depends on the machine and on what else it did.",
)
"""The same, of robots in physics."""

PAPER_NOTE = (
    "The paper's: Table I of its section IV, two Spirit robots on flat ground with random goals; "
    "its machine, its goals and what it counts as a success are not ours."
)


def notes_of(trials: Sequence[Trial], order: Order) -> tuple[str, ...]:
    """What there is to know of these trials."""
    planned = [trial.planned for trial in trials]
    commanded = [trial.commanded for trial in trials]
    notes: tuple[str, ...] = ()
    driven = not all(one or other for one, other in zip(planned, commanded, strict=True))
    if driven or not trials:
        notes += NOTES
    if any(planned):
        notes += PLAN_NOTES
    if any(commanded):
        notes += COMMAND_NOTES
    if trials and not driven:
        notes += _SHARES
    if any(trial.in_physics for trial in trials):
        notes += PHYSICS_NOTES
    return (*notes, DISTURBED) if len(order.disturbances) > 1 else notes
