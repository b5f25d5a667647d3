"""`cavalcade ros2 ...`: what needs a ROS 2 graph."""

from __future__ import annotations

import signal
import threading
from typing import Annotated

import typer

from cavalcade.cli import navigating, options
from cavalcade.errors import InputError

app = typer.Typer(
    name="ros2",
    help="Robots on a ROS 2 graph, simulated or real.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command()
def simulate(
    scenario: options.ScenarioArgument,
    seed: options.Seed = None,
    overrides: options.Set = None,
    backend: Annotated[
        str | None,
        typer.Option("--backend", metavar="NAME", help="What moves the robots: ideal or mujoco."),
    ] = None,
    speed: Annotated[
        float, typer.Option(metavar="F", help="Times real time; where it is slower, that is said.")
    ] = 1.0,
    stamped: Annotated[
        bool, typer.Option("--stamped", help="Commands are TwistStamped instead of Twist.")
    ] = False,
    quiet: options.Quiet = False,
) -> None:
    """The robots of a scenario as a ROS 2 graph in real time, until Ctrl-C.

    They are /robot_0, /robot_1 and so on: they listen to cmd_vel and publish pose, odom,
    joint_states and scan; /clock and /map are there, too. A robot that hears nothing for 0.5 s
    stops.
    """
    if not 0.01 <= speed <= 100.0:
        raise InputError("expected 0.01 to 100", key="--speed")
    from cavalcade.fleet.ros2 import load_rclpy

    load_rclpy()
    loaded = options.load(scenario, overrides, seed, backend)
    from cavalcade.live.simulation import Simulation
    from cavalcade.live.simulation_graph import SimulationGraph

    def say(text: str) -> None:
        if not quiet:
            print(text, flush=True)

    if loaded.execution.events:
        say("the scenario's events are left out")
    graph = SimulationGraph(Simulation(loaded), stamped=stamped, say=say)
    # Until here SIGTERM ends a process that may compile for long.
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    try:
        names = ", ".join(robot.namespace for robot in graph.robots)
        say(f"{loaded.name}: {names}; Ctrl-C ends")
        graph.run(stop, speed)
    finally:
        graph.close()


app.command()(navigating.navigate)
app.command()(navigating.config)
