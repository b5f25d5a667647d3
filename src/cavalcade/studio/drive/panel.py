"""The tab Drive."""

from __future__ import annotations

import logging
import math
import re
import threading
import time as wall
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.scenario import ObstacleSpan, Scenario
from cavalcade.scenario.rules import LIVE
from cavalcade.studio.build.panel import BuildPanel
from cavalcade.studio.drive import transport as transport
from cavalcade.studio.drive.drive import Drive
from cavalcade.studio.drive.history import Ground, History
from cavalcade.studio.drive.live_drive import LiveDrive
from cavalcade.studio.drive.plots import Plots
from cavalcade.studio.drive.result import DriveResult
from cavalcade.studio.drive.simulated_drive import SimulatedDrive
from cavalcade.studio.drive.tools import DriveTools
from cavalcade.studio.heartbeat import Heartbeat
from cavalcade.studio.session import Session
from cavalcade.world import Shape, shape_from_mapping

_LOG = logging.getLogger(__name__)

SCENES, WORDS = 25.0, 4.0
"""The scene and the words are brought up to date so often, Hz, at most."""

RUNS = "runs"
"""Below the session's folder: results."""


class DrivePanel:
    """What stands in the tab; made inside its container.

    A thread of its own shows what is driven; the planner's never waits for it.

    Args:
        session: The page.
        build: Has the draft that is driven.
        study: Called with the folder of a run that is to be studied.

    Attributes:
        drive: What is driven, or was last; None before.
        history: What the plots show.
        make_fleet: Connects live teams; None for a ROS 2 graph.
    """

    def __init__(self, session: Session, build: BuildPanel, study: Callable[[Path], None]) -> None:
        self._session, self._build = session, build
        self.drive: Drive | None = None
        self.history = History()
        self.make_fleet: Any = None
        self._entered = self._again = False
        self._refusals = 0
        self._drawn: tuple[Drive, int] | None = None
        self._spans: tuple[ObstacleSpan, ...] | None = None
        self._fixed: tuple[Shape, ...] = ()
        self._drawn_world: tuple[Shape, ...] | None = None
        gui = session.server.gui
        self._emergency = gui.add_button(
            transport.EMERGENCY, color="red", icon="hand-stop", visible=False, order=-60.0
        )
        # Anybody may stop real robots, and nothing that goes on is waited for.
        self._emergency.on_click(lambda _: self.emergency_stop())
        self._transport = transport.Transport(session, self.act, self._set_speed)
        self._tools = DriveTools(session, self._driven)
        with gui.add_folder("Plots", expand_by_default=False):
            self._plots = Plots(gui)
        self._result = DriveResult(session, self._driven, study)
        session.roles.on_leave.append(self._driver_left)
        self._heartbeat = Heartbeat(session.server, lambda: self.is_live)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="cavalcade-show", daemon=True)
        self._thread.start()

    def enter(self) -> None:
        """The tab has been chosen: the scene is this one's now."""
        with self._session.lock:
            self._entered, self._drawn, self._drawn_world = True, None, None
            if self.drive is None:
                self._show_draft()
            else:
                self._show_team(self.drive)
            self._tools.enter()

    def leave(self) -> None:
        """Another one has been chosen; what is driven goes on."""
        with self._session.lock:
            self._entered = False
            self._tools.leave()

    def close(self) -> None:
        """The studio ends: what is driven, too; its results are kept."""
        self._heartbeat.close()
        self._ended.set()
        self._thread.join()
        if self.drive is not None:
            self.drive.close()

    def act(self, what: str) -> None:
        """Do what a button of the transport says.

        Raises:
            InputError: It cannot be done now.
        """
        with self._session.lock:
            if what == transport.START:
                self._start()
                return
            drive = self._driven()
            if what == transport.RESTART:
                drive.stop()
                self._again = True
            else:
                acts = {
                    transport.PAUSE: drive.pause,
                    transport.RESUME: drive.resume,
                    transport.STEP: drive.step,
                    transport.STOP: drive.stop,
                    transport.END: drive.stop,
                }
                acts[what]()

    def play_or_pause(self) -> None:
        """Go on, stand still or begin."""
        self._transport.play_or_pause()

    def step(self) -> None:
        """One cycle."""
        self.act(transport.STEP)

    def stop(self) -> None:
        """End a simulation."""
        self.act(transport.STOP)

    @property
    def is_live(self) -> bool:
        """Whether real robots are driven."""
        return self.drive is not None and self.drive.live and self.drive.phase != "ended"

    def emergency_stop(self, why: str = "by hand") -> None:
        """Stop real robots at once, whoever asks for it."""
        drive = self.drive
        if isinstance(drive, LiveDrive) and self.is_live:
            drive.emergency_stop(why)

    def _driven(self) -> Drive:
        if self.drive is None:
            raise InputError("nothing is driven yet; click on Start")
        return self.drive

    def _start(self) -> None:
        if self.drive is not None and self.drive.phase != "ended":
            raise InputError("a team is driven already; stop it first")
        draft = self._build.draft
        scenario = draft.scenario
        if scenario is None:
            raise InputError(f"there is nothing to drive yet: {draft.error}")
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        out = self._new_folder(scenario.name)
        if scenario.execution.backend in LIVE:
            drive: Drive = LiveDrive(scenario, out, self.make_fleet)
        else:
            drive = SimulatedDrive(scenario, out, speed=self._transport.speed)
        self.drive, self._again, self._refusals = drive, False, 0
        self.history.clear()
        self._plots.set_limits(1.0 / scenario.execution.rate)
        self._tools.begin(drive)
        self._drawn, self._drawn_world = None, None
        if self._entered:
            self._show_team(drive)
        self._emergency.visible = drive.live
        drive.start()

    def _new_folder(self, name: str) -> Path:
        """One that is not there yet."""
        plain = re.sub(r"[^\w.-]+", "-", name).strip("-.") or "run"
        runs, number = self._session.folder / RUNS, 1
        while (runs / f"{plain}-{number}").exists():
            number += 1
        return runs / f"{plain}-{number}"

    def _set_speed(self, speed: float) -> None:
        if self.drive is not None and not self.drive.live and self.drive.phase != "ended":
            self.drive.set_speed(speed)

    def _driver_left(self) -> None:
        """Real robots do not go on for somebody who is not there any more."""
        self.emergency_stop("the page of the one who drives was closed or cut off")

    # The scene.

    def _show_draft(self) -> None:
        state, stage = self._build.draft.state, self._session.stage
        stage.set_world(state.shown, state.world)
        stage.set_team([model for model, _ in state.robots], [pose for _, pose in state.robots])
        stage.frame_team()

    def _show_team(self, drive: Drive) -> None:
        stage = self._session.stage
        self._show_world(drive)
        moment = drive.snapshot()
        poses = drive.scenario.starts if moment is None else moment.poses
        stage.set_team(drive.models, [(float(x), float(y), float(yaw)) for x, y, yaw in poses])
        stage.frame_team()

    def _show_world(self, drive: Drive) -> None:
        """The obstacles that are always there; those that come or go are the moments' own."""
        fixed = self._fixed_shapes(drive)
        if fixed != self._drawn_world:
            self._drawn_world = fixed
            self._session.stage.set_world(drive.scenario, replace(drive.world, shapes=fixed))

    def _fixed_shapes(self, drive: Drive) -> tuple[Shape, ...]:
        spans = drive.spans
        if spans is not self._spans:
            self._tools.fixed = [k for k, span in enumerate(spans) if span.fixed]
            words = [spans[k].obstacle.to_dict() for k in self._tools.fixed]
            self._spans, self._fixed = spans, tuple(map(shape_from_mapping, words))
        return self._fixed

    def _watch(self) -> None:
        """The thread that shows: each cycle once it is planned, so that neither waits long."""
        seen, told, trouble = 0, -math.inf, ""
        while not self._ended.is_set():
            drive, began = self.drive, wall.monotonic()
            try:
                if drive is not None and self._is_new(drive):
                    self._follow(drive)
                if began - told >= 1.0 / WORDS:
                    told = began
                    self._tell(drive)
            except Exception as error:
                if trouble != (trouble := f"{type(error).__name__}: {error}"):
                    _LOG.exception("what is driven cannot be shown")
                    self._session.say(f"What is driven cannot be shown: {trouble}", bad=True)
            self._ended.wait(max(began + 1.0 / SCENES - wall.monotonic(), 0.0))
            if drive is not None:
                seen = drive.changes.wait(seen, 1.0 / WORDS)

    def _is_new(self, drive: Drive) -> bool:
        """Whether its newest moment has not been shown."""
        now = drive, drive.changes.count
        before, self._drawn = self._drawn, now
        return now != before

    def _follow(self, drive: Drive) -> None:
        """Show the newest moment."""
        moment = drive.snapshot()
        if moment is None:
            return
        time = moment.time
        self._tools.movers = [
            k
            for k, span in enumerate(drive.spans)
            if not span.fixed and span.obstacle_at(time) is not None
        ]
        if self._entered:
            self._show_world(drive)
            self._session.stage.show(moment)
        ground = Ground(drive.world.base, self._fixed_shapes(drive))
        self.history.add(moment, ground, drive.models, drive.planning)

    def _tell(self, drive: Drive | None) -> None:
        """Words, handles and plots."""
        if drive is not None and self._again and drive.phase == "ended":
            with self._session.lock:
                self._session.attempt(self._start)
            drive = self.drive
        if drive is not None:
            for text in drive.refused[self._refusals :]:
                self._session.say(f"A change could not happen any more: {text}", bad=True)
            self._refusals = len(drive.refused)
        missing = ""
        if drive is None and self._build.draft.scenario is None:
            missing = f"Nothing to drive yet: {self._build.draft.error}"
        self._transport.show(drive, missing)
        self._emergency.visible = self.is_live
        self._result.show(drive)
        if self._entered:
            self._tools.show(drive)
            self._plots.show(self.history)
