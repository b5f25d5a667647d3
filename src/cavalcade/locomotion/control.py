"""Legs that carry out velocity commands: a team's controller, from measured states to torques."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.lattice.ground import Ground, check_ground, make_ground
from cavalcade.locomotion._team import step_team
from cavalcade.locomotion.leap import LeapManoeuvre, LeapSettings, plan_leap
from cavalcade.locomotion.parameters import robot_parameters
from cavalcade.locomotion.records import (
    FALLEN,
    LEAPING,
    LYING,
    RISING,
    SINKING,
    STANDING,
    STATE,
    TEAM,
    Footing,
)
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.robots import RobotModel
from cavalcade.values import (
    instance_of,
    instances_of,
    number_array,
    number_in,
    pose_of,
    whole_number,
)
from cavalcade.world import OccupancyMap


class LegControl:
    """Trots, stands and leaps by predictive control of the forces on the feet.

    Standing feet push the ground with forces that a convex programme finds 50 times a second over
    a horizon of 0.4 s (Di Carlo and others, "Dynamic locomotion in the MIT Cheetah 3 through convex
    model-predictive control", IROS 2018); feet in the air follow curves to footholds below the hips
    (Raibert, "Legged robots that balance", 1986).

    Args:
        models: One per robot; each with a `description`.
        ground: What feet stand on; None for flat ground without end.
        origin: Pose x, y, yaw of the ground's grid in the world, m and rad; the world's z is up.
        settings: Of the gait.

    Raises:
        InputError: A robot without a description of its legs or with legs of another kind, or an
            origin that is not three finite numbers.
    """

    def __init__(
        self,
        models: Sequence[RobotModel],
        ground: Ground | None = None,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        settings: GaitSettings | None = None,
    ) -> None:
        settings = GaitSettings() if settings is None else settings
        instance_of(settings, GaitSettings, "settings")
        models = instances_of(models, RobotModel, "models")
        self._team = np.zeros(len(models), TEAM)
        # Views of it.
        self._robots, self._gaits = self._team["robot"], self._team["gait"]
        self._states, self._leaps = self._team["state"], self._team["leap"]
        for number, model in enumerate(models):
            if model.description is None:
                text = f"there is no description of the legs of {model.name}"
                raise InputError(text, key=f"models[{number}]")
            self._robots[number] = robot_parameters(model.description)
            height = model.description.stand_height
            self._gaits[number] = settings.row(model.description.mass, height)
        try:
            origin = pose_of(origin, "origin")
        except InputError:
            raise InputError("expected finite x, y, yaw", key="origin") from None
        if ground is None:
            ground = make_ground(OccupancyMap(np.zeros((1, 1), dtype=bool), 1.0))
        check_ground(ground)
        self._footing = Footing.of(ground, origin)
        self._torques = np.zeros((len(models), 12))
        self._shapes = tuple((len(models), count) for count in (19, 18, 4))

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self._robots)

    @property
    def fallen(self) -> NDArray[np.bool_]:
        """Which robots `(N,)` have fallen and given up."""
        return np.asarray(self._states["mode"] == FALLEN)

    @property
    def modes(self) -> NDArray[np.int64]:
        """What each robot `(N,)` is doing: a mode of `records`, such as `STANDING`."""
        return np.asarray(self._states["mode"].copy())

    @property
    def standing(self) -> NDArray[np.bool_]:
        """Which robots `(N,)` stand still, ready to leap."""
        return np.asarray(self._states["mode"] == STANDING)

    @property
    def leaping(self) -> NDArray[np.bool_]:
        """Which robots `(N,)` are leaping."""
        return np.asarray(self._states["mode"] == LEAPING)

    @property
    def feet(self) -> Array:
        """Where the feet's centres stood last, `(N, 4, 3)` in the world, m."""
        return np.asarray(self._states["stood"].copy())

    def begin(self, time: float, qpos: Array, standing: bool = True) -> None:
        """Take the robots as they are at `time` s, and forget all before.

        They are at `qpos` `(N, 19)`, as MuJoCo has them, standing on their feet; otherwise they
        lie, and `rise` gets them up.
        """
        time = number_in(time, "time", -1e12, 1e12, "s")
        instance_of(standing, bool, "standing", "True or False")
        qpos = number_array(qpos, "qpos", self._shapes[0], f"{self._shapes[0]} numbers")
        self._states[:] = np.zeros((), STATE)
        self._states["time"] = self._states["began"] = time
        self._states["heard"] = self._states["idle"] = time
        self._states["mode"] = RISING if standing else LYING
        self._states["fold"] = qpos[:, 7:]
        if standing:
            # Nothing is left to rise: after the first step they stand.
            self._states["began"] = -np.inf

    def command(self, velocities: ArrayLike, time: ArrayLike) -> None:
        """Velocities `(N, 3)` to follow from now on, body frame, m/s, m/s, rad/s.

        They fall silent `GaitSettings.silence` s after `time` (s; one, or one per robot); send them
        again before.
        """
        what = f"finite velocities of shape ({self.size}, 3)"
        wanted = number_array(velocities, "velocities", (self.size, 3), what)
        if isinstance(time, (int, float, np.number, str)):
            heard: float | Array = number_in(time, "time", -1e12, 1e12, "s")
        else:
            heard = number_array(
                time, "time", (self.size,), "one time in s, or one per robot", 1e12
            )
        self._states["wanted"] = wanted
        self._states["heard"] = heard

    def rise(self, robot: int, qpos: Array) -> None:
        """Let a robot that lies get up, where its joints `qpos[robot, 7:]` are now; 1 s.

        Raises:
            InputError: There is no such robot, or it does not lie.
        """
        self._posture(robot, qpos, RISING)

    def lie_down(self, robot: int, qpos: Array) -> None:
        """Let a robot that stands lie down; 1 s. It ignores commands until it has risen.

        Raises:
            InputError: There is no such robot, or it does not stand.
        """
        self._posture(robot, qpos, SINKING)

    def leap(
        self, robot: int, manoeuvre: LeapManoeuvre, settings: LeapSettings | None = None
    ) -> None:
        """Let a robot that stands leap; it stands again when it has landed.

        Raises:
            InputError: The robot does not stand, or the leap is too far or too high.
        """
        state = self._states[robot]
        if state["mode"] != STANDING:
            raise InputError(f"robot {robot} must stand before it leaps")
        self._leaps[robot] = plan_leap(
            manoeuvre,
            self._robots[robot],
            float(self._gaits[robot]["height"]),
            state["stood"],
            float(state["yaw"]),
            settings or LeapSettings(),
        )
        state["mode"], state["solved"] = LEAPING, -np.inf

    @property
    def leap_failed(self) -> NDArray[np.bool_]:
        """Whether the last leap of each robot `(N,)` failed."""
        return np.asarray(self._leaps["failed"] == 1)

    def step(self, time: float, qpos: Array, qvel: Array, feet: Array) -> Array:
        """Torques `(N, 12)` for the state now; the array is overwritten by the next call.

        Args:
            time: s.
            qpos, qvel: `(N, 19)`, `(N, 18)` as MuJoCo has them.
            feet: `(N, 4)` normal forces on the feet, N.

        Raises:
            InputError: Arrays of other shapes.
        """
        for value, shape in zip((qpos, qvel, feet), self._shapes, strict=True):
            if type(value) is not np.ndarray or value.dtype != float or value.shape != shape:
                shapes = "{}, {}, {}".format(*self._shapes)
                raise InputError(f"expected qpos, qvel, feet of shapes {shapes}, of floats")
            if not value.flags.c_contiguous or not (np.abs(value) <= 1e9).all():
                raise InputError("expected qpos, qvel and feet to be finite and contiguous")
        time = number_in(time, "time", -1e12, 1e12, "s")
        step_team(self._team, self._footing, time, qpos, qvel, feet, self._torques)
        return self._torques

    def _posture(self, robot: int, qpos: Array, mode: int) -> None:
        if not 0 <= whole_number(robot, "robot") < self.size:
            raise InputError(f"expected a robot from 0 to {self.size - 1}", key="robot")
        qpos = number_array(qpos, "qpos", self._shapes[0], f"{self._shapes[0]} numbers")
        state = self._states[robot]
        if mode == SINKING and state["mode"] != STANDING:
            raise InputError(f"robot {robot} must stand before it lies down")
        if mode == RISING and state["mode"] != LYING:
            raise InputError(f"robot {robot} does not lie")
        state["mode"], state["began"], state["fold"] = mode, state["time"], qpos[robot, 7:]
