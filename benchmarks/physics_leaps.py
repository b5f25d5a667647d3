"""Leaps in physics by the strict criterion: standing ones, and those of body plans.

python benchmarks/physics_leaps.py [--robot go1] [--trials 30] [--first 1000] [--torque-speed]
    [--standing 0.3 0.4 0.45] [--steps 0.2 0.25 -0.1 -0.2] [--plans-gap 0.3 0.4]
    [--plans-step 0.2 0.25 -0.2]

Each trial has a seed: mass and friction vary by 5 %, and so do the start and, for plans, start and
goal. A standing robot starts 0 to 3 cm from where it leaps; one with a plan 0.4 m before its
approach, and walks. What is printed: successes, seconds from the hand-over to the give-back (mean),
and the reasons of failures. Nothing in the project is tuned to these seeds.
"""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

import numpy as np

from cavalcade.checking.heights import Heights
from cavalcade.checking.physics.floor import floor_of
from cavalcade.checking.physics.leaps import Leap, LeapVerdict, judge_leap
from cavalcade.checking.physics.record import RobotRecord, Touch
from cavalcade.execution.leaping import leaps_of, request_of
from cavalcade.fleet import LeapRequest
from cavalcade.fleet.mujoco import PhysicsGround, PhysicsSettings
from cavalcade.fleet.mujoco.fleet import MujocoFleet
from cavalcade.fleet.mujoco.leaping import APPROACH
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion import LeapSettings
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.terrain import generate_terrain

SIZE, MIDDLE, CELL = (7.0, 3.0), 3.5, 0.05
CYCLE, PATIENCE, AFTER = 0.05, 30.0, 1.6


class Place:
    """A gap or a step across the middle of a terrain."""

    def __init__(self, kind: str, amount: float) -> None:
        option = {"width": amount} if kind == "gap" else {"height": amount}
        self.terrain = generate_terrain(kind, SIZE, 0, resolution=CELL, **option)
        empty = np.zeros(self.terrain.height.shape, dtype=bool)
        self.ground = make_ground(OccupancyMap(empty, CELL), self.terrain)
        half = 0.5 * amount if kind == "gap" else 0.0
        self.near, self.far = MIDDLE - half, MIDDLE + half
        self.rise = amount if kind == "step" else 0.0


def fleet(place: Place, model: RobotModel, pose: Any, seed: int, limits: bool) -> MujocoFleet:
    """One robot of varied mass and friction."""
    return MujocoFleet(
        [model],
        [pose],
        ground=PhysicsGround.of_terrain(place.terrain),
        footing=place.ground,
        origin=place.terrain.origin,
        physics=PhysicsSettings(variation=0.05, seed=seed, torque_speed=limits),
        seed=seed,
    )


def carry_out(robots: MujocoFleet, request: LeapRequest, place: Place) -> tuple[LeapVerdict, float]:
    """Hand the robot over, wait, judge; also how long it took."""
    begun, back = robots.time, None
    robots.leap(0, request)
    while robots.time < begun + PATIENCE and (back is None or robots.time < back + AFTER):
        robots.send([[0.0, 0.0, 0.0]])
        robots.advance(CYCLE)
        if back is None and not robots.leaping[0]:
            back = robots.time
    took = (back or robots.time) - begun
    return judge_leap(
        record(robots),
        robots.simulator.descriptions[0],
        Leap((place.far, 0.5 * SIZE[1]), 0.0, 0.0, place.rise, begin=begun),
        floor_of(Heights(place.terrain.height, CELL), record(robots).base[:, :2]),
    ), took


def record(robots: MujocoFleet) -> RobotRecord:
    """What the fleet kept of its robot."""
    kept = robots.track()
    touches = tuple(Touch(touch.time, touch.part, touch.other) for touch in kept.contacts)
    return RobotRecord(
        0, kept.time, kept.base[:, 0], kept.joints[:, 0], kept.joint_rates[:, 0],
        kept.torques[:, 0], kept.foot_forces[:, 0], touches,
    )  # fmt: skip


