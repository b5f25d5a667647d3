"""A studio of the test's own, looked at in real Chromium; skipped where there is none."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from cavalcade.studio.app import Studio

PATIENCE = 30.0
"""Longest that a test waits for something that should happen at once, s."""

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_ARGUMENTS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """A browser without a window: Playwright's, driving Debian's Chromium."""
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    found = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if found is None:
        pytest.skip("there is no Chromium here")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found, args=list(_ARGUMENTS))
        yield browser
        browser.close()


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio on a free port, its files in a folder of the test's own."""
    with Studio(port=0, folder=tmp_path / "studio") as opened:
        yield opened


@pytest.fixture
def open_page(chromium: Any, studio: Studio) -> Iterator[Callable[..., Any]]:
    """Opens the studio in another tab: `open_page(width=1280, height=720)` gives its page.

    `port` is that of a detour to the studio.

    It has connected and its scene is drawn. Each tab is a browser's window of its own, as two
    people have them. An error on a page that nothing caught fails the test.
    """
    contexts: list[Any] = []
    errors: list[str] = []

    def opened(width: int = 1280, height: int = 720, port: int = 0, **options: Any) -> Any:
        before = set(studio.session.server.get_clients())
        context = chromium.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(1e3 * PATIENCE)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(f"http://127.0.0.1:{port}" if port else studio.session.address)
        page.wait_for_selector("canvas")
        end = time.monotonic() + PATIENCE
        while not set(studio.session.server.get_clients()) - before:
            assert time.monotonic() < end, "the page does not connect"
            page.wait_for_timeout(20)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not errors, errors


@pytest.fixture
def page(open_page: Callable[..., Any]) -> Any:
    """The studio in a tab."""
    return open_page()


@pytest.fixture
def until() -> Callable[..., None]:
    """Waits until something holds: `until(page, condition, what)`; the page goes on meanwhile."""

    def wait(
        page: Any, condition: Callable[[], Any], what: str = "it", patience: float = PATIENCE
    ) -> None:
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, f"{what} has not come about in {patience:g} s"
            page.wait_for_timeout(20)

    return wait
