"""Planner and execution: a field for every value of these sections of the file."""

from __future__ import annotations

from typing import Any

from cavalcade.scenario.rules import UNUSED_KEYS
from cavalcade.scenario.settings import TEAM_METHODS, TEAM_VARIANTS
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.edits import is_individual
from cavalcade.studio.build.parameters import Parameter, hint, parameters
from cavalcade.studio.fields import parameter_field


class SettingsPart:
    """A folder with all values of one section.

    Args:
        section: `planner` or `execution`.
    """

    def __init__(self, bench: Bench, section: str) -> None:
        self._bench = bench
        self._section = section
        self._widgets: list[tuple[Parameter, Any]] = []
        self._folders: dict[str, Any] = {}
        self._reset = bench.gui.add_button(
            "Back to defaults",
            icon="restore",
            color="gray",
            hint="Takes away all that is said here.",
        )
        bench.fields.button(self._reset, lambda _: bench.draft.set(section, None))
        for parameter in parameters(section):
            group, _, rest = parameter.key.rpartition(".")
            if not group:
                self._add(parameter, parameter.label)
                continue
            with self._folder(group):
                unit = f" ({parameter.unit})" if parameter.unit else ""
                self._add(parameter, f"{rest}{unit}")
        bench.updated.append(self.show)
        self.show()

    def show(self) -> None:
        """Show what applies to the task, with the defaults of the variant."""
        bench = self._bench
        self._reset.visible = bench.draft.data.get(self._section) not in (None, {})
        planner = bench.get("planner") or {}
        unused = UNUSED_KEYS[bench.draft.state.shown.task.kind]
        individual = is_individual(bench.draft.data)
        for parameter, widget in self._widgets:
            key = parameter.key.partition(".")[0]
            hidden = self._section == "planner" and key in unused
            widget.visible = not hidden
            if key in self._folders:
                self._folders[key].visible = not hidden
            if parameter.path == "planner.method":
                widget.options = TEAM_METHODS if individual else _others(parameter)
            elif parameter.path == "planner.variant":
                widget.options = TEAM_VARIANTS if individual else parameter.choices
            widget.hint = hint(parameter, planner)

    def _add(self, parameter: Parameter, label: str) -> None:
        bench = self._bench
        widget = parameter_field(
            bench.fields, bench.gui, parameter, label, bench.get, bench.draft.set, self._default
        )
        self._widgets.append((parameter, widget))

    def _default(self, parameter: Parameter) -> Any:
        """Of values that depend on the task; None for all others."""
        if parameter.path == "planner.method":
            return self._bench.draft.state.shown.planner.method
        return None

    def _folder(self, group: str) -> Any:
        if group not in self._folders:
            self._folders[group] = self._bench.gui.add_folder(group, expand_by_default=False)
        return self._folders[group]


def _others(parameter: Parameter) -> tuple[str, ...]:
    return tuple(one for one in parameter.choices if one not in TEAM_METHODS)
