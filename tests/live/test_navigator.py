"""The navigation of a team without any middleware, on robots that fail on purpose."""

from __future__ import annotations

import errno
import json
import os
import random
import re
import threading

import numpy as np
import pytest
from fake_fleet import FakeFleet, until

from cavalcade.errors import InputError
from cavalcade.fleet import Fault
from cavalcade.live.navigator import TeamNavigator
from cavalcade.live.team_file import parse_team
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.status import PlannerStatus
from cavalcade.world import Box, OccupancyMap

STARTS = ((1.5, 2.0, 0.0), (1.5, 3.0, 0.0), (1.5, 4.0, 0.0))
GOAL = (4.0, 3.0, 0.0)
CALLS = 300
"""Of each of the threads that call everything."""


def team_with(**more):
    names = ("anna", "bert", "cleo")
    return parse_team(
        {
            "version": 1,
            "robots": [{"name": name} for name in names],
            "formation": {"shape": "line", "spacing": 1.0},
            "supervision": {"deadline": 2.0},  # the machine may be busy with other things
        }
        | more
    )


class Straight:
    """Single robots go straight to their goals: a stand-in for planning them together."""

    def __init__(self, robots: int) -> None:
        self._goals = [None] * robots
        self._paused = False
        self.maps, self.closed = [], False
        self._poses = np.zeros((robots, 3))

    @property
    def status(self):
        away = [
            0.0 if goal is None else float(np.hypot(*(np.array(goal) - pose)[:2]))
            for goal, pose in zip(self._goals, self._poses, strict=True)
        ]
        return PlannerStatus(
            state="paused" if self._paused else "final",
            roles=np.full(len(self._goals), -1),
            goals=self._poses[:, :2].copy(),
            paths=tuple(np.zeros((0, 2)) for _ in self._goals),
            eta=np.zeros(len(self._goals)),
            arrived=max(away) < 0.1,
            targets=np.array([(np.inf,) * 3 if goal is None else goal for goal in self._goals]),
        )

    def step(self, poses, time, stamps):
        self._poses = poses.copy()
        commands = np.zeros_like(poses)
        for robot, goal in enumerate(self._goals):
            if goal is not None and not self._paused:
                x, y = np.clip(np.array(goal)[:2] - poses[robot, :2], -0.4, 0.4)
                c, s = np.cos(poses[robot, 2]), np.sin(poses[robot, 2])
                commands[robot, :2] = c * x + s * y, c * y - s * x
        return commands

    def set_goal(self, robot, pose):
        self._goals[robot] = pose

    def set_map(self, map):
        self.maps.append(map)

    def close(self):
        self.closed = True

    def pause(self):
        self._paused = True

    def resume(self):
        self._paused = False

    def lose(self, robot):
        return

    def rejoin(self, robot):
        return


@pytest.fixture
def ground():
    return OccupancyMap.empty((6.0, 6.0), 0.1)


@pytest.fixture
def live(ground):
    """A fleet and its navigator, which has begun."""
    fleet, frames = FakeFleet(STARTS), []
    navigator = TeamNavigator(
        team_with(),
        fleet,
        map=ground,
        individual=lambda *_: Straight(3),
        sinks=[frames.append],
    )
    with navigator:
        navigator.fleet, navigator.frames = fleet, frames
        yield navigator
    assert not fleet.sent[-1][1].any()


def moving(navigator):
    return navigator.fleet.sent[-1][1].any()


def test_team_arrives_at_a_goal_and_every_way_out_ends_with_zeros(live):
    assert live.status.state == "idle"
    live.set_formation_goals([GOAL])
    until(lambda: live.status.arrived)
    assert np.hypot(*(live.fleet.true_poses()[:, :2].mean(axis=0) - GOAL[:2])) < 0.1
    live.close()
    live.close()
    assert not live.fleet.sent[-1][1].any()
    assert live.status.state == "inactive"
    assert live.frames[0].maps
    assert any("new goal" in note for frame in live.frames for note in frame.notes)


