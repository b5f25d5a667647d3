"""Robots that walk: leg control and rigid-body physics behind the interface of every fleet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco._postures import find_falls, planar_poses, planar_velocities
from cavalcade.fleet.mujoco.ground import PhysicsGround, movable_spans
from cavalcade.fleet.mujoco.leaping import APPROACH, Leapers
from cavalcade.fleet.mujoco.sampling import Sampler
from cavalcade.fleet.mujoco.sensing import Sensing, SensingErrors
from cavalcade.fleet.mujoco.settings import PhysicsSettings
from cavalcade.fleet.mujoco.simulator import TeamSimulator
from cavalcade.fleet.protocol import Fall, LeapRequest
from cavalcade.fleet.radio import CommandDelay, LocalisationNoise, RadioFleet
from cavalcade.geometry import Array
from cavalcade.lattice.ground import Ground
from cavalcade.locomotion.control import LegControl
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.recording.physics_track import FallEvent, PhysicsTrack
from cavalcade.robots.model import RobotModel
from cavalcade.scenario import ObstacleSpan, World

MOST_TILT = 1.0
"""A robot whose trunk has rolled or pitched by more has fallen, rad."""

LEAST_HEIGHT = 0.4
"""A robot whose trunk is lower has fallen; of its standing height."""

_CAUSES = ("", "tilt", "height")


class MujocoFleet(RadioFleet):
    """Robots on legs that follow body velocities as well as they can.

    Within `advance` leg control and physics take turns, 500 times a second. A robot that has got
    no command for 0.5 s stops and stands. Poses are those of the trunk, seen from above.

    Args:
        models: One model per robot, each with a description.
        poses: `(N, 3)` start poses x, y, yaw in the map frame, m and rad; the robots stand.
        ground: What they walk on and run into; level without end by default.
        footing: The same ground as legs' control knows it, and
        origin: the pose of its grid in the map.
        obstacles: Of `ground.movable`: where each of them is when, on the clock less its start.
        physics: Of the simulated world.
        noise: Errors of the reported poses.
        delay: Delay and loss of messages.
        sensing: Errors of the state that leg control works with.
        gait: How they walk.
        seed: Of the noise, the jitter and the losses.
        time: The clock at the start, s.

    Attributes:
        simulator, control: What it is made of.

    Raises:
        InputError: MuJoCo is missing, a robot has no description, the numbers of models and poses
            differ, or a pose is not finite.
    """

    def __init__(
        self,
        models: Sequence[RobotModel],
        poses: ArrayLike,
        *,
        ground: PhysicsGround | None = None,
        footing: Ground | None = None,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        obstacles: Sequence[ObstacleSpan] = (),
        physics: PhysicsSettings | None = None,
        noise: LocalisationNoise | None = None,
        delay: CommandDelay | None = None,
        sensing: SensingErrors | None = None,
        gait: GaitSettings | None = None,
        seed: int = 0,
        time: float = 0.0,
    ) -> None:
        self.simulator = TeamSimulator(models, poses, ground, physics)
        self.control = LegControl(models, footing, origin, gait)
        self._step = self.simulator.settings.step
        errors = sensing or SensingErrors()
        self._sensing = None if errors.none else Sensing(errors, self._step, seed)
        self._start = float(time)
        self._steps = 0
        standing = [robot.stand_height for robot in self.simulator.descriptions]
        self._lowest = LEAST_HEIGHT * np.array(standing)
        self._follow(obstacles)
        self._falls: dict[int, Fall] = {}
        self._judged = 0
        self._sampler = Sampler(self.simulator, self._start)
        # One time per robot; leg control takes that as well as one for all.
        self._heard: Any = np.full(len(models), self._start)
        super().__init__(self.true_poses(), self._start, noise, delay, seed)
        self.control.begin(self._time, self.simulator.qpos)
        terrain = self.simulator.ground.terrain
        fronts = [robot.joint_offsets[0, 0, 0] for robot in self.simulator.descriptions]
        heights = None if terrain is None else terrain.heights_at
        self._leapers = Leapers(self.control, np.array(fronts), heights)
        self._judge()
        # Let kernels be compiled before anybody's clock runs; this one is used up.
        control, simulator = LegControl(models, footing, origin, gait), self.simulator
        control.begin(self._time, simulator.qpos)
        control.step(self._time, simulator.qpos, simulator.qvel, simulator.foot_forces)

    @property
    def falls(self) -> tuple[Fall, ...]:
        """The first fall of each robot that fell, in order of time."""
        return tuple(self._falls.values())

    def true_poses(self) -> Array:
        """`(N, 3)` true poses of the trunks now, seen from above."""
        return planar_poses(self.simulator.qpos)

    def true_velocities(self) -> Array:
        """`(N, 3)` true velocities of the trunks now, map frame: m/s, m/s, rad/s."""
        return planar_velocities(self.simulator.qpos, self.simulator.qvel)

    @property
    def approach(self) -> float:
        """How long before a take-off, in planned time, robots are to be handed over, s."""
        return APPROACH

    @property
    def leaping(self) -> NDArray[np.bool_]:
        """`(N,)` which robots were handed over and have not been given back."""
        return self._leapers.leaping

    @property
    def leap_failed(self) -> NDArray[np.bool_]:
        """Whether the last leap of each robot `(N,)` failed."""
        return self._leapers.failed.copy()

    def leap(self, robot: int, request: LeapRequest) -> None:
        """Take a robot over: it walks to where it can leap from, leaps, and stands.

        Raises:
            InputError: No such robot, or one that is leaping.
        """
        self._leapers.take(robot, request)

    def track(self, start: float = 0.0) -> PhysicsTrack:
        """What happened so far, 50 times a second, in time since the clock showed `start` s."""
        falls = tuple(FallEvent(round(fall.time - start, 9), fall.robot) for fall in self.falls)
        return self._sampler.track(start, falls)

    def forget(self) -> None:
        """Let go of all that was kept of the past, for a fleet that goes on for hours."""
        self._sampler.forget()
        self._judged = 0

    def set_world(self, world: World) -> None:
        """Take over what has become of the obstacles of its ground: new ones, other ways.

        The run goes on as if all had been known from its start.
        """
        ground, known = PhysicsGround.of_world(world), self.simulator.ground
        if (ground.fixed, ground.movable) != (known.fixed, known.movable):
            self.simulator.set_ground(ground)
            self._sampler.follow()
        self._follow(movable_spans(world))

    def push(self, robot: int, force: ArrayLike, duration: float) -> None:
        """Push a trunk with the force `(3,)`, map frame, N, for so many seconds from now on."""
        self.simulator.push(robot, force, duration)

    def _move(self, start: float, dt: float) -> Array:
        """Leg control and physics in turns; physics is at most half a step of its own off."""
        until = round((self._time - self._start) / self._step)
        simulator, control, sensing = self.simulator, self.control, self._sensing
        while self._steps < until:
            now = self._start + self._steps * self._step
            self._deliver(now)
            state = simulator.qpos, simulator.qvel, simulator.foot_forces
            if sensing is not None:
                state = sensing.measured(state)
            if self._obstacles:
                self._place_obstacles(self._steps * self._step)
            if self._leapers.due(now):
                self._hear(self._leapers.steer(now, state[0]), now)
            # Motion that is no number any more is MuJoCo's to tell of, when it takes its step.
            sound = np.isfinite(state[1].sum())
            simulator.step(control.step(now, *state) if sound else np.zeros((len(state[1]), 12)))
            self._steps += 1
            if self._sampler.step():
                self._judge()
        return self.true_poses()

    def _follow(self, obstacles: Sequence[ObstacleSpan]) -> None:
        """These are the movable obstacles, and where they are when."""
        self._obstacles = tuple(obstacles)
        for number in range(len(self._obstacles)):
            self.simulator.place_obstacle(number, None)
        self._places: list[tuple[float, float] | None] = [None] * len(self._obstacles)
        self._place_obstacles(self._steps * self._step)

    def _hear(self, reached: NDArray[np.bool_], now: float) -> None:
        """Hand over what robots `reached` `(N,)` were told; the others' last command ages."""
        if reached.any():
            self._heard[reached] = now
            self.control.command(self._leapers.overrule(self._commands), self._heard)

    def _place_obstacles(self, time: float) -> None:
        """Move those obstacles that are elsewhere, or away, by `time` s."""
        for number, span in enumerate(self._obstacles):
            there = span.start <= time + 1e-9 and time + 1e-9 < span.end
            place = span.offset_at(time) if there else None
            if place != self._places[number]:
                self._places[number] = place
                self.simulator.place_obstacle(number, place)

    def _judge(self) -> None:
        """Look for falls in the newest sample; unstable physics shows no motion of robots."""
        trouble = self.simulator.trouble
        if trouble is not None:
            raise InputError(
                f"MuJoCo became unstable ({trouble}) by {self._sampler.time:.2f} s; expected "
                "gentler pushes and obstacles, or another model",
                key="physics",
            )
        qpos = self._sampler.qpos
        below = self.simulator.ground.heights_at(qpos[:, :2])
        found = find_falls(qpos, below, self._lowest, MOST_TILT)
        causes = {int(robot): _CAUSES[found[robot]] for robot in found.nonzero()[0]}
        for contact in self._sampler.contacts[self._judged :]:
            if contact.part == "trunk" and contact.other == "ground":
                causes.setdefault(contact.robot, "trunk")
        self._judged = len(self._sampler.contacts)
        for robot, cause in sorted(causes.items()):
            if robot not in self._falls:
                self._falls[robot] = Fall(self._sampler.time, robot, cause)
