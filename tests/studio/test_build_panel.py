"""The tab Build without a browser: what it shows in the scene, and that it stays whole."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from cavalcade.scenario import scenario_names
from cavalcade.studio.app import Studio
from cavalcade.studio.build.edits import with_individual_goals, with_team


def test_the_scene_shows_no_stand_ins(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Any] = []
    stage = studio.session.stage
    take = stage.set_world
    monkeypatch.setattr(stage, "set_world", lambda s, w: (shown.append(s), take(s, w)))
    draft = studio.build.draft
    draft.set("world.empty.size", [12.0, 8.0])
    assert shown[-1].task.goals == ()
    assert shown[-1].goals == ()
    draft.set("robots", [{"start": [1.0, 1.0, 0.0]}])
    assert shown[-1].task.goals == ()
    draft.replace(with_team(draft.state, "go1", 4))
    assert shown[-1] == draft.state.shown
    draft.replace(with_individual_goals(draft.state))
    assert len(shown[-1].goals) == 4
    draft.set("robots[0].goal", None)
    assert shown[-1].goals == ()


def test_every_shipped_scenario_can_be_built_on(studio: Studio) -> None:
    draft = studio.build.draft
    for name in scenario_names():
        draft.load(name)
        for kind, count in studio.build._bench.selectable().items():
            for index in range(count):
                studio.build._bench.select((kind, index))
        draft.undo()
        draft.redo()
    studio.build.leave()
    studio.build.enter()
    assert studio.build.draft.scenario is not None


def test_what_is_selected_is_forgotten_with_it(studio: Studio) -> None:
    draft, bench = studio.build.draft, studio.build._bench
    draft.replace(with_team(draft.state, "go1", 4))
    bench.select(("robot", 3))
    draft.undo()
    assert bench.selected is None


def test_what_is_dropped_where_it_cannot_be_goes_back(studio: Studio) -> None:
    draft, scene = studio.build.draft, studio.build._scene
    draft.replace(with_team(draft.state, "go1", 4))
    studio.build._bench.select(("robot", 0))
    event = SimpleNamespace(client=None, client_id=None)
    before = draft.data
    gizmo = scene._gizmos["robot", 0]
    gizmo.pose = (1.6, 5.71, 0.0)
    scene._preview(("robot", 0), gizmo.pose)
    assert "overlaps robot" in (studio.build._bench.warned or "")
    scene._dropped(("robot", 0), gizmo.pose, event)
    assert draft.data is before
    assert "overlaps robot" in (studio.build._bench.refused or "")
    assert gizmo.pose == pytest.approx(draft.state.robots[0][1])
    scene._dropped(("goal", 0), (10.0, 2.0, 1.0), event)
    assert draft.state.goals == ((10.0, 2.0, 1.0),)
    assert studio.build._bench.refused is None
    assert studio.build._bench.warned is None
    draft.undo()
    assert scene._gizmos["goal", 0].pose == pytest.approx(draft.state.goals[0])
