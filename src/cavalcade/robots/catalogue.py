"""The robot models there are, with the sources of their figures; models of one's own in files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, fields, replace
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.robots.description import QuadrupedDescription
from cavalcade.robots.model import Drive, LegModel, RobotModel, check_model
from cavalcade.robots.unitree import GO1_BODY, GO2_BODY
from cavalcade.values import described, did_you_mean, instance_of, is_missing

_PAPER = "Norén et al., Role-Adaptive Collaborative Formation Planning"
_TRACKING_ERROR = 0.03
"""Of Go1 and Go2, m: of 100 positions 99 are foreseen to 0.026 m for 0.3 s and to 0.037 m for 0.6 s
(`benchmarks/physics_plant.py`)."""

SPIRIT = LegModel(
    h_min=0.075,
    h_nom=0.30,
    h_max=0.375,
    v_nom=0.75,
    v_max=2.0,
    yaw_rate=1.2,
    acceleration=1.0,
    trunk_length=0.3,
    trunk_width=0.3,
    trunk_height=0.05,
    hip_x=0.2263,
    hip_y=0.07,
    mass=13.0,
    mu=0.25,
    grf_max=5.0,
    gait_period=0.36,
    duty=0.5,
    swing_height=0.07,
    source="Quad-SDK: its global body planner's parameters and its description of Spirit 40; "
    "yaw rate and acceleration as for formations",
)
GO1 = replace(
    SPIRIT,
    h_nom=0.25,
    hip_x=0.1881,
    hip_y=0.04675,
    mass=12.0,
    source="Unitree's description of Go1: hips; Quad-SDK's parameters for Go1: nominal height, "
    "mass; the rest as for Spirit, the gait too: it is the one that leg control walks with",
)
GO2 = replace(
    SPIRIT,
    h_nom=0.26,
    hip_x=0.1934,
    hip_y=0.0465,
    mass=15.0,
    source="Unitree's description and data sheet of Go2: hips, mass; Quad-SDK's parameters for "
    "Go2: nominal height; the rest as for Spirit, the gait too",
)


class ModelRegistry(Mapping[str, RobotModel]):
    """Robot models by name: those that come with the package, and those that a program adds."""

    def __init__(self, shipped: Iterable[RobotModel]) -> None:
        self._models = {model.name: model for model in shipped}
        self.shipped = tuple(self._models)

    def __getitem__(self, name: str) -> RobotModel:
        return self._models[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._models)

    def __len__(self) -> int:
        return len(self._models)

    def add(self, model: RobotModel) -> RobotModel:
        """Add a model; one that is there already, with the same values, stays.

        Raises:
            InputError: Its values do not fit, or another model has that name.
        """
        check_model(instance_of(model, RobotModel, "model"))
        if self._models.setdefault(model.name, model) != model:
            raise InputError(f"there is another robot model {model.name!r}", key="name")
        return model

    def remove(self, name: str) -> None:
        """Take a model away that a program added.

        Raises:
            InputError: There is none of that name, or it comes with the package.
        """
        if name in self.shipped or name not in self._models:
            raise InputError(f"no robot model {name!r} was added", key="name")
        del self._models[name]


def _quadruped(
    name: str,
    size: tuple[float, float, float],
    legs: LegModel,
    source: str,
    description: QuadrupedDescription | None = None,
) -> RobotModel:
    """A walking robot of `size` length, width, height with the speeds of the formation paper."""
    return RobotModel(
        name,
        *size,
        max_speed_x=0.50,
        max_speed_y=0.20,
        max_yaw_rate=1.2,
        max_acceleration=1.0,
        max_yaw_acceleration=2.0,
        source=source,
        tracking_error=0.0 if description is None else _TRACKING_ERROR,
        legs=legs,
        description=description,
    )


def _planar(
    name: str, drive: Drive, size: tuple[float, float], acceleration: float, source: str
) -> RobotModel:
    """A robot of db-CBS with 0.5 m/s and 0.5 rad/s; square: a disc.

    Unicycles drive forwards and backwards; integrators move in all directions, and how they are
    turned is of no account.
    """
    unicycle = drive in ("unicycle", "unicycle-2")
    return RobotModel(
        name,
        *size,
        height=0.25,
        max_speed_x=0.5,
        max_speed_y=0.0 if unicycle else 0.5,
        max_yaw_rate=0.5,
        max_acceleration=acceleration,
        max_yaw_acceleration=acceleration if unicycle else math.inf,
        source=f"db-CBS (IMRCLab/db-CBS, src/robots.cpp): {source}",
        drive=drive,
        round=size[0] == size[1],
    )


_QUADRUPEDS = (
    _quadruped("go1", (0.65, 0.28, 0.40), GO1, f"{_PAPER}: body and speeds", GO1_BODY),
    _quadruped(
        "go2",
        (0.70, 0.31, 0.40),
        GO2,
        "Unitree's data sheet of Go2: body; speeds as go1",
        GO2_BODY,
    ),
    _quadruped(
        "spirit", (0.70, 0.35, 0.35), SPIRIT, "Ghost Robotics Spirit 40: body; speeds as go1"
    ),
)

# The integrators' published limits hold for x and y apart; taken for the length of the vector,
# they are met a fortiori. Radius of the double integrator: 0.15 m there, 0.1 m in dynobench.
_PLANAR = (
    _planar("unicycle", "unicycle", (0.5, 0.25), math.inf, "unicycle_first_order_0, ±0.5 m/s"),
    _planar("unicycle-sphere", "unicycle", (0.8, 0.8), math.inf, "unicycle_first_order_0_sphere"),
    _planar(
        "unicycle-2", "unicycle-2", (0.5, 0.25), 0.25, "unicycle_second_order_0, ±0.25 m/s², rad/s²"
    ),
    _planar(
        "single-integrator", "integrator", (0.2, 0.2), math.inf, "single_integrator_0, ±0.5 m/s"
    ),
    _planar("double-integrator", "integrator-2", (0.3, 0.3), 2.0, "double_integrator_0, ±2 m/s²"),
)

MODELS = ModelRegistry((*_QUADRUPEDS, *_PLANAR))
"""Where names of robot models are looked up: by `robot_model`, and in scenario files."""


def register_model(model: RobotModel) -> RobotModel:
    """Make a model of one's own known by its name, in Python and in scenario files.

    It is known in this process alone: `MODELS.remove(name)` takes it away again, and who reads
    the scenario of a run elsewhere registers it there, too. A model that stands in a file of its
    own (see `load_model`) needs no registration.

    Returns:
        The model.

    Raises:
        InputError: Its values do not fit, or another model has that name.
    """
    return MODELS.add(model)


def robot_model(model: str | RobotModel) -> RobotModel:
    """The model of that name; one that is given itself comes back.

    Raises:
        InputError: There is none; the message lists those there are.
    """
    if isinstance(model, RobotModel):
        return model
    if not isinstance(model, str):
        raise InputError(
            f"expected a RobotModel or the name of one, got {described(model)}", key="model"
        )
    try:
        return MODELS[model]
    except KeyError:
        hint = "; cavalcade.robots.load_model reads a file" if is_model_file(model) else ""
        text = f"unknown robot model {described(model)}{hint}"
        raise InputError(text, choices=MODELS) from None


_MAX_BYTES = 100_000
_SUFFIXES = (".yaml", ".yml")
_FIELDS = tuple(field for field in fields(RobotModel) if field.name not in ("legs", "description"))

KEYS = ("like", *(field.name for field in _FIELDS))
"""Keys of a file: `like`, and the attributes of `RobotModel` but for its parts."""


def is_model_file(name: str) -> bool:
    """Whether a robot's model is named by its file."""
    return name.lower().endswith(_SUFFIXES)


