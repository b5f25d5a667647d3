"""The tab Drive without a browser: what is shown when, and what happens when that fails."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest

from cavalcade.studio.app import Studio
from cavalcade.studio.drive.changes import Changes

WORDS: dict[str, Any] = {
    "version": 1,
    "name": "shown",
    "world": {"empty": {"size": [10, 8]}},
    "robots": [{"model": "go1", "start": [1.5, 4.0, 0.0]}],
    "task": {"formation": {"shape": "column", "spacing": 1.0}, "goals": [[8.0, 4.0, 0.0]]},
}


def until(condition: Any, what: str) -> None:
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.005)


def started(studio: Studio) -> Any:
    studio.build.draft.replace(WORDS)
    studio.choose("Drive")
    studio.drive.act("Start")
    return studio.drive.drive


def test_who_waits_for_changes_is_woken() -> None:
    changes, found = Changes(), []
    assert changes.wait(0, 0.0) == 0
    waiting = threading.Thread(target=lambda: found.append(changes.wait(0, 60.0)))
    waiting.start()
    changes.tell()
    waiting.join()
    assert found == [1]
    assert changes.wait(0, 60.0) == 1  # what has come already is not waited for


def test_moments_are_shown_in_order_and_none_twice(studio: Studio) -> None:
    shown: list[float] = []
    drive = started(studio)
    studio.session.stage.show = lambda moment: shown.append(moment.time)  # type: ignore[method-assign]
    until(lambda: drive.phase == "running", "it runs")
    until(lambda: len(shown) > 20, "it is shown")
    assert len(set(shown)) == len(shown)
    assert sorted(shown) == shown


def test_a_scene_that_fails_is_said_once(
    studio: Studio, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried, said = [], []

    def show(moment: Any) -> None:
        tried.append(moment)
        raise ValueError("planted")

    started(studio)
    monkeypatch.setattr(studio.session.stage, "show", show)
    monkeypatch.setattr(studio.session, "say", lambda text, **_: said.append(text))
    until(lambda: len(tried) > 10, "it is tried again")
    assert said == ["What is driven cannot be shown: ValueError: planted"]
    assert caplog.text.count("planted") <= 2  # the message and its traceback's last line


def test_a_refused_change_is_said_on_the_page(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    drive = started(studio)
    monkeypatch.setattr(studio.session, "say", lambda text, **_: said.append(text))
    until(lambda: drive.phase == "running", "it runs")
    monkeypatch.setattr(type(drive), "refused", ("no such obstacle at 1 s",))
    until(lambda: said, "it is said")
    assert said == ["A change could not happen any more: no such obstacle at 1 s"]
