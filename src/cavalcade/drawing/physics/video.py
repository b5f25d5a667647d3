"""A video of a run in physics, drawn off-screen by MuJoCo: an extra that the replay needs not."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.drawing.physics.signals import descriptions_of
from cavalcade.errors import InputError
from cavalcade.files import replacing
from cavalcade.geometry import Array
from cavalcade.recording.physics_track import PhysicsTrack

if TYPE_CHECKING:
    from cavalcade.fleet.mujoco.simulator import TeamSimulator
    from cavalcade.scenario import Scenario, World

SUFFIXES = (".webp", ".gif")
"""Kinds of files, all of them animated pictures."""

_LIGHT = 0.42
"""Shapes of the trunk brighter than this get the robot's colour."""


def render_video(
    scenario: Scenario,
    world: World,
    track: PhysicsTrack,
    path: str | Path,
    *,
    rate: float = 20.0,
    size: tuple[int, int] = (960, 540),
) -> Path:
    """Draw a track off-screen, the camera going with the team, as an animated picture.

    The world is that of the start, the path's ending says the kind of file: .webp (small) or .gif;
    `rate` is pictures a second, `size` width and height in pixels.

    Raises:
        InputError: MuJoCo is missing, nothing here can draw off-screen, or the file's kind, the
            rate or the size cannot be used.
        OutputError: It cannot be written.
        RecordingError: The track is empty, or not that of the scenario's robots.
    """
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise InputError(f"cannot write {target.name}", key="path", choices=SUFFIXES)
    if not 0.0 < rate <= 100.0:
        raise InputError("expected more than 0 and at most 100 pictures a second", key="rate")
    if min(size) < 16 or max(size) > 4096:
        raise InputError("expected 16 to 4096 pixels", key="size")
    descriptions_of(scenario, track)
    frames = _frames(scenario, world, track, rate, size)
    _write(frames, target, rate)
    return target


def _frames(
    scenario: Scenario, world: World, track: PhysicsTrack, rate: float, size: tuple[int, int]
) -> Iterator[NDArray[np.uint8]]:
    if "mujoco" not in sys.modules and not os.environ.get("DISPLAY"):
        # Read once, when MuJoCo is loaded; without a screen there is nothing else to draw with.
        os.environ.setdefault("MUJOCO_GL", "egl")
    from cavalcade.fleet.mujoco.engine import load_mujoco
    from cavalcade.fleet.mujoco.ground import PhysicsGround, movable_spans
    from cavalcade.fleet.mujoco.settings import PhysicsSettings
    from cavalcade.fleet.mujoco.simulator import TeamSimulator

    mujoco = load_mujoco()
    ground = PhysicsGround.of_world(world)
    simulator = TeamSimulator(
        scenario.models, scenario.starts, ground, replace(PhysicsSettings(), looks=True)
    )
    _paint(simulator)
    model, data = simulator.model, simulator.data
    model.vis.global_.offwidth, model.vis.global_.offheight = size
    # What draws off-screen fails in as many ways as there are drivers.
    try:
        renderer = mujoco.Renderer(model, size[1], size[0])
    except Exception as error:
        raise InputError(
            "cannot draw off-screen here: install EGL or OSMesa and set MUJOCO_GL=egl or osmesa "
            f"before the start ({type(error).__name__})",
            key="video",
        ) from None
    obstacles = movable_spans(world)
    camera = mujoco.MjvCamera()
    times = np.arange(track.time[0], track.time[-1] + 1e-9, 1.0 / rate)
    with renderer:
        for row in np.searchsorted(track.time, times - 1e-9):
            place = np.concatenate([track.base[row], track.joints[row]], axis=1)
            data.qpos[simulator.team.qpos] = place
            for number, span in enumerate(obstacles):
                now = float(track.time[row])
                there = span.start <= now < span.end
                simulator.place_obstacle(number, span.offset_at(now) if there else None)
            mujoco.mj_forward(model, data)
            _aim(camera, place[:, :3])
            renderer.update_scene(data, camera)
            yield renderer.render().copy()


def _paint(simulator: TeamSimulator) -> None:
    """Give each trunk its robot's colour, hide the shapes that only touch, and let there be light.

    The team's model has no lamp: physics needs none.
    """
    from matplotlib.colors import to_rgb

    model, team = simulator.model, simulator.team
    model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.55, 0.5
    model.geom_rgba[team.geom_robot < 0, :3] += 0.25
    for geom in range(model.ngeom):
        robot = int(team.geom_robot[geom])
        if robot < 0:
            continue
        if model.geom_group[geom] != 2:
            model.geom_rgba[geom, 3] = 0.0
        elif team.geom_leg[geom] < 0 and model.geom_rgba[geom, :3].mean() > _LIGHT:
            model.geom_rgba[geom, :3] = to_rgb(style.robot_color(robot))


def _aim(camera: Any, places: Array) -> None:
    """Look at the middle of the team from so far that all of it is seen."""
    middle = places.mean(axis=0)
    spread = float(np.linalg.norm(places[:, :2] - middle[:2], axis=1).max())
    camera.lookat[:] = middle
    camera.distance = 1.8 + 2.2 * spread
    camera.azimuth, camera.elevation = 60.0, -32.0


def _write(frames: Iterator[NDArray[np.uint8]], target: Path, rate: float) -> None:
    from PIL import Image

    pictures = (Image.fromarray(frame) for frame in frames)
    kind = target.suffix.lower()[1:]
    options: dict[str, Any] = {"quality": 80, "method": 2} if kind == "webp" else {}
    with replacing(target) as temporary:
        first = next(pictures)
        first.save(
            temporary,
            format=kind,
            save_all=True,
            append_images=pictures,
            duration=round(1000.0 / rate),
            loop=0,
            **options,
        )
