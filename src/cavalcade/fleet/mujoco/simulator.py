"""A team of quadrupeds in one world: torques in, state out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cavalcade.errors import InputError
from cavalcade.fleet.mujoco._step import MOTOR, limit_torques
from cavalcade.fleet.mujoco.engine import load_mujoco
from cavalcade.fleet.mujoco.ground import PhysicsGround
from cavalcade.fleet.mujoco.ground_spec import AWAY
from cavalcade.fleet.mujoco.settings import PhysicsSettings
from cavalcade.fleet.mujoco.world_spec import build_team
from cavalcade.fleet.radio import start_poses
from cavalcade.geometry import Array, transform_points
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.robots.model import RobotModel


class TeamSimulator:
    """Robots that stand, walk or fall as their joints' torques and the contacts make them.

    The robots start standing at the poses, their feet on the ground.

    Args:
        models: One per robot, each with a description.
        poses: `(N, 3)` x, y, yaw in the map frame, m and rad.
        ground: What they walk on; level without end by default.
        settings: Of the physics.

    Attributes:
        team: The compiled model and the places of the robots' things in it.
        model, data: MuJoCo's `MjModel` and `MjData`, for reading.

    Raises:
        InputError: MuJoCo is missing, a robot has no description, poses of another shape or not
            finite, or settings for another number of robots.
    """

    def __init__(
        self,
        models: Sequence[RobotModel],
        poses: ArrayLike,
        ground: PhysicsGround | None = None,
        settings: PhysicsSettings | None = None,
    ) -> None:
        start = start_poses(poses, len(models))
        mujoco = load_mujoco()
        self.ground = ground or PhysicsGround()
        self.settings = settings or PhysicsSettings()
        self.descriptions = tuple(map(_description, models))
        self._advance = mujoco.mj_step
        self._build()
        self._motors = np.zeros((self.size, 12), MOTOR)
        for robot, description in enumerate(self.descriptions):
            for motor, joint in zip(self._motors[robot], description.joints, strict=True):
                motor["limit"], motor["stall"] = joint.torque, joint.stall_torque
                motor["no_load"] = joint.no_load_speed
        self._motors["rate"], self._motors["place"] = self.team.qvel[:, 6:], self.team.motors
        self._given = np.zeros((self.size, 12))
        self._pushes: list[tuple[int, int, Array]] = []
        self._steps = 0
        self._qpos[self.team.qpos] = [
            _standing(robot, pose, self.ground)
            for robot, pose in zip(self.descriptions, start, strict=True)
        ]
        mujoco.mj_forward(self.model, self.data)

    def set_ground(self, ground: PhysicsGround) -> None:
        """Let other obstacles stand on the same ground; robots go on as they are.

        All movable obstacles are away at first.
        """
        before = self.data
        self.ground = ground
        self._build()
        # Robots have the same places in both; what MuJoCo derives it derives anew in its next
        # step, but sensors are read before, and solutions begin with the last one.
        for name in ("qpos", "qvel", "ctrl", "qacc_warmstart", "sensordata"):
            getattr(self.data, name)[:] = getattr(before, name)
        self.data.time = before.time
        self.data.warning.number[:] = before.warning.number

    def _build(self) -> None:
        """Compile robots and ground."""
        self.team = build_team(self.descriptions, self.ground, self.settings)
        self.model: Any = self.team.model
        self.data: Any = load_mujoco().MjData(self.model)
        # Views of the data's own memory, which stays where it is.
        self._qpos, self._qvel, self._ctrl = self.data.qpos, self.data.qvel, self.data.ctrl
        self._sensors, self._external = self.data.sensordata, self.data.xfrc_applied

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.descriptions)

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self._steps * self.settings.step

    @property
    def qpos(self) -> Array:
        """`(N, 19)` position (m, map), quaternion w, x, y, z, joint angles (rad); a copy."""
        return self._qpos[self.team.qpos]

    @property
    def qvel(self) -> Array:
        """`(N, 18)` velocity (m/s, map), rates (rad/s, body), joint rates (rad/s); a copy."""
        return self._qvel[self.team.qvel]

    @property
    def foot_forces(self) -> Array:
        """`(N, 4)` normal forces on the feet during the last step, N; a copy."""
        return self._sensors[self.team.touch]

    @property
    def torques(self) -> Array:
        """`(N, 12)` that the motors gave during the last step, N m; a copy."""
        return self._given.copy()

    @property
    def trouble(self) -> str | None:
        """What MuJoCo has warned of, as it calls it, such as `BADQACC`; None while all is well.

        After some of these warnings it puts all robots back to where its model has them.
        """
        warned = np.flatnonzero(self.data.warning.number)
        if not len(warned):
            return None
        return str(load_mujoco().mjtWarning(int(warned[0])).name).removeprefix("mjWARN_")

    def step(self, torques: ArrayLike) -> None:
        """Let one physics step pass under the torques `(N, 12)`, N m, cut to the limits.

        Raises:
            InputError: Torques of another shape.
        """
        wanted = np.ascontiguousarray(torques, dtype=np.float64)
        if wanted.shape != self._given.shape:
            raise InputError(f"expected torques of shape {self._given.shape}", key="torques")
        speed = self.settings.torque_speed
        limit_torques(wanted, self._motors, speed, self._qvel, self._given, self._ctrl)
        if self._pushes:
            self._external[self.team.trunks, :3] = 0.0
            self._pushes = [push for push in self._pushes if push[0] > self._steps]
            for _, robot, vector in self._pushes:
                self._external[self.team.trunks[robot], :3] += vector
        self._advance(self.model, self.data)
        self._steps += 1

    def push(self, robot: int, force: ArrayLike, duration: float) -> None:
        """Push a trunk at its centre of mass from now on.

        Args:
            robot: Which.
            force: `(3,)` in the map frame, N.
            duration: s; rounded to whole steps, at least one, and the force with it, so that the
                impulse stays.

        Raises:
            InputError: No such robot, a force of another shape, or something not finite.
        """
        vector = np.array(force, dtype=float)
        if not 0 <= robot < self.size:
            raise InputError(f"expected a robot from 0 to {self.size - 1}", key="robot")
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise InputError("expected three finite numbers", key="force")
        if not (math.isfinite(duration) and duration > 0.0):
            raise InputError("expected positive seconds", key="duration")
        wanted = duration / self.settings.step
        steps = max(1, round(wanted))
        self._pushes.append((self._steps + steps, robot, vector * (wanted / steps)))

    def place_obstacle(self, number: int, offset: tuple[float, float] | None) -> None:
        """Put a movable obstacle of the ground somewhere; all are away at first.

        Args:
            number: Index in `ground.movable`.
            offset: x, y from its first place, m; None takes it away.

        Raises:
            InputError: No such obstacle, or an offset that is not finite.
        """
        if not 0 <= number < len(self.team.obstacles):
            raise InputError(
                f"no such obstacle; there are {len(self.team.obstacles)} movable ones", key="number"
            )
        place = AWAY if offset is None else (*offset, 0.0)
        if not np.isfinite(place).all():
            raise InputError("expected finite metres", key="offset")
        self.data.mocap_pos[self.team.obstacles[number]] = place

    def state_bytes(self) -> bytes:
        """Time, positions and velocities to the last bit, to compare runs."""
        return np.float64(self.time).tobytes() + self.qpos.tobytes() + self.qvel.tobytes()


def _description(model: RobotModel) -> QuadrupedDescription:
    if model.description is None:
        raise InputError(
            f"{model.name} has no description of masses and joints for physics", key="model"
        )
    return model.description


def _standing(robot: QuadrupedDescription, pose: Array, ground: PhysicsGround) -> Array:
    """Generalised positions `(19,)` of a robot that stands level with its feet on the ground.

    A foot stands below its thigh's joint; the trunk is as high over the mean of the four as the
    description says, or lower where a leg would not reach. `pose` is x, y, yaw in the map frame.
    """
    offsets = robot.joint_offsets
    places = transform_points(pose, offsets[:, 0, :2] + offsets[:, 1, :2])
    heights = ground.heights_at(places)
    trunk = min(float(heights.mean()), float(heights.min()) + 0.08) + robot.stand_height
    angles = [
        angle
        for leg in range(4)
        for angle in robot.leg_angles(leg, trunk - float(heights[leg]) - robot.foot_radius)
    ]
    half = pose[2] / 2.0
    return np.array([pose[0], pose[1], trunk, np.cos(half), 0.0, 0.0, np.sin(half), *angles])
