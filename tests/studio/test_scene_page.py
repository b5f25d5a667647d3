"""The scene as a browser shows it, and what a click on it tells Python."""

from __future__ import annotations

from typing import Any

from cavalcade.scenario import build_world, load_scenario, resolve_scenario
from cavalcade.studio.app import Studio


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
    look_at = studio.session.server.initial_camera.look_at

    def click() -> bool:
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.wait_for_timeout(100)
        return bool(places)

    until(page, click, "the click")
    x, y = places[-1]
    assert abs(x - look_at[0]) < 0.1
    assert abs(y - look_at[1]) < 0.1
