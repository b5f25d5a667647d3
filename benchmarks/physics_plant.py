"""What legs make of velocity commands in physics: steady speeds, steps, stops, sway, time.

Prints Markdown tables. Velocities are the trunk's, in its own frame seen from above; "ideal" is
the straight ramp of the gait's settings (`GaitSettings.acceleration`, `turning`).

    python benchmarks/physics_plant.py [--robot go1] [--seconds 6]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.fleet.mujoco import TeamSimulator
from cavalcade.locomotion import GaitSettings, LegControl
from cavalcade.robots import robot_model
from cavalcade.robots.motion import ellipse_scale, limits_of, predict_team

Array = NDArray[np.float64]
Command = tuple[float, float, float]

STEP, COMMAND_EVERY = 0.002, 25  # s; steps
GAIT = GaitSettings()
CYCLE = round(GAIT.period / STEP)
STILL: Command = (0.0, 0.0, 0.0)
STEADY: tuple[Command, ...] = (
    (0.2, 0, 0), (0.3, 0, 0), (0.5, 0, 0), (0.8, 0, 0), (1.2, 0, 0), (-0.5, 0, 0), (-0.8, 0, 0),
    (0, 0.2, 0), (0, 0.4, 0), (0, 0, 1.0), (0, 0, 2.0), (0.5, 0.2, 1.0), (0.8, 0.3, 1.0),
)  # fmt: skip
STEPS: tuple[Command, ...] = (
    (0.3, 0, 0), (0.5, 0, 0), (0.8, 0, 0), (1.2, 0, 0), (-0.5, 0, 0), (0, 0.2, 0), (0, 0.4, 0),
    (0, 0, 1.0), (0, 0, 2.0),
)  # fmt: skip


class Motion(NamedTuple):
    """Pose `(T, 3)` and body velocity `(T, 3)` of a trunk at every step, and its height `(T,)`."""

    pose: Array
    velocity: Array
    height: Array
    fallen: bool


class Robots:
    """Robots side by side on level ground."""

    def __init__(self, name: str, count: int = 1) -> None:
        models = [robot_model(name)] * count
        poses = [(0.0, 1.5 * k, 0.0) for k in range(count)]
        self.simulator = TeamSimulator(models, poses)
        self.control = LegControl(models, settings=GAIT)
        self.control.begin(0.0, self.simulator.qpos)

    def drive(self, command: Command, seconds: float) -> Motion:
        """Let the robots obey; the motion of the first."""
        simulator, control = self.simulator, self.control
        commands = np.tile(np.array(command, dtype=float), (control.size, 1))
        states = []
        for k in range(round(seconds / STEP)):
            if k % COMMAND_EVERY == 0:
                control.command(commands, simulator.time)
            state = simulator.qpos, simulator.qvel, simulator.foot_forces
            states.append(np.append(state[0][0, :7], state[1][0, :6]))
            simulator.step(control.step(simulator.time, *state))
        seen = np.array(states)
        w, x, y, z = seen[:, 3:7].T
        yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        c, s, (vx, vy) = np.cos(yaw), np.sin(yaw), seen[:, 7:9].T
        velocity = np.column_stack([c * vx + s * vy, c * vy - s * vx, seen[:, 12]])
        pose = np.column_stack([seen[:, :2], yaw])
        return Motion(pose, velocity, seen[:, 2], bool(control.fallen.any()))


def text(command: Command) -> str:
    return ", ".join(f"{value:g}" for value in command)


def over_cycles(values: Array) -> Array:
    """Means over one cycle of the gait, along the first axis."""
    sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    return (sums[CYCLE:] - sums[:-CYCLE]) / CYCLE


def sway(motion: Motion) -> Array:
    """`(3,)` largest distance from the mean over a cycle: along, across, yaw."""
    middle = slice(CYCLE // 2, CYCLE // 2 + len(motion.pose) - CYCLE + 1)
    off = motion.pose[middle] - over_cycles(motion.pose)
    yaw = motion.pose[middle, 2]
    c, s = np.cos(yaw), np.sin(yaw)
    along, across = c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]
    return np.abs(np.column_stack([along, across, off[:, 2]])).max(axis=0)


def steady(name: str, seconds: float) -> None:
    print(
        "\n| commanded m/s, m/s, rad/s | mean | error | RMS error | sway mm, mm, rad | height m |"
    )
    print("|---|---|---|---|---|---|")
    for command in STEADY:
        robots = Robots(name)
        robots.drive(command, 2.5)
        motion = robots.drive(command, math.ceil(seconds / GAIT.period) * GAIT.period)
        mean, wanted = motion.velocity.mean(axis=0), np.array(command)
        asked = wanted != 0.0
        error = np.max(np.abs(mean - wanted)[asked] / np.abs(wanted[asked]))
        rms = np.sqrt(((motion.velocity - wanted) ** 2).mean(axis=0))
        along, across, yaw = sway(motion)
        print(
            f"| {text(command)} | {mean[0]:z.3f}, {mean[1]:z.3f}, {mean[2]:z.3f}"
            f" | {100 * error:.1f} % | {rms[0]:.3f}, {rms[1]:.3f}, {rms[2]:.3f}"
            f" | {1e3 * along:.0f}, {1e3 * across:.0f}, {yaw:.3f}"
            f" | {motion.height.mean():.3f}{' fallen' if motion.fallen else ''} |",
            flush=True,
        )


def first(reached: NDArray[np.bool_]) -> float:
    """Seconds until the first True; NaN without."""
    return int(np.argmax(reached)) * STEP if reached.any() else math.nan


def steps(name: str) -> None:
    """From rest to a command and back; the ideal ramp is averaged over cycles as well."""
    print(
        "\n| commanded from rest | 63 % (ideal) s | 95 % (ideal) s | largest mean over a cycle"
        " | stops in (ideal) | slower than 5 % (ideal) s |"
    )
    print("|---|---|---|---|---|---|")
    for command in STEPS:
        robots = Robots(name)
        robots.drive(STILL, 0.5)
        # Half a cycle before the command, so that means are centred on their time.
        lead = robots.drive(STILL, CYCLE / 2 * STEP)
        up = robots.drive(command, 3.0)
        down = robots.drive(STILL, 3.0)
        axis = int(np.flatnonzero(command)[0])
        goal, limit = command[axis], GAIT.turning if axis == 2 else GAIT.acceleration
        rise = np.concatenate([lead.velocity, up.velocity])[:, axis] / goal
        fall = np.concatenate([up.velocity[-CYCLE // 2 :], down.velocity])[:, axis] / goal
        ramp = np.clip((np.arange(len(rise)) - CYCLE // 2) * STEP * limit / abs(goal), 0.0, 1.0)
        rise, fall, ramp = over_cycles(rise), over_cycles(fall), over_cycles(ramp)
        cells = [
            f"{first(rise >= share):.2f} ({first(ramp >= share):.2f})" for share in (0.63, 0.95)
        ]
        moved = down.pose[-1] - down.pose[0]
        gone = abs(moved[2]) if axis == 2 else math.hypot(*moved[:2])
        cells += [
            f"{100 * rise.max():.0f} %",
            f"{gone:.3f} ({goal**2 / 2 / limit:.3f}) {'rad' if axis == 2 else 'm'}",
            f"{first(fall <= 0.05):.2f} ({first(1.0 - ramp <= 0.05):.2f})",
        ]
        fallen = " fallen" if up.fallen or down.fallen else ""
        print(f"| {text(command)} | {' | '.join(cells)}{fallen} |", flush=True)


def foreseen(name: str) -> None:
    """How far robots are from where the planners' motion model sees them under random commands.

    The model starts from a pose and the velocity since the pose before, as planners know them.
    """
    model = robot_model(name)
    limits, period = limits_of(model), COMMAND_EVERY * STEP
    errors: dict[int, list[Array]] = {6: [], 12: []}
    for seed in range(6):
        random = np.random.default_rng(seed)
        robots = Robots(name)
        pose, command = robots.drive(STILL, 0.3).pose[-1], np.zeros(3)
        poses, commands = [pose], []
        for k in range(400):
            if k % 12 == 0:
                command = random.uniform(-1.0, 1.0, 3) * (model.max_speed_x, model.max_speed_y, 1.0)
                command[:2] *= ellipse_scale(*command[:2], model.max_speed_x, model.max_speed_y)
            commands.append(command)
            x, y, yaw = command
            pose = robots.drive((x, y, yaw), period).pose[-1]
            pose[2] = np.unwrap((poses[-1][2], pose[2]))[1]
            poses.append(pose)
        for ahead, found in errors.items():
            for k in range(20, 380):
                place, speed = poses[k][None], ((poses[k] - poses[k - 1]) / period)[None]
                for command in commands[k : k + ahead]:
                    state = predict_team(place, speed, command[None], period / 4, 4, limits)
                    place, speed = state[:, :3].copy(), state[:, 3:].copy()
                found.append(place[0] - poses[k + ahead])
    print("\n| foreseen for | RMS per axis m, rad | 99 of 100 within m, rad | largest m, rad |")
    print("|---|---|---|---|")
    for ahead, found in errors.items():
        error = np.array(found)
        off, turn = np.hypot(error[:, 0], error[:, 1]), np.abs(error[:, 2])
        rms = math.sqrt(float((off**2).mean()) / 2.0), math.sqrt(float((turn**2).mean()))
        print(
            f"| {ahead * period:.1f} s | {rms[0]:.4f}, {rms[1]:.4f}"
            f" | {np.quantile(off, 0.99):.3f}, {np.quantile(turn, 0.99):.3f}"
            f" | {off.max():.3f}, {turn.max():.3f} |",
            flush=True,
        )


def speed(name: str) -> None:
    """The best of many short times: others may keep the machine busy."""
    print("\n| robots | real-time factor, control included |")
    print("|---|---|")
    for count in (1, 4):
        robots = Robots(name, count)
        robots.drive((0.4, 0.0, 0.2), 1.0)
        simulator, commands, best = robots.simulator, np.tile((0.4, 0.0, 0.2), (count, 1)), 0.0
        for _ in range(30):
            began = time.perf_counter()
            for k in range(2 * CYCLE):
                if k % COMMAND_EVERY == 0:
                    robots.control.command(commands, simulator.time)
                state = simulator.qpos, simulator.qvel, simulator.foot_forces
                simulator.step(robots.control.step(simulator.time, *state))
            best = max(best, 2 * CYCLE * STEP / (time.perf_counter() - began))
        print(f"| {count} | {best:.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robot", default="go1", help="its model")
    parser.add_argument("--seconds", type=float, default=6.0, help="of steady walking")
    options = parser.parse_args()
    print(f"{options.robot} on level ground, friction 0.8, one thread.")
    steady(options.robot, options.seconds)
    steps(options.robot)
    foreseen(options.robot)
    speed(options.robot)


if __name__ == "__main__":
    main()