def test_status_is_json_without_nan(live):
    live.set_formation_goals([GOAL])
    live.fleet.garbled.add(1)
    until(lambda: live.status.state == "stopped")
    text = json.dumps(live.status.to_dict(), allow_nan=False)
    assert json.loads(text)["robots"]["bert"]["pose"] is None
    assert live.status.cause == ("nan: bert",)
    assert "call resume" in live.status.message


@pytest.mark.parametrize("what", ["garbled", "silent", "fault", "stop"])
def test_fault_stops_all_until_resume(live, what):
    live.set_formation_goals([GOAL])
    until(lambda: moving(live))
    if what == "garbled":
        live.fleet.garbled.add(0)
    elif what == "silent":
        live.fleet.silent[0] = live.fleet.time
    elif what == "fault":
        live.fleet.faults = (Fault(0, "frame", "poses are in odom"),)
    else:
        live.stop("by hand")
    until(lambda: live.status.state == "stopped" and not moving(live))
    live.resume()  # it is not over yet: the request is dropped
    frames = len(live.frames)
    until(lambda: len(live.frames) > frames + 3)
    assert not live.status.ok
    live.fleet.garbled.clear()
    live.fleet.silent.clear()
    live.fleet.faults = ()
    live.reset_stop()
    count = len(live.fleet.sent)
    until(lambda: len(live.fleet.sent) > count + 10)
    assert not any(command.any() for _, command in live.fleet.sent[count:])
    live.resume()
    until(lambda: moving(live))
    until(lambda: live.status.arrived)


def test_pause_brakes_and_holds_through_a_fault(live):
    live.set_formation_goals([GOAL])
    until(lambda: moving(live))
    live.pause()
    until(lambda: live.status.state == "paused" and not moving(live))
    live.fleet.garbled.add(0)
    until(lambda: live.status.state == "stopped")
    live.fleet.garbled.clear()
    live.resume()
    live.pause()
    until(lambda: live.status.state == "paused")
    count = len(live.fleet.sent)
    until(lambda: len(live.fleet.sent) > count + 10)
    assert not any(command.any() for _, command in live.fleet.sent[count:])
    live.resume()
    until(lambda: live.status.arrived)


def test_goals_of_single_robots_and_of_the_formation_take_turns(live):
    live.set_robot_goal("anna", (2.5, 1.5, 0.0))
    until(lambda: live.status.mode == "individual" and live.status.arrived)
    assert np.hypot(*(live.fleet.true_poses()[0, :2] - (2.5, 1.5))) < 0.16
    assert np.allclose(live.fleet.true_poses()[1:], STARTS[1:], atol=0.05)
    live.set_formation_goals([GOAL])
    until(lambda: live.status.mode == "formation" and live.status.arrived)
    live.cancel()
    until(lambda: live.status.state == "idle")


def test_map_changes_while_robots_move(live, ground):
    live.set_formation_goals([GOAL])
    until(lambda: moving(live))
    other = OccupancyMap.empty((6.0, 6.0), 0.05).with_shapes([Box((3.0, 3.0), (0.3, 0.3))])
    live.set_map(other)
    until(lambda: any(other in frame.maps for frame in live.frames))
    until(lambda: live.status.arrived)
    live.set_map(OccupancyMap(other.grid, 0.05))  # the same again
    assert live.map is other


def test_bad_input_is_refused_at_once(live):
    for goal in ([[np.nan, 0.0, 0.0]], [[1.0, 2.0]], [], "here"):
        with pytest.raises(InputError):
            live.set_formation_goals(goal)
    with pytest.raises(InputError, match="no robot dora"):
        live.set_robot_goal("dora", GOAL)
    with pytest.raises(InputError, match="did you mean square"):
        live.set_formation({"shape": "sqare"})
    with pytest.raises(InputError, match="4 slots"):
        live.set_formation({"shape": "square"})
    with pytest.raises(InputError, match="mapping"):
        live.set_formation("line")
    live.refuse("goal_pose: in frame odom")
    assert live.status.refused == "goal_pose: in frame odom"
    live.set_formation({"shape": "column", "spacing": 0.9})
    assert not live.status.refused
    assert live.status.state == "idle"


