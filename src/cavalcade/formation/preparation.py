"""What takes longer than a cycle may, prepared beside the cycles: maps, and plans of goals.

A live planner notes what it is asked for, and a thread of its own works out what follows from it:
from copies, so that nothing which a cycle uses is touched. A cycle takes up what is ready.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

from cavalcade.formation.goals import GoalPlan
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.team import Team
from cavalcade.geometry import Array
from cavalcade.world import OccupancyMap


@dataclass(frozen=True)
class Ground:
    """What stands.

    Attributes:
        map: As known last.
        distance: `(rows, cols)` from each cell's centre to the nearest obstacle's surface, m.
    """

    map: OccupancyMap
    distance: Array


@dataclass(frozen=True)
class Request:
    """All that a preparation goes by; nothing of it changes any more.

    Attributes:
        number: Of the last change that it takes into account.
        ground: What stands.
        maps: Of that ground, where they are known: the planner's own, to be copied.
        team: Who is to take part, in which shape.
        goals: `(G, 3)` poses in the map's frame,
        waypoint: and which of them the plan is for: the present one,
        ahead: or the one after it.
        poses: `(N, 3)` of all robots, in the map's frame.
    """

    number: int
    ground: Ground
    maps: PlanningMaps | None
    team: Team
    goals: Array
    waypoint: int
    poses: Array
    ahead: bool = False


@dataclass(frozen=True)
class Prepared:
    """What came of a request.

    Attributes:
        request: What was asked for.
        maps: Of its ground.
        routes: The same with lost robots as obstacles,
        bodies: which stand at these poses `(K, 3)`, in the grid's frame.
        plan: For its goal; None if there is none, or nobody to drive there.
    """

    request: Request
    maps: PlanningMaps
    routes: PlanningMaps
    bodies: Array
    plan: GoalPlan | None


@dataclass(frozen=True)
class Change:
    """Something that a planner was asked for and that waits for its preparation.

    Attributes:
        number: 1, 2, ... in the order in which they were asked for.
        act: Lets it come into effect.
        goals: Whether it sets other goals.
    """

    number: int
    act: Callable[[], None]
    goals: bool


class Preparation:
    """Changes that wait, and one job at a time in a thread of its own.

    Attributes:
        number: Of the last change.
    """

    def __init__(self) -> None:
        # Its thread ends with the planner.
        self._thread = ThreadPoolExecutor(1, "cavalcade-preparation")
        self._job: Future[Prepared | None] | None = None
        self._waiting: list[Change] = []
        self.number = 0
        self._spent: list[object] = []

    @property
    def idle(self) -> bool:
        """Whether there is no job."""
        return self._job is None

    @property
    def cluttered(self) -> bool:
        """Whether there is something to free."""
        return bool(self._spent)

    @property
    def waiting(self) -> bool:
        """Whether changes wait."""
        return bool(self._waiting)

    @property
    def goals_waiting(self) -> bool:
        """Whether goals are among them."""
        return any(change.goals for change in self._waiting)

    def add(self, act: Callable[[], None], goals: bool = False) -> None:
        """Let a change wait; goals replace others that wait."""
        if goals:
            self.drop_goals()
        self.number += 1
        self._waiting.append(Change(self.number, act, goals))

    def drop_goals(self) -> None:
        """Goals that wait shall never come into effect."""
        self._waiting = [change for change in self._waiting if not change.goals]

    def due(self, number: int) -> list[Change]:
        """The changes up to a number, which wait no longer."""
        found = [change for change in self._waiting if change.number <= number]
        self._waiting = self._waiting[len(found) :]
        return found

    def start(self, work: Callable[[], Prepared | None]) -> None:
        """Begin a job; the last one is over."""
        spent, self._spent = self._spent, []

        def job() -> Prepared | None:
            spent.clear()
            return work()

        self._job = self._thread.submit(job)

    def take(self) -> Prepared | None:
        """What a job that is over came to, once; what went wrong in it is raised."""
        if self._job is None or not self._job.done():
            return None
        job, self._job = self._job, None
        return job.result()

    def discard(self, *parts: object) -> None:
        """Let the thread free large things: giving memory back takes its time, too."""
        self._spent += parts


def ahead(request: Request) -> Request:
    """The same for the next waypoint."""
    return replace(request, waypoint=request.waypoint + 1, ahead=True)