def load_model(path: str | Path) -> RobotModel:
    """Read a robot model.

    Its keys are the attributes of `RobotModel` in the same units, and `like`: a known model that
    gives what the file leaves out, its legs, masses and joints among it. `name` is the file's own
    where it is left out, `source` the file's name.

    Raises:
        InputError: It cannot be read, a key is unknown or missing, or a value does not fit; the
            message is one line that names file and key.
    """
    from cavalcade.files import read_bytes
    from cavalcade.yaml_text import parse_yaml

    path = Path(path)
    said = parse_yaml(read_bytes(path, _MAX_BYTES, InputError), file=path, kind=InputError)
    if not isinstance(said, dict):
        raise InputError("expected a mapping of keys such as name and length", file=path)
    try:
        return _model(said, path)
    except InputError as error:
        raise error.at(file=path, key=error.key) from None


def _model(said: dict[str, Any], path: Path) -> RobotModel:
    for key in said:
        if key not in KEYS:
            text = "unknown key" + did_you_mean(str(key), KEYS)
            raise InputError(text, key=str(key)[:40], choices=KEYS)
    numbers = {key: float(value) for key, value in said.items() if type(value) is int}
    given = {"name": path.stem, "source": path.name, **said, **numbers}
    like = given.pop("like", None)
    for key, kind in (("name", str), ("source", str), ("round", bool)):
        if key in given and not isinstance(given[key], kind):
            raise InputError("expected text" if kind is str else "expected yes or no", key=key)
    if like is None:
        needed = [field.name for field in _FIELDS if field.default is MISSING]
        missing = [key for key in needed if key not in given]
        if missing:
            text = f"{is_missing(missing[1:])}; or say what it is like, as `like: go1`"
            raise InputError(text, key=missing[0])
        model = RobotModel(**given)
    elif isinstance(like, str) and like in MODELS:
        model = replace(robot_model(like), **given)
    else:
        text = f"unknown robot model {described(like)}"
        raise InputError(text, key="like", choices=MODELS)
    check_model(model)
    if model.name in MODELS.shipped:
        raise InputError(f"there is another robot model {model.name!r}", key="name")
    return model
