"""The action of nav2_msgs, which has no wheel: the server's part is played here."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from cavalcade.errors import InputError
from cavalcade.fleet.ros2 import load_rclpy
from cavalcade.live import ros2_action
from cavalcade.live.status import TeamStatus

try:
    load_rclpy()
except InputError as error:
    pytest.skip(str(error), allow_module_level=True)

GOAL = (1.0, 2.0, 0.0)


class Handle:
    """A goal as an action server hands it on."""

    def __init__(self) -> None:
        self.request = SimpleNamespace(poses=[SimpleNamespace(header="map")])
        self.is_cancel_requested = False
        self.ended, self.told = [], []

    def succeed(self):
        self.ended.append("succeeded")

    def abort(self):
        self.ended.append("aborted")

    def canceled(self):
        self.ended.append("canceled")

    def publish_feedback(self, feedback):
        self.told.append(feedback.number_of_poses_remaining)


class Navigator:
    def __init__(self) -> None:
        self.goals, self.cancelled = (), False

    def set_formation_goals(self, goals):
        self.goals = tuple(goals)

    def cancel(self):
        self.cancelled = True

    @property
    def status(self):
        return status("partial", self.goals)


def status(state, goals=(GOAL,)):
    return TeamStatus(state, "formation", 0.0, (), goals=tuple(goals))


@pytest.fixture
def action(monkeypatch):
    import rclpy.action

    kind = SimpleNamespace(
        Result=SimpleNamespace, Feedback=lambda: SimpleNamespace(number_of_poses_remaining=0)
    )
    monkeypatch.setattr(ros2_action, "message_type", lambda name: kind)
    monkeypatch.setattr(rclpy.action, "ActionServer", lambda *_, **__: None)
    navigator, refused = Navigator(), []

    def goals_of(header, poses):
        if header != "map":
            raise InputError("in frame 'odom'; expected 'map'")
        return [GOAL for _ in poses]

    made = ros2_action.NavigateAction(
        SimpleNamespace(node=None), lambda: navigator, goals_of, refused.append
    )
    made.navigator, made.refused = navigator, refused
    return made


def begin(action, handle):
    job = action._pursue(handle)
    job.send(None)
    return job


def end(job):
    with pytest.raises(StopIteration):
        job.send(None)


@pytest.mark.parametrize(
    ("seen", "outcome"),
    [
        (status("arrived"), "succeeded"),
        (status("stuck"), "aborted"),
        (status("infeasible"), "aborted"),
        (status("partial", [(3.0, 3.0, 0.0)]), "aborted"),
    ],
)
def test_goal_ends_as_the_team_does(action, seen, outcome):
    handle = Handle()
    job = begin(action, handle)
    for state in ("partial", "stopped", "paused", "final"):
        action.look(status(state))
    assert not handle.ended
    assert handle.told == [1, 1, 1, 1]
    action.look(seen)
    end(job)
    assert handle.ended == [outcome]
    action.look(seen)


def test_cancelled_goal_cancels_the_team(action):
    handle = Handle()
    job = begin(action, handle)
    handle.is_cancel_requested = True
    action.look(status("partial"))
    end(job)
    assert handle.ended == ["canceled"]
    assert action.navigator.cancelled


def test_goal_cancelled_at_a_node_that_is_not_active_ends(action):
    def inactive():
        raise InputError("the node is inactive; activate it first")

    handle = Handle()
    job = begin(action, handle)
    handle.is_cancel_requested = True
    action._active = inactive
    action.look(status("inactive"))
    end(job)
    assert handle.ended == ["aborted"]


def test_new_goal_takes_the_place_of_the_last_one(action):
    first, second = Handle(), Handle()
    before = begin(action, first)
    after = begin(action, second)
    end(before)
    assert first.ended == ["aborted"]
    action.look(status("arrived"))
    end(after)
    assert second.ended == ["succeeded"]


def test_goal_in_another_frame_is_refused(action):
    handle = Handle()
    handle.request.poses[0].header = "odom"
    with pytest.raises(StopIteration):
        action._pursue(handle).send(None)
    assert handle.ended == ["aborted"]
    assert action.refused == ["navigate: in frame 'odom'; expected 'map'"]
    assert action._judge(handle.request) == action._reject
