"""The tab Study: runs, plans and campaigns are opened, compared and taken along."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cavalcade.campaign.repeat import repeat_trial
from cavalcade.errors import InputError
from cavalcade.studio.session import Session
from cavalcade.studio.study.campaign_view import CampaignView
from cavalcade.studio.study.results import Result, folder_of, kind_of, read_result, results_in
from cavalcade.studio.study.run_view import RunView
from cavalcade.studio.study.trial_list import Row, TrialList

RUNS = Path("runs")
"""Where results are looked for besides the studio's own folder."""

_CHOOSE, _NOTHING = "choose …", "nothing"


class StudyPanel:
    """What stands in the tab; made inside its container.

    Attributes:
        view: The run that is looked at; None before one is opened.
        campaign: The campaign whose trials are listed; None without one.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self.view: RunView | None = None
        self.campaign: CampaignView | None = None
        self._first: Result | None = None
        self._second: Result | None = None
        self._over = False
        self._entered = self._closed = False
        self._asked = 0
        self._doing: list[str] = []
        self._trials: TrialList | None = None
        self._trial: str | None = None
        self._found: dict[str, Path] = {}
        gui, handle = session.server.gui, session.handle
        self._listed = gui.add_dropdown("Open", (_CHOOSE,), hint="The studio's results and ./runs")
        self._listed.on_update(handle(self._on_listed))
        self._path = gui.add_text("Folder", "", hint="Path of a run, a plan or a campaign")
        opening = gui.add_button("Open this folder", icon="folder-open")
        opening.on_click(handle(lambda event: self._ask(self._path.value, event.client)))
        self._busy = gui.add_markdown("", visible=False)
        self._campaign_place = gui.add_folder("Campaign", visible=False)
        with self._campaign_place:
            self._offer = gui.add_markdown("", order=1e6, visible=False)
            self._again = gui.add_button(
                "Run it again", icon="refresh", order=1e6 + 1, visible=False
            )
            self._again.on_click(handle(lambda event: self._run_again(event.client)))
        self._compared = gui.add_dropdown("Compare with", (_NOTHING,), visible=False)
        self._compared.on_update(handle(self._on_compared))
        self._place = gui.add_folder(None)
        self._campaign_part: Any = None
        self._part: Any = None
        self._list()
        session.themed.append(self._on_theme)

    def open(self, folder: str | Path) -> None:
        """Look at what a run, a plan or a campaign has left.

        Raises:
            InputError: It is none of them, or damaged.
        """
        self._open(self._read(folder_of(str(folder))))

    def compare(self, folder: str | Path) -> None:
        """Look at another run beside the one that is open.

        Raises:
            InputError: There is none to compare with, or that folder is none.
        """
        if self._first is None:
            raise InputError("open a run first, then one to compare it with")
        self._compare(read_result(folder_of(str(folder))))

    def choose_trial(self, trial: str) -> None:
        """Open a trial of the campaign, or offer to run it again if nothing was kept of it.

        Raises:
            InputError: There is no such trial.
        """
        rows = [] if self._trials is None else self._trials.rows
        row = next((row for row in rows if row["trial"] == trial), None)
        if row is None:
            raise InputError(f"there is no trial {trial!r}")
        self._on_trial(row, None)

    def run_again(self) -> None:
        """Run the trial again that was chosen last, in a thread of its own."""
        self._run_again(None)

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""
        self._entered = True
        self._list()
        self._session.stage.clear()
        if self.view is not None:
            self.view.enter()

    def leave(self) -> None:
        """Another one has been chosen."""
        self._entered = False
        if self.view is not None:
            self.view.leave()

    def close(self) -> None:
        """The studio ends."""
        self._closed = True
        if self.view is not None:
            self.view.close()

    def play_or_pause(self) -> None:
        """Go on, or stand still, if there is a run."""
        if self.view is not None:
            self.view.timeline.play_or_pause()

    def step(self) -> None:
        """A little on."""
        if self.view is not None:
            self.view.timeline.step()

    def stop(self) -> None:
        """Stand still."""
        if self.view is not None:
            self.view.timeline.pause()

    def _on_theme(self) -> None:
        if self.view is not None:
            self.view.show()

    def _list(self) -> None:
        """Offer the results that there are now."""
        places = [self._session.folder, RUNS]
        self._found = {}
        for folder in results_in(place.resolve() for place in places):
            name = _short(folder, places)
            while name in self._found:
                name += " "
            self._found[name] = folder
        self._listed.options = (_CHOOSE, *self._found)
        runs = [name for name, one in self._found.items() if kind_of(one) != "campaign"]
        if self._second is None:
            self._compared.options = (_NOTHING, *runs)

    def _on_listed(self, event: Any) -> None:
        if event.client is not None and event.target.value in self._found:
            folder = self._found[event.target.value]
            self._path.value = str(folder)
            self._ask(str(folder), event.client)

    def _ask(self, text: str, client: Any) -> None:
        """Open what somebody has named."""
        folder = folder_of(text)
        self._load(f"Opening {folder.name} …", lambda: self._read(folder), self._open, client)

    def _on_compared(self, event: Any) -> None:
        if event.client is None:
            return
        folder = self._found.get(event.target.value)
        if folder is None:
            self._second = None
            self._show(self._time())
        else:
            words = f"Opening {folder.name} …"
            self._load(words, lambda: read_result(folder), self._compare, event.client)

    def _compare(self, second: Result) -> None:
        self._second = second
        name = next((name for name, one in self._found.items() if one == second.folder), None)
        if name is None:
            name = second.name
            self._found[name] = second.folder
            self._compared.options = (*self._compared.options, name)
        self._compared.value = name
        self._show(self._time())

    def _lay(self, over: bool) -> None:
        self._over = over
        self._show(self._time())

    def _read(self, folder: Path) -> Result | TrialList:
        return TrialList(folder) if kind_of(folder) == "campaign" else read_result(folder)

    def _open(self, opened: Result | TrialList) -> None:
        if isinstance(opened, TrialList):
            self._open_campaign(opened)
            return
        self._first, self._second = opened, None
        self._compared.value = _NOTHING
        self._list()
        self._show(None)

    def _open_campaign(self, trials: TrialList) -> None:
        self._trials = trials
        self._offer_again(None, "")
        if self._campaign_part is not None:
            self._campaign_part.remove()
        gui = self._session.server.gui
        with self._campaign_place:
            self._campaign_part = gui.add_folder(None)
            with self._campaign_part:
                self.campaign = CampaignView(self._session, trials, self._on_trial)
        self._campaign_place.visible = True

    def _on_trial(self, row: Row, client: Any) -> None:
        """Open the trial's results if somebody has kept them; else offer to run it again."""
        trial = str(row["trial"])
        kept = [self._again_folder(trial)]
        if self._trials is not None:
            kept += [self._trials.folder / trial, self._trials.folder / "trials" / trial]
        for folder in kept:
            if kind_of(folder) in ("run", "plan"):
                self._offer_again(None, "")
                self._ask(str(folder), client)
                return
        self._offer_again(trial, f"No recording of **{trial}** was kept. It can be run again.")

    def _offer_again(self, trial: str | None, text: str) -> None:
        self._trial = trial
        self._offer.content = text
        self._offer.visible = self._again.visible = trial is not None

    def _run_again(self, client: Any) -> None:
        if self._trial is None or self._trials is None:
            return
        trial, campaign = self._trial, self._trials.folder
        out = self._again_folder(trial)

        def run() -> Result:
            repeated = repeat_trial(campaign, trial, out, force=True)
            if kind_of(out) is None:
                detail = repeated.line.get("detail") or repeated.line.get("outcome")
                raise InputError(f"{trial} leaves no recording: {detail}")
            return read_result(out)

        self._offer_again(None, "")
        self._load(f"Running {trial} again …", run, self._open, client)

    def _again_folder(self, trial: str) -> Path:
        campaign = self._trials.folder.name if self._trials is not None else "campaign"
        return self._session.folder / "trials" / campaign / trial

    def _time(self) -> float | None:
        return None if self.view is None else self.view.timeline.time

    def _show(self, time: float | None) -> None:
        """Build the run's part of the page anew, and its scene."""
        if self._first is None:
            return
        if self.view is not None:
            self.view.close()
        if self._part is not None:
            self._part.remove()
        gui = self._session.server.gui
        with self._place:
            self._part = gui.add_folder(None)
            with self._part:
                self.view = RunView(
                    self._session,
                    self._first,
                    self._second,
                    over=self._over,
                    time=time,
                    work=self._work,
                    lay=self._lay,
                )
        self._compared.visible = True
        if self._entered:
            self.view.enter()

    def _load(
        self, words: str, act: Callable[[], Any], then: Callable[[Any], None], client: Any
    ) -> None:
        """Open something; who opens another thing before it is there gets only that."""
        self._asked += 1
        number = self._asked

        def newest(found: Any) -> None:
            if number == self._asked:
                then(found)

        self._work(words, act, newest, client)

    def _work(
        self, words: str, act: Callable[[], Any], then: Callable[[Any], None], client: Any
    ) -> None:
        """Do what takes long in a thread of its own; the page says so meanwhile."""
        self._doing.append(words)
        self._say_doing()

        def done(outcome: Callable[[], None]) -> None:
            with self._session.lock:
                if not self._closed:
                    self._doing.remove(words)
                    self._say_doing()
                    self._session.attempt(outcome, client)

        def work() -> None:
            try:
                found = act()
            except Exception as error:
                reason = error
                done(lambda: _raise(reason))
            else:
                done(lambda: then(found))

        threading.Thread(target=work, name="study-work", daemon=True).start()

    def _say_doing(self) -> None:
        self._busy.content = "\n\n".join(self._doing)
        self._busy.visible = bool(self._doing)


def _raise(error: Exception) -> None:
    raise error


def _short(folder: Path, places: list[Path]) -> str:
    """A folder's name as short as it is told by."""
    for place in places:
        if folder.is_relative_to(place.resolve()):
            relative = folder.relative_to(place.resolve())
            return str(relative if place is not RUNS else RUNS / relative)
    return str(folder)
