"""What a reader has to know to use the figures of a report."""

from __future__ import annotations

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
