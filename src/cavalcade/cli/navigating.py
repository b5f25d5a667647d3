"""`cavalcade ros2 navigate`: a team's navigation until Ctrl-C."""

from __future__ import annotations

import logging
import signal
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cavalcade.cli import options

if TYPE_CHECKING:
    from cavalcade.fleet import LiveFleet
    from cavalcade.live.session import SessionFolder
    from cavalcade.live.team_file import Team

_WATCH = 0.2
"""How often is looked whether the node is up, s."""


def navigate(
    team: Annotated[
        str,
        typer.Argument(metavar="TEAM", help="A team's file, or a scenario's name or file."),
    ],
    wait: Annotated[
        bool, typer.Option("--wait", help="Leave the life cycle to a lifecycle manager.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Do everything, but command nobody.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Record there, as every run is recorded."),
    ] = None,
    force: options.Force = False,
    quiet: options.Quiet = False,
) -> None:
    """Drive a team on a ROS 2 graph to goals that come by topics, until Ctrl-C.

    The node is /team/navigator; goals come on /team/goal_pose, /team/goals and /ROBOT/goal_pose,
    shapes on /team/formation. Services /team/stop, reset_stop, pause, resume and cancel; what the
    team does is on /team/status, for people on /diagnostics and in RViz (cavalcade ros2 config).
    """
    from cavalcade.fleet.ros2 import load_rclpy

    load_rclpy()
    from cavalcade.jobs import warming
    from cavalcade.jobs.reporter import Reporter
    from cavalcade.live.planners import kernels_of
    from cavalcade.live.ros2_node import NavigationNode
    from cavalcade.live.session import SessionFolder
    from cavalcade.live.team_file import load_team

    def say(text: str) -> None:
        if not quiet:
            print(text, flush=True)

    loaded = load_team(team)
    loaded.first_map()
    folder = None if out is None else SessionFolder(loaded, out, force)
    with Reporter(quiet) as reporter:  # a minute after an installation, which is said
        warming.warm(kernels_of(loaded), reporter)
    logging.basicConfig(stream=sys.stderr, level=logging.ERROR, format="cavalcade: %(message)s")
    stop = threading.Event()
    ends = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP")]
    before = {name: signal.signal(name, lambda *_: stop.set()) for name in ends}
    try:
        record = None if folder is None else folder.begin
        fleet_of = partial(_fleet_of, dry_run=loaded.what_is_allowed(dry_run).dry_run)
        with NavigationNode(loaded, fleet_of, record=record, dry_run=dry_run, say=say) as node:
            if wait:
                say("/team/navigator waits to be configured and activated; Ctrl-C ends")
            else:
                _bring_up(node, stop)
            stop.wait()
        if folder is not None:
            folder.close()  # while signals are heard: nothing of the recording is lost
    finally:
        for name, handler in before.items():
            signal.signal(name, handler)
    say(f"{loaded.name}: ended; all robots were commanded to stop")
    if folder is not None:
        _finish(folder, say)


def config() -> None:
    """Print where the files for RViz and Foxglove are."""
    from cavalcade import live

    for file in sorted((Path(live.__file__).parent / "config").iterdir()):
        print(file)


def _finish(folder: SessionFolder, say: Callable[[str], None]) -> None:
    """Make the rest of the folder, unless Ctrl-C comes."""
    if folder.recording is None:
        return
    rest = f"cavalcade show {folder.out} makes the rest"
    try:
        say(
            f"writing figures and replay to {folder.out}; Ctrl-C leaves the recording only ({rest})"
        )
        done = folder.finish()
    except KeyboardInterrupt:
        say(f"{folder.out} has the recording only; {rest}")
        raise
    if done is not None:
        say("\n".join(map(str, done.files)))


def _bring_up(node: Any, stop: threading.Event) -> None:
    """Bring the node up beside the thread that hears signals."""
    found: list[BaseException] = []

    def work() -> None:
        try:
            node.bring_up()
        except BaseException as error:
            found.append(error)

    worker = threading.Thread(target=work, name="cavalcade-bring-up", daemon=True)
    worker.start()
    while worker.is_alive() and not stop.is_set():
        worker.join(_WATCH)
    if found:
        raise found[0]


def _fleet_of(team: Team, dry_run: bool) -> LiveFleet:
    """What a team is reached by, not yet started."""
    if team.fleet == "unitree":
        from cavalcade.live.go2 import Go2Team

        return Go2Team(team, dry_run)
    from cavalcade.fleet.ros2 import Ros2Fleet

    return Ros2Fleet(team.ros2_robots(), name="cavalcade_fleet", use_sim_time=team.use_sim_time)
