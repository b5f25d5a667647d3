"""Robot models of one's own in YAML files."""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.robots.catalogue import MODELS, robot_model
from cavalcade.robots.model import RobotModel, check_model

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
            raise InputError("unknown key", key=key[:40], choices=KEYS)
    numbers = {key: float(value) for key, value in said.items() if type(value) is int}
    given = {"name": path.stem, "source": path.name, **said, **numbers}
    like = given.pop("like", None)
    for key, kind in (("name", str), ("source", str), ("round", bool)):
        if key in given and not isinstance(given[key], kind):
            raise InputError("expected text" if kind is str else "expected yes or no", key=key)
    if like is None:
        for field in _FIELDS:
            if field.default is MISSING and field.name not in given:
                raise InputError(
                    "is missing; expected it, or a model that it is like", key=field.name
                )
        model = RobotModel(**given)
    elif isinstance(like, str) and like in MODELS:
        model = replace(robot_model(like), **given)
    else:
        raise InputError("unknown robot model", key="like", choices=MODELS)
    check_model(model)
    if model.name in MODELS.shipped:
        raise InputError(f"there is another robot model {model.name!r}", key="name")
    return model