def standing(place: Place, model: RobotModel, seed: int, limits: bool) -> tuple[LeapVerdict, float]:
    """From where it stands, or a step or two beside that."""
    rng = np.random.default_rng(seed)
    settings = LeapSettings()
    front = model.description.joint_offsets[0, 0, 0]  # type: ignore[union-attr]
    before = settings.before + 0.5 * CELL + settings.head * max(place.rise, 0.0)
    x = place.near - front - before - rng.uniform(0.0, 0.03)
    pose = np.array([x, 0.5 * SIZE[1] + rng.uniform(-0.3, 0.3), rng.uniform(-0.05, 0.05)])
    take_off = np.array([pose[0], pose[1], 0.28, 0.0])
    landed = np.array([place.far + 0.5, pose[1], 0.28 + place.rise, 0.0])
    robots = fleet(place, model, pose, seed, limits)
    request = LeapRequest(take_off, landed, (place.near - pose[0], place.far - pose[0]))
    return carry_out(robots, request, place)


def planned(place: Place, model: RobotModel, seed: int, limits: bool) -> tuple[LeapVerdict, float]:
    """Of a plan from one end of the terrain to the other, approach included."""
    rng = np.random.default_rng(seed)
    middle = 0.5 * SIZE[1]
    for _ in range(50):
        ends = [
            (x, middle + rng.uniform(-0.4, 0.4), rng.uniform(-0.3, 0.3))
            for x in (1.5, SIZE[0] - 1.5)
        ]
        path = plan_body(place.ground, model, *ends, seed=seed).trajectory
        leaps = [] if path is None else leaps_of(path)
        if path is not None and len(leaps) == 1:
            break
    else:
        raise SystemExit(f"no plan with one leap for seed {seed}")
    begin = max(float(path.time[leaps[0].take_off]) - APPROACH, 0.0)
    request = request_of(path, leaps[0], place.terrain)
    x, y, yaw = path.poses_at(np.array([begin]))[0]
    pose = (x - 0.4, y + rng.uniform(-0.05, 0.05), yaw + rng.uniform(-0.1, 0.1))
    robots = fleet(place, model, pose, seed, limits)
    for _ in range(16):
        robots.send([[0.5, 0.0, 0.0]])
        robots.advance(CYCLE)
    return carry_out(robots, request, place)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robot", default="go1")
    parser.add_argument("--trials", type=int, default=30)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first trial")
    parser.add_argument("--torque-speed", action="store_true")
    parser.add_argument(
        "--standing", type=float, nargs="*", default=[0.3, 0.4, 0.45], metavar="GAP"
    )
    parser.add_argument("--steps", type=float, nargs="*", default=[0.2, 0.25, -0.1, -0.2])
    parser.add_argument("--plans-gap", type=float, nargs="*", default=[0.3, 0.4])
    parser.add_argument("--plans-step", type=float, nargs="*", default=[0.2, 0.25, -0.2])
    options = parser.parse_args()
    model = robot_model(options.robot)
    for title, trial, kind, amounts in (
        ("standing", standing, "gap", options.standing),
        ("standing", standing, "step", options.steps),
        ("plan", planned, "gap", options.plans_gap),
        ("plan", planned, "step", options.plans_step),
    ):
        for amount in amounts:
            place = Place(kind, amount)
            seeds = range(options.first, options.first + options.trials)
            done = [trial(place, model, seed, options.torque_speed) for seed in seeds]
            good = sum(verdict.ok for verdict, _ in done)
            took = np.mean([seconds for _, seconds in done])
            whys = Counter(verdict.reason for verdict, _ in done if not verdict.ok)
            print(f"{title:8s} {kind:4s} {amount:5.2f} m: {good}/{len(done)}, {took:.1f} s", end="")
            print("".join(f"; {count} x {why}" for why, count in whys.most_common()), flush=True)


if __name__ == "__main__":
    main()
