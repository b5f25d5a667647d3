"""What the scene sends to the page, and what it does not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Obstacle, build_world, load_scenario, resolve_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.scene.stage import Stage
from cavalcade.studio.snapshot import Snapshot


class Sent(list):
    """Messages that went to the page since they were forgotten last."""

    def names(self) -> set[str]:
        return {getattr(message, "name", "") for message in self}


@pytest.fixture
def sent(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> Iterator[Sent]:
    found = Sent()
    scene = studio.session.server.scene
    original = scene._queue_scene_message

    def queue(message: Any) -> None:
        found.append(message)
        original(message)

    monkeypatch.setattr(scene, "_queue_scene_message", queue)
    return found


@pytest.fixture
def stage(studio: Studio) -> Stage:
    stage = studio.session.stage
    scenario = resolve_scenario(load_scenario("square-clutter"))
    stage.set_world(scenario, build_world(scenario))
    stage.set_team(scenario.models, scenario.starts)
    return stage


def _moment(stage: Stage, **changes: Any) -> Snapshot:
    scenario = stage._scenario
    assert scenario is not None
    poses = np.array(scenario.starts, dtype=float)
    slots = np.array([(0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)])
    status = PlannerStatus(
        state="partial",
        leader=1,
        roles=np.arange(4),
        slots=slots,
        goals=poses[:, :2] + 0.5,
        goal=np.array([5.0, 5.0, 0.0]),
        paths=tuple(np.linspace(pose[:2], pose[:2] + 1.0, 90) for pose in poses),
        connections=np.array([(0, 1), (2, 3)]),
        eta=np.ones(4),
    )
    commands = np.tile((0.3, 0.1, 0.0), (4, 1))
    return replace(Snapshot(1.0, poses, commands, status), **changes)


def test_nothing_is_sent_when_nothing_has_changed(stage: Stage, sent: Sent) -> None:
    for name in stage.layers:
        stage.set_layer(name, name not in ("velocity map", "arrival times"))
    moment = _moment(stage)
    stage.show(moment)
    stage.show(replace(moment, time=1.0))
    sent.clear()
    stage.show(replace(moment))
    assert sent == []


def test_a_robot_that_moves_sends_neither_ground_nor_paths_nor_goals(
    stage: Stage, sent: Sent
) -> None:
    moment = _moment(stage)
    stage.show(moment)
    sent.clear()
    poses = moment.poses + (0.01, 0.0, 0.0)
    stage.show(replace(moment, time=1.05, poses=poses))
    assert sent
    first = {name.split("/")[1] for name in sent.names()}
    assert first == {"robots", "footprints", "leader", "springs"}
    assert len(sent) < 40


def test_layers_come_and_go(stage: Stage, sent: Sent) -> None:
    stage.show(_moment(stage))
    nodes = stage._server.scene
    assert nodes.get_handle_by_name("/paths") is not None
    stage.set_layer("paths", False)
    assert nodes.get_handle_by_name("/paths") is None
    stage.show(_moment(stage, time=2.0))
    assert nodes.get_handle_by_name("/paths") is None
    stage.set_layer("paths", True)
    assert nodes.get_handle_by_name("/paths") is not None
    with pytest.raises(InputError, match="layer"):
        stage.set_layer("path", True)


def test_obstacles_on_the_way_come_move_and_go(stage: Stage, sent: Sent) -> None:
    box = Obstacle.model_validate({"box": {"center": [3.0, 3.0], "size": [0.5, 0.5]}})
    stage.show(_moment(stage, obstacles=(box,)))
    nodes = stage._server.scene
    assert nodes.get_handle_by_name("/mover/0") is not None
    sent.clear()
    stage.show(_moment(stage, obstacles=(box.moved((0.1, 0.0)),)))
    assert "/mover/0" in sent.names()
    stage.show(_moment(stage))
    assert nodes.get_handle_by_name("/mover/0") is None


def test_the_theme_changes_colours_and_keeps_the_rest(stage: Stage, sent: Sent) -> None:
    moment = _moment(stage)
    stage.show(moment)
    stage.set_dark(False)
    floor = stage._server.scene.get_handle_by_name("/ground/floor")
    assert floor.image.min() > 200
    stage.set_dark(True)
    floor = stage._server.scene.get_handle_by_name("/ground/floor")
    assert floor.image.max() < 100
    sent.clear()
    stage.show(moment)
    assert sent == []


def test_nothing_is_left_after_clear(stage: Stage) -> None:
    for name in stage.layers:
        stage.set_layer(name, name not in ("velocity map", "arrival times"))
    stage.show(_moment(stage))
    stage.clear()
    left = [
        name
        for name, handle in stage._server.scene._handle_from_node_name.items()
        if type(handle).__name__ not in ("FrameHandle", "AmbientLightHandle")
    ]
    assert left == []


def test_a_goal_on_the_ground_can_be_set_and_read(stage: Stage) -> None:
    gizmo = stage.goal_gizmo("goal", (1.0, 2.0, 0.5))
    assert gizmo.pose == pytest.approx((1.0, 2.0, 0.5))
    gizmo.pose = (3.0, -1.0, -3.0)
    assert gizmo.pose == pytest.approx((3.0, -1.0, -3.0))
    gizmo.remove()


def test_longer_and_shorter_paths_are_drawn_whole(stage: Stage) -> None:
    turns = np.linspace(0.0, 3.0, 40)
    zigzag = np.column_stack([turns, np.abs(turns % 0.4 - 0.2)]) + 1.0
    for time, count in ((1.0, 2), (2.0, 30), (3.0, 40), (4.0, 5), (5.0, 0)):
        moment = _moment(stage, time=time)
        assert moment.status is not None
        status = replace(moment.status, paths=(zigzag[:count],) + (np.zeros((0, 2)),) * 3)
        stage.show(replace(moment, status=status))
        lines = stage._server.scene.get_handle_by_name("/paths")
        length = np.abs(lines.batched_scales[:, 0] - 0.028).clip(0.0)[
            lines.batched_scales[:, 0] > 0
        ]
        wanted = np.hypot(*np.diff(zigzag[:count], axis=0).T).sum() if count > 1 else 0.0
        assert length.sum() == pytest.approx(wanted, abs=0.15)


def test_lost_robots_and_teams_of_other_sizes(stage: Stage) -> None:
    stage.show(_moment(stage, lost=(1,)))
    scenario = resolve_scenario(load_scenario("triangle-corridor"))
    stage.set_world(scenario, build_world(scenario))
    stage.set_team(scenario.models, scenario.starts)
    assert len(stage._server.scene.get_handle_by_name("/robots/0/0").batched_positions) == 3
