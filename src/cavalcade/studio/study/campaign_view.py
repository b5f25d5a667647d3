"""A campaign's trials on the page: filtered and sorted; a click on one opens it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cavalcade.errors import InputError
from cavalcade.studio.session import Session
from cavalcade.studio.study.trial_list import Row, TrialList, outcomes

_PAGE = 10
"""Trials that are seen at a time."""

_FIRST = ("trial", "outcome", "makespan_s", "min_footprint_gap_m", "scenario", "variant", "seed")
"""What one sorts by most."""

_HINT = (
    "Words that names or outcome contain, and conditions such as outcome=collision, "
    "variant!=published or makespan_s>60"
)


class CampaignView:
    """The list's part of the page, made inside its container.

    Args:
        session: The page's.
        trials: Of the campaign.
        choose: Called with a trial that is clicked, and the client.
    """

    def __init__(
        self, session: Session, trials: TrialList, choose: Callable[[Row, Any], None]
    ) -> None:
        self._trials = trials
        self._page = 0
        gui, handle = session.server.gui, session.handle
        gui.add_markdown(f"**{trials.folder.name}**: a campaign of {len(trials.rows)} trials")
        self._wanted = gui.add_text("Filter", "", hint=_HINT)
        self._wanted.on_update(handle(lambda _: self._turn_to(0)))
        columns = [name for name in _FIRST if name in trials.columns]
        columns += [name for name in trials.columns if name not in columns]
        self._by = gui.add_dropdown("Sort by", tuple(columns) or ("trial",))
        self._by.on_update(handle(lambda _: self._turn_to(0)))
        self._falling = gui.add_checkbox("Largest first", False)
        self._falling.on_update(handle(lambda _: self._turn_to(0)))
        self._said = gui.add_markdown("")
        self._shown: list[Row] = []
        self._buttons = [gui.add_button("", visible=False) for _ in range(_PAGE)]
        for index, button in enumerate(self._buttons):
            button.on_click(handle(self._chosen(index, choose)))
        self._ways = gui.add_button_group("Trials", ("Before", "After"))
        self._ways.on_click(handle(self._on_way))
        self._turn_to(0)

    @property
    def shown(self) -> tuple[str, ...]:
        """The trials on the page."""
        return tuple(str(row["trial"]) for row in self._shown)

    def _chosen(self, index: int, choose: Callable[[Row, Any], None]) -> Callable[[Any], None]:
        return lambda event: choose(self._shown[index], event.client)

    def _on_way(self, event: Any) -> None:
        self._turn_to(self._page + (1 if event.target.value == "After" else -1))

    def _turn_to(self, page: int) -> None:
        by = self._by.value
        try:
            rows = self._trials.chosen(self._wanted.value, by, self._falling.value)
        except InputError as error:  # half typed, perhaps: what is listed stays
            self._said.content = f"⚠ {error}"
            return
        last = max(0, (len(rows) - 1) // _PAGE)
        self._page = min(max(page, 0), last)
        first = self._page * _PAGE
        self._shown = rows[first : first + _PAGE]
        place = f"{first + 1} to {first + len(self._shown)} of " if len(rows) > _PAGE else ""
        many = f"{place}{len(rows)} trials: {outcomes(rows)}" if rows else "No trial is like that."
        self._said.content = many
        self._ways.visible = len(rows) > _PAGE
        for index, button in enumerate(self._buttons):
            button.visible = index < len(self._shown)
            if index < len(self._shown):
                button.label = _label(self._shown[index], by)
                button.color = _color(self._shown[index])


def _label(row: Row, by: str) -> str:
    parts = [str(row["trial"]), str(row.get("outcome") or "unknown")]
    if by not in ("trial", "outcome") and row.get(by) is not None:
        value = row[by]
        parts.append(f"{by} {value:.4g}" if isinstance(value, float) else f"{by} {value}")
    return " · ".join(parts)


def _color(row: Row) -> str:
    return "gray" if row.get("success") else "red"
