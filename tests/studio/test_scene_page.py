"""The scene as a browser shows it, and what a click on it tells Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cavalcade.scenario import build_world, load_scenario, resolve_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.scene import camera


def _show(studio: Studio, name: str) -> Any:
    scenario = resolve_scenario(load_scenario(name))
    stage = studio.session.stage
    stage.set_world(scenario, build_world(scenario))
    stage.set_team(scenario.models, scenario.starts)
    stage.frame_team()
    return scenario


def test_a_click_on_the_ground_gives_its_place(studio: Studio, open_page: Any, until: Any) -> None:
    _show(studio, "square-clutter")
    places: list[tuple[float, float]] = []
    studio.session.stage.on_ground_click(lambda event, x, y: places.append((x, y)))
    page = open_page()
    box = page.locator("canvas").first.bounding_box()
    first = studio.session.server.initial_camera
    ahead = first.look_at - first.position
    wanted = first.position - first.position[2] / ahead[2] * ahead

    def click() -> bool:
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.wait_for_timeout(100)
        return bool(places)

    until(page, click, "the click")
    assert places[-1] == pytest.approx(wanted[:2], abs=0.05)


def _canvas_middle(page: Any) -> tuple[float, float]:
    box = page.locator("canvas").first.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def _look_at(studio: Studio, place: tuple[float, float, float]) -> None:
    eye = np.array(place) + (0.0, -2.0, 2.5)
    camera.look(studio.session.server, eye, np.array(place))


def test_a_click_on_a_robot_or_an_obstacle_says_which_and_is_none_on_the_ground(
    studio: Studio, open_page: Any, until: Any
) -> None:
    scenario = _show(studio, "square-clutter")
    world = build_world(scenario)
    stage = studio.session.stage
    picked: list[tuple[str, int]] = []
    ground: list[tuple[float, float]] = []
    stage.on_pick(lambda event, kind, index: picked.append((kind, index)))
    stage.on_ground_click(lambda event, x, y: ground.append((x, y)))
    page = open_page()
    x, y, _ = scenario.starts[2]
    low_x, low_y, high_x, high_y = world.shapes[1].bounds
    middle = ((low_x + high_x) / 2, (low_y + high_y) / 2, 0.5)
    for place, wanted in (((x, y, 0.28), ("robot", 2)), (middle, ("obstacle", 1))):
        _look_at(studio, place)
        picked.clear()

        def click(wanted: tuple[str, int] = wanted) -> bool:
            page.mouse.click(*_canvas_middle(page))
            page.wait_for_timeout(300)
            return picked[-1:] == [wanted]

        until(page, click, f"the click on {wanted}")
        ground.clear()
        click()
        page.wait_for_timeout(300)
        assert ground == []


def test_a_goal_is_dragged_on_the_ground(studio: Studio, open_page: Any, until: Any) -> None:
    _show(studio, "square-clutter")
    ended: list[tuple[float, float, float]] = []
    changed: list[tuple[float, float, float]] = []
    gizmo = studio.session.stage.goal_gizmo(
        "goal",
        (3.0, 3.0, 0.0),
        lambda event, pose: changed.append(pose),
        lambda event, pose: ended.append(pose),
    )
    page = open_page()
    x, y = _canvas_middle(page)

    def drag() -> bool:
        # From straight above, north is up; the square between both arrows moves on the ground.
        camera.look(studio.session.server, np.array([3.0, 2.99, 6.0]), np.array([3.0, 3.0, 0.06]))
        page.wait_for_timeout(300)
        page.mouse.move(x + 20, y - 20)
        page.mouse.down()
        page.mouse.move(x + 80, y - 60, steps=6)
        page.mouse.up()
        page.wait_for_timeout(200)
        return bool(ended)

    until(page, drag, "the drag")
    assert changed
    assert gizmo.pose == pytest.approx(ended[-1])
    assert gizmo.pose[0] > 3.1
    assert gizmo.pose[1] > 3.1
    assert gizmo.pose[2] == pytest.approx(0.0)