def test_robot_that_does_not_follow_is_left_behind(live):
    live.fleet.deaf.add(0)
    live.set_formation_goals([GOAL])
    until(lambda: live.status.robots[0].lost)
    until(lambda: live.status.arrived)
    assert any("anna does not follow" in note for frame in live.frames for note in frame.notes)


def test_fleet_that_raises_stops_the_team_and_is_told(live):
    live.set_formation_goals([GOAL])
    until(lambda: moving(live))
    live.fleet.break_observe = RuntimeError("the radio is gone")
    until(lambda: live.status.state == "stopped" and not moving(live))
    assert "the radio is gone" in live.status.message
    live.fleet.break_observe = None
    live.resume()
    until(lambda: live.status.arrived)


def test_sink_that_raises_is_left_out(ground):
    def full(frame):
        raise OSError("disk full")

    fleet = FakeFleet(STARTS)
    with TeamNavigator(team_with(), fleet, map=ground, sinks=[full]) as navigator:
        until(lambda: "disk full" in navigator.status.recording)
        assert navigator.status.recording in navigator.status.message
        navigator.set_formation_goals([GOAL])
        until(lambda: navigator.status.arrived)


def test_a_disk_that_is_full_is_told_while_the_team_drives(ground, tmp_path):
    fleet = FakeFleet(STARTS)
    models = team_with().models
    with (
        LiveRecording(tmp_path / "recording.mcap", models) as recording,
        TeamNavigator(team_with(), fleet, map=ground, sinks=[recording]) as navigator,
    ):
        navigator.set_formation_goals([GOAL])
        assert navigator.status.recording == ""
        before = navigator.status.turning_point
        recording._file.flush = full_disk
        until(lambda: navigator.status.recording)
        status = navigator.status
        assert "No space left" in status.recording == status.to_dict()["recording"]
        assert status.ok
        assert before != status.turning_point
        del recording._file.flush
        until(lambda: not navigator.status.recording)
        until(lambda: navigator.status.arrived)
        assert navigator.status.message == ""


def full_disk():
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_fault_that_goes_on_is_news_once_and_a_line_of_its_robot(live):
    live.set_formation_goals([GOAL])
    until(lambda: moving(live))
    live.fleet.silent[0] = live.fleet.time
    until(lambda: live.status.state == "stopped")
    first = live.status
    frames = len(live.frames)
    until(lambda: len(live.frames) > frames + 3)
    later = live.status
    assert later.turning_point == first.turning_point
    (cause,), (line,) = later.cause, later.robots[0].faults
    assert re.fullmatch(r"stale: anna \(0\.\d\d s old\)", cause)
    assert re.fullmatch(r"stale \(\d+\.\d\d s old\)", line)
    assert line != first.robots[0].faults[0]
    assert not later.robots[1].faults


def test_dry_run_commands_nobody(ground):
    fleet = FakeFleet(STARTS)
    with TeamNavigator(team_with(), fleet, map=ground, dry_run=True) as navigator:
        navigator.set_formation_goals([GOAL])
        until(lambda: len(fleet.sent) > 40)
        assert navigator.status.dry_run
    assert not any(command.any() for _, command in fleet.sent)


