"""A planner that many threads call at once, while one of them steps it."""

from __future__ import annotations

import random
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cavalcade.fleet.ideal import IdealFleet
from cavalcade.formation import DynamicObstacle, Formation, FormationPlanner
from cavalcade.robots import robot_model
from cavalcade.world import Box, Circle, OccupancyMap

ROOM = OccupancyMap.empty((9.0, 6.0), 0.1)
MAPS = [
    ROOM,
    ROOM.with_shapes([Box((5.0, 1.0), (0.4, 1.0))]),
    OccupancyMap.empty((10.0, 7.0), 0.1).with_shapes([Circle((6.0, 4.0), 0.3)]),
]
SHAPES = [Formation.square(1.0), Formation.line(4, 0.9), Formation.column(4, 0.8)]
THREADS, CALLS = 10, 40


def calls_of(planner: FormationPlanner, rng: random.Random) -> list:
    goal = (rng.uniform(1.5, 7.5), rng.uniform(1.5, 4.5), rng.uniform(-3.0, 3.0))
    crate = DynamicObstacle(Circle((rng.uniform(1.0, 8.0), 5.5), 0.2), (0.3, 0.0))
    robot = rng.randrange(4)
    return [
        lambda: planner.set_goal(goal),
        lambda: planner.set_goals([goal, (4.5, 3.0, 0.0)]),
        planner.cancel,
        planner.pause,
        planner.resume,
        lambda: planner.set_formation(rng.choice(SHAPES)),
        lambda: planner.lose(robot),
        lambda: planner.rejoin(robot),
        lambda: planner.update_map(rng.choice(MAPS)),
        lambda: planner.set_dynamic_obstacles(rng.choice([[], [crate]])),
        lambda: untorn(planner.status),
    ]


def known_slots() -> set[bytes]:
    """The slots of all shapes that a team may be in, whoever is lost."""
    smaller = [shape.smaller(count) for shape in SHAPES for count in (1, 2, 3)]
    return {np.array(shape.slots).tobytes() for shape in (*SHAPES, *smaller)}


KNOWN = known_slots()


def untorn(status) -> None:
    """All parts of a status are of one team, in one of the shapes that were asked for."""
    assert status.slots.tobytes() in KNOWN
    assert len(status.paths) == len(status.roles) == len(status.goals) == len(status.eta) == 4
    taken = status.roles[status.roles >= 0]
    assert len(set(taken.tolist())) == len(taken)
    assert (taken < len(status.slots)).all()
    assert ((status.connections >= 0) & (status.connections < 4)).all()
    assert (status.roles[status.connections] >= 0).all()
    assert np.isfinite(status.goals).all()
    if status.state == "partial" and status.leader >= 0 and len(taken):
        assert status.roles[status.leader] == 0


@pytest.mark.parametrize("live", [False, True])
@pytest.mark.parametrize("seed", [0, 1])
def test_ten_threads_call_everything_while_one_steps(live, seed):
    """107 of 1,500 calls from a second thread raised."""
    planner = FormationPlanner(ROOM, SHAPES[0], live=live, seed=seed)
    planner.set_goal((7.0, 3.0, 0.0))
    poses = np.column_stack([SHAPES[0].placed((2.0, 3.0, 0.0)), np.zeros(4)])
    fleet = IdealFleet([robot_model("go1")] * 4, poses)
    over = threading.Event()

    def call(number: int) -> None:
        rng = random.Random(100 * seed + number)
        for _ in range(CALLS):
            rng.choice(calls_of(planner, rng))()

    def step() -> int:
        cycles = 0
        while not over.is_set():
            commands = planner.step(fleet.observe().poses, fleet.time)
            assert np.isfinite(commands).all()
            untorn(planner.status)
            fleet.send(commands)
            fleet.advance(0.05)
            cycles += 1
        return cycles

    with ThreadPoolExecutor(THREADS + 1) as threads:
        stepping = threads.submit(step)
        for done in [threads.submit(call, number) for number in range(THREADS)]:
            done.result()
        over.set()
        assert stepping.result() > 0
    for robot in range(4):
        planner.rejoin(robot)
    planner.update_map(ROOM)
    planner.set_dynamic_obstacles([])
    planner.set_formation(SHAPES[0])
    planner.resume()
    planner.set_goal((4.5, 3.0, 0.0))
    assert arrives(planner, fleet)


def arrives(planner: FormationPlanner, fleet: IdealFleet) -> bool:
    for _ in range(6000):
        fleet.send(planner.step(fleet.observe().poses, fleet.time))
        fleet.advance(0.05)
        if planner.status.arrived:
            return True
    return False


def test_two_threads_may_step():
    planner = FormationPlanner(ROOM, SHAPES[0])
    planner.set_goal((7.0, 3.0, 0.0))
    poses = np.column_stack([SHAPES[0].placed((2.0, 3.0, 0.0)), np.zeros(4)])

    def step(_: int) -> bool:
        return bool(np.isfinite(planner.step(poses, 0.0)).all())

    with ThreadPoolExecutor(2) as threads:
        assert all(threads.map(step, range(40)))


def test_a_status_does_not_change_with_later_cycles():
    planner = FormationPlanner(ROOM, SHAPES[0])
    planner.set_goal((7.0, 3.0, 0.0))
    poses = np.column_stack([SHAPES[0].placed((2.0, 3.0, 0.0)), np.zeros(4)])
    planner.step(poses, 0.0)
    status = planner.status
    before = (status.goals.copy(), status.roles.copy(), status.eta.copy(), status.goal.copy())
    paths = [path.copy() for path in status.paths]
    for cycle in range(1, 20):
        planner.step(poses + (0.02 * cycle, 0.0, 0.0), 0.05 * cycle)
    planner.set_formation(SHAPES[1])
    planner.set_goal((2.0, 2.0, 1.0))
    planner.step(poses, 1.0)
    for kept, now in zip(
        before, (status.goals, status.roles, status.eta, status.goal), strict=True
    ):
        np.testing.assert_array_equal(kept, now)
    for kept, now in zip(paths, status.paths, strict=True):
        np.testing.assert_array_equal(kept, now)
