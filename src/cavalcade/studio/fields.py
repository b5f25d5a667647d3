"""Widgets of the page that show and change values of something, without fighting who types."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.studio.build.parameters import Parameter, default_of, hint, text_of_value
from cavalcade.studio.session import Session
from cavalcade.yaml_text import parse_yaml

WAIT = 0.6
"""How long nothing has to be typed until what was typed is taken, s."""

DEFAULT = "default"
"""The choice that says nothing."""


class Fields:
    """Widgets, each with what it shows and what it changes.

    What is typed is taken once nobody types any more. What is refused is told by `refused`, and
    its widget shows again what is the case.

    Args:
        session: The page's.
        told: Called with the words of what was refused, and with None once something was taken.
    """

    def __init__(self, session: Session, told: Callable[[str | None], None]) -> None:
        self._session = session
        self._told = told
        self._shown: dict[str, tuple[Any, Callable[[], Any]]] = {}
        self._pending: dict[str, tuple[threading.Timer, Callable[[], None]]] = {}

    def bind(
        self,
        widget: Any,
        read: Callable[[], Any],
        write: Callable[[Any], None],
        wait: float = 0.0,
    ) -> Any:
        """Let a widget show what `read` gives, and `write` what somebody sets it to."""
        name = widget._impl.uuid
        self._shown[name] = (widget, read)

        def updated(event: Any) -> None:
            if event.client_id is None:  # it was us
                return
            taken = False

            def take(_: Any) -> None:
                nonlocal taken
                taken = True
                value = widget.value
                self._later(name, lambda: self.attempt(lambda: write(value), event.client), wait)

            self._session.handle(take)(event)
            if not taken:
                self._show(name)

        widget.on_update(updated)
        return widget

    def button(self, widget: Any, act: Callable[[Any], None]) -> Any:
        """Let a button, a group of them or an upload do something."""

        def clicked(event: Any) -> None:
            def do(event: Any) -> None:
                self.flush()
                self.attempt(lambda: act(event), event.client)

            self._session.handle(do)(event)

        (widget.on_upload if hasattr(widget, "on_upload") else widget.on_click)(clicked)
        return widget

    def attempt(self, act: Callable[[], None], client: Any = None) -> bool:
        """Do something; what is refused is told, and all widgets show what is the case."""

        def told() -> None:
            try:
                act()
            except CavalcadeError as error:
                self._told(str(error))
                raise
            self._told(None)

        done = self._session.attempt(told, client)
        self.show()
        return done

    def show(self) -> None:
        """Let all widgets show what is the case, but those that somebody types into."""
        for name in list(self._shown):
            if name not in self._pending:
                self._show(name)

    def forget(self, widgets: Sequence[Any]) -> None:
        """Remove widgets from the page."""
        for widget in widgets:
            self._shown.pop(widget._impl.uuid, None)
            timer, _ = self._pending.pop(widget._impl.uuid, (None, None))
            if timer is not None:
                timer.cancel()
            widget.remove()

    def flush(self) -> None:
        """Take what was typed just now at once."""
        for name in list(self._pending):
            timer, act = self._pending.pop(name, (None, None))
            if timer is not None and act is not None:
                timer.cancel()
                act()

    def close(self) -> None:
        """Take nothing any more."""
        for timer, _ in self._pending.values():
            timer.cancel()
        self._pending.clear()

    def _later(self, name: str, act: Callable[[], object], wait: float) -> None:
        """Do something if nothing else is to be done with that widget for so long."""
        if name in self._pending:
            self._pending[name][0].cancel()
        if not wait:
            self._pending.pop(name, None)
            act()
            return

        def due() -> None:
            with self._session.lock:
                if self._pending.get(name, (None,))[0] is timer:
                    del self._pending[name]
                    act()

        timer = threading.Timer(wait, due)
        timer.daemon = True
        self._pending[name] = (timer, lambda: (act(), None)[1])
        timer.start()

    def _show(self, name: str) -> None:
        widget, read = self._shown[name]
        value = read()
        if isinstance(value, str) and hasattr(widget, "options") and value not in widget.options:
            widget.options = (*widget.options, value)
        widget.value = value


def parameter_field(
    fields: Fields,
    gui: Any,
    parameter: Parameter,
    label: str,
    get: Callable[[str], Any],
    put: Callable[[str, Any], None],
    otherwise: Callable[[Parameter], Any] = lambda _: None,
) -> Any:
    """A widget for a value of the file.

    Args:
        get, put: Of a dotted path: what the file says, None for nothing, and to change it.
        otherwise: What holds where the file says nothing; None: the default of the file.
    """
    path = parameter.path

    def default() -> Any:
        known = otherwise(parameter)
        return default_of(parameter, get("planner") or {})[0] if known is None else known

    about = hint(parameter, get("planner") or {})
    if parameter.choices or parameter.flag:
        choices = parameter.choices or ("true", "false")
        options = choices if default() is not None else (DEFAULT, *choices)

        def chosen() -> str:
            said = get(path)
            return text_of_value(default() if said is None else said) or DEFAULT

        def choose(text: str) -> None:
            value: Any = text if parameter.choices else text == "true"
            put(path, None if text == DEFAULT or value == default() else value)

        return fields.bind(
            gui.add_dropdown(label, options, initial_value=chosen(), hint=about), chosen, choose
        )

    def read() -> str:
        said = get(path)
        return text_of_value(default() if said is None else said)

    def write(text: str) -> None:
        if not text.strip():
            put(path, None)
            return
        try:
            value = parse_yaml(text)
        except InputError as error:
            raise error.at(key=path) from None
        put(path, None if value == default() else value)

    return fields.bind(gui.add_text(label, read(), hint=about), read, write, WAIT)