def test_team_without_formation_drives_single_robots_together(ground):
    """The real planner: two robots change places."""
    fleet = FakeFleet(STARTS)
    with TeamNavigator(team_with(formation=None), fleet, map=ground) as navigator:
        with pytest.raises(InputError, match="no formation"):
            navigator.set_formation_goals([GOAL])
        assert navigator.status.mode == "individual"
        navigator.set_robot_goal("anna", STARTS[1])
        navigator.set_robot_goal("bert", STARTS[0])
        until(lambda: navigator.status.arrived, 60.0)
        there = fleet.true_poses()
    for robot, goal in ((0, STARTS[1]), (1, STARTS[0]), (2, STARTS[2])):
        assert np.hypot(*(there[robot] - goal)[:2]) < 0.16


class Sinking(FakeFleet):
    """Robots that sink to the ground when they are damped, and stand up when they may begin."""

    def __init__(self, starts) -> None:
        super().__init__(starts)
        self.down, self.risen, self.begin = False, 0, threading.Event()

    def start(self, timeout: float) -> None:
        assert self.begin.wait(30.0)
        self.down = False
        self.risen += 1

    def damp(self, robot=None) -> None:
        self.down = True


def test_an_e_stop_that_is_pressed_before_robots_stand_up_keeps_them_down(ground):
    fleet = Sinking(STARTS)
    one = TeamNavigator(team_with(), fleet, map=ground, individual=lambda *_: Straight(3))
    with one as live:
        live.stop()
        assert fleet.down
        live.reset_stop()  # that they stand up is waiting now
        live.stop()
        fleet.begin.set()
        until(lambda: fleet.risen == 1)
        until(lambda: fleet.down)
        assert not live.status.ok
        live.reset_stop()
        until(lambda: fleet.risen == 2)
        since = live.frame.time
        until(lambda: live.frame.time > since + 0.2)
        assert not fleet.down


def test_fleet_of_another_size_is_refused(ground):
    with pytest.raises(InputError, match="fleet of 2"):
        TeamNavigator(team_with(), FakeFleet(STARTS[:2]), map=ground)


def test_ten_threads_may_call_anything_at_any_time(live, ground):
    """No call raises, and each status is of one moment."""
    box = ground.with_shapes([Box((3.0, 1.0), (0.3, 0.3))])
    calls = (
        lambda: live.set_formation_goals([GOAL]),
        lambda: live.set_formation_goals([(2.0, 3.0, 0.0), GOAL]),
        lambda: live.set_robot_goal("bert", (2.0, 3.0, 0.0)),
        lambda: live.set_robot_goal("cleo", (2.5, 4.5, 1.0)),
        lambda: live.set_map(box),
        lambda: live.set_map(ground),
        live.pause,
        live.resume,
        live.resume,
        live.cancel,
        live.stop,
        live.reset_stop,
        lambda: live.lose("anna"),
        lambda: live.rejoin("anna"),
        lambda: live.set_formation({"shape": "line", "spacing": 0.9}),
        lambda: live.set_formation({"shape": "line"}),
        lambda: live.refuse("a word"),
        lambda: live.map.grid.sum(),
        lambda: live.frame.commands.sum(),
    )
    wrong, seen = [], set()

    def look():
        status = live.status
        seen.add(status.state)
        json.dumps(status.to_dict(), allow_nan=False)
        assert (status.state == "stopped") == bool(status.cause) == (not status.ok)
        if not status.ok:
            assert not any(any(robot.command) for robot in status.robots)
            assert status.message.startswith("stopped: ")
        # Goals are of the formation or of single robots, and `idle` is who has none.
        own = [robot.goal for robot in status.robots if robot.goal is not None]
        assert not (status.goals and own)
        assert not (status.state == "idle" and (status.goals or own))

    def work(seed):
        pick = random.Random(seed)
        try:
            for _ in range(CALLS):
                pick.choice(calls)()
                look()
        except BaseException as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong, wrong[0]
    assert {"stopped", "idle"} < seen
    live.rejoin("anna")
    live.reset_stop()
    live.set_formation({"shape": "line"})
    live.set_formation_goals([GOAL])

    def arrived():
        if not live.status.ok or live.status.state == "paused":
            live.resume()
        return live.status.arrived

    until(arrived)
