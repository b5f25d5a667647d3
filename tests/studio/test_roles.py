"""Who drives, of those who look; with a page that is only pretended."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from cavalcade.errors import InputError
from cavalcade.studio.roles import Roles


class Widget(SimpleNamespace):
    def __enter__(self) -> Widget:
        return self

    def __exit__(self, *_: object) -> None:
        return

    def on_click(self, act: Callable[[Any], None]) -> None:
        self.act = act

    def click(self) -> None:
        self.act(None)

    def close(self) -> None:
        self.closed = True


class Client:
    """One who looks, with what is on top of their page."""

    def __init__(self, number: int) -> None:
        self.client_id = number
        self.buttons: dict[str, Widget] = {}
        self.texts: list[Widget] = []
        self.modals: list[Widget] = []
        self.gui = self

    def add_markdown(self, content: str, **_: Any) -> Widget:
        self.texts.append(Widget(content=content, visible=True))
        return self.texts[-1]

    def add_button(self, label: str, **_: Any) -> Widget:
        self.buttons[label] = Widget(visible=True, disabled=False)
        return self.buttons[label]

    def add_modal(self, title: str) -> Widget:
        self.modals.append(Widget(title=title, closed=False))
        return self.modals[-1]

    @property
    def line(self) -> str:
        return str(self.texts[0].content)


class Server:
    def __init__(self) -> None:
        self.clients: dict[int, Client] = {}
        self.said: list[tuple[int, str]] = []
        self.roles = Roles(self, threading.RLock(), self.say)

    def say(self, text: str, client: Client) -> None:
        self.said.append((client.client_id, text))

    def on_client_connect(self, act: Callable[[Any], None]) -> None:
        self.came = act

    def on_client_disconnect(self, act: Callable[[Any], None]) -> None:
        self.went = act

    def get_clients(self) -> dict[int, Client]:
        return self.clients

    def come(self, number: int) -> Client:
        client = self.clients[number] = Client(number)
        self.came(client)
        return client

    def go(self, client: Client) -> None:
        del self.clients[client.client_id]
        self.went(client)


@pytest.fixture
def server() -> Server:
    return Server()


def test_the_first_drives_and_the_next_takes_over(server: Server) -> None:
    left: list[int] = []
    server.roles.on_leave.append(lambda: left.append(1))
    first, second, third = (server.come(k) for k in (1, 2, 3))
    assert server.roles.driver == 1
    assert "2 others watch" in first.line
    assert "You watch" in second.line
    server.go(third)
    assert server.roles.driver == 1
    assert left == []
    server.go(first)
    assert server.roles.driver == 2
    assert left == [1]
    assert second.line == ""
    server.go(second)
    assert server.roles.driver is None
    assert left == [1, 1]
    assert server.come(4).client_id == server.roles.driver


def test_who_asks_is_let_drive_or_not(server: Server) -> None:
    first, second = server.come(1), server.come(2)
    second.buttons["Ask to drive"].click()
    assert server.roles.asking == 2
    assert "waiting" in second.line
    assert first.modals[0].title == "Somebody else wants to drive"
    first.buttons["Keep driving"].click()
    assert first.modals[0].closed
    assert server.roles.driver == 1
    assert server.roles.asking is None
    assert (2, "The one who drives keeps on driving") in server.said
    server.roles.ask(2)
    first.buttons["Let them drive"].click()
    assert server.roles.driver == 2
    assert "You watch" in first.line


def test_odd_orders_of_asking_end_in_words(server: Server) -> None:
    first, second, third = (server.come(k) for k in (1, 2, 3))
    with pytest.raises(InputError, match="you drive already"):
        server.roles.ask(1)
    with pytest.raises(InputError, match="gone"):
        server.roles.ask(7)
    server.roles.ask(2)
    with pytest.raises(InputError, match="you have asked already"):
        server.roles.ask(2)
    with pytest.raises(InputError, match="somebody else has asked"):
        server.roles.ask(3)
    server.go(second)  # who asked
    assert server.roles.asking is None
    assert first.modals[0].closed
    server.roles.answer(True)  # a click that came too late
    assert server.roles.driver == 1
    server.roles.ask(3)
    server.go(first)  # who was asked
    assert server.roles.driver == 3
    assert server.roles.asking is None
    server.go(third)
    late = Client(9)
    server.came(late)  # gone before we heard of it
    assert server.roles.driver is None
    assert server.roles.count == 0
