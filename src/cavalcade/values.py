"""Values that callers give: numbers, arrays and objects, refused by the name of the argument."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError

MAX_VALUE = 1e6
"""Largest coordinate, length or speed, in SI units; beyond it arithmetic loses the millimetres."""

_ENDLESS = 2**63 - 1

_T = TypeVar("_T")


def plain_number(value: object, key: str, kind: type[InputError] = InputError) -> float:
    """`value` as a float, infinite or nan too; True and False are none."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        raise kind(f"expected a number, got {described(value)}", key=key)
    try:
        return float(value)
    except (OverflowError, TypeError):
        raise kind("expected a number", key=key) from None


def number_in(
    value: object, key: str, least: float = -MAX_VALUE, most: float = MAX_VALUE, unit: str = ""
) -> float:
    """`value` as a float from `least` to `most`; nan is none.

    Raises:
        InputError: It is something else.
    """
    number = plain_number(value, key)
    if not least <= number <= most:
        unit = f" {unit}" if unit else ""
        raise InputError(
            f"expected a number from {least:g} to {most:g}{unit}, got {number:g}", key=key
        )
    return number


def whole_number(value: object, key: str, least: int = -_ENDLESS, most: int = _ENDLESS) -> int:
    """`value` as an int from `least` to `most`.

    Raises:
        InputError: It is something else.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError(f"expected a whole number, got {described(value)}", key=key)
    if not least <= value <= most:
        bounds = f"{least} or more" if most >= _ENDLESS else f"{least} to {most}"
        raise InputError(f"expected {bounds}, got {described(int(value))}", key=key)
    return int(value)


def number_array(
    values: object,
    key: str,
    shape: tuple[int | None, ...],
    what: str,
    most: float = MAX_VALUE,
    kind: type[InputError] = InputError,
) -> NDArray[np.float64]:
    """An own float array of a shape, in which None stands for any length.

    Args:
        values: Numbers, nested as deep as the shape has parts.
        key: The argument's name.
        shape: What is expected.
        what: The same in words, such as `(N, 3) poses`.
        most: Largest value and, negated, the least; nan if all are taken, nan too.
        kind: Of the error.

    Raises:
        InputError: Another shape; something that is no number, is masked, not finite or too large.
    """
    try:
        array = _as_array(values)
    except (TypeError, ValueError, OverflowError):
        raise kind(f"expected {what}, got rows of different lengths", key=key) from None
    if np.ma.is_masked(array):
        raise kind(f"expected {what}, some values are masked", key=key)
    if array.dtype.kind not in "iuf":
        # An empty list is an array of floats; of texts, None and truth values none can be made.
        raise kind(f"expected {what}, got {described(values)}", key=key)
    fits = len(array.shape) == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise kind(f"expected {what}, got an array of shape {array.shape}", key=key)
    with np.errstate(over="ignore"):
        result: NDArray[np.float64] = np.array(array, dtype=float, order="C")
    # One pass: nan fails every comparison.
    if not math.isnan(most) and not (np.abs(result) <= most).all():
        if not np.isfinite(result).all():
            raise kind(f"expected {what}, all finite", key=key)
        raise kind(f"expected {what} within ±{most:g}", key=key)
    return result


def real_array(
    values: Any, key: str, what: str, kind: type[InputError] = InputError
) -> NDArray[np.float64]:
    """Numbers or truth values as a float array of any shape, nan too; it may be the one given.

    What is masked is nan, as nobody knows it.

    Raises:
        InputError: They are something else; of that `kind`.
    """
    try:
        array = _as_array(values)
        if array.dtype.kind not in "biuf" and array.size:
            raise kind(f"expected {what}, got {described(values)}", key=key)
        return np.asarray(np.ma.filled(array.astype(float, copy=False), np.nan))
    except (TypeError, ValueError, OverflowError):
        raise kind(f"expected {what}, got {described(values)}", key=key) from None


def _as_array(values: Any) -> NDArray[Any]:
    """An array of values, masked where they or one of a list of them are."""
    if isinstance(values, (list, tuple)) and any(map(np.ma.isMaskedArray, values)):
        return np.ma.asarray(values)
    return np.asanyarray(values)


def points_of(
    values: object, most: float = MAX_VALUE, kind: type[InputError] = InputError
) -> NDArray[np.float64]:
    """Points `(N, 2)` in m as an own array.

    Raises:
        InputError: They are something else, or beyond `most`; of that `kind`.
    """
    return number_array(values, "points", (None, 2), "points (N, 2) in m", most, kind)


def pose_of(value: object, key: str) -> tuple[float, float, float]:
    """A pose x, y in m, yaw in rad.

    Raises:
        InputError: It is something else.
    """
    pose = number_array(value, key, (3,), "three numbers: x, y, yaw", math.nan)
    if not (np.abs(pose) <= MAX_VALUE).all():
        raise InputError(f"expected finite x, y, yaw within ±{MAX_VALUE:g}", key=key)
    x, y, yaw = pose.tolist()
    return x, y, yaw


def path_of(value: object, key: str = "path", kind: type[InputError] = InputError) -> Path:
    """The path of a file or folder.

    Raises:
        InputError: It is none, or no name that a file can have; of that `kind`.
    """
    if not isinstance(value, (str, PathLike)) or not isinstance(name := fspath(value), str):
        raise kind(f"expected the name of a file or folder, got {described(value)}", key=key)
    if "\0" in name:
        raise kind("the name of a file holds a null byte", key=key)
    if len(name) > 4000 or any(len(part) > 255 for part in name.split("/")):
        raise kind(f"the name {described(name)} is too long", key=key)
    return Path(name)


def instance_of(value: Any, kind: type[_T], key: str, what: str = "") -> _T:
    """`value`, which must be one of a class.

    Raises:
        InputError: It is something else.
    """
    if not isinstance(value, kind):
        wanted = what or _with_article(kind.__name__)
        raise InputError(f"expected {wanted}, got {described(value)}", key=key)
    return value


def instances_of(values: Any, kind: Any, key: str, what: str = "") -> tuple[Any, ...]:
    """`values` as a tuple, each of a class or of one of several, `A | B`.

    Raises:
        InputError: They are something else.
    """
    wanted = what or f"a list, each {_with_article(kind.__name__)}"
    if isinstance(values, (str, bytes, Mapping)) or not _is_iterable(values):
        raise InputError(f"expected {wanted}, got {described(values)}", key=key)
    return tuple(instance_of(v, kind, f"{key}[{k}]", what) for k, v in enumerate(values))


def _is_iterable(values: object) -> bool:
    """Whether values can be gone through; arrays of no dimension cannot."""
    return isinstance(values, Iterable) and not (
        isinstance(values, type) or (isinstance(values, np.ndarray) and values.ndim == 0)
    )


def described(value: object) -> str:
    """A value of no use in a few words, for messages: short ones as they are, else their kind."""
    if value is None or isinstance(value, (bool, float)):
        return repr(value)
    if isinstance(value, int) and abs(value) < 10**18:
        return repr(value)
    if isinstance(value, str):
        return repr(value if len(value) <= 40 else f"{value[:37]}...")
    return _with_article(type(value).__name__)


def _with_article(name: str) -> str:
    return f"{'an' if name[:1].lower() in 'aeiou' else 'a'} {name}"


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """`; did you mean x?` where one of the choices resembles the word, else nothing."""
    import difflib

    near = difflib.get_close_matches(word[:80], list(choices), n=1, cutoff=0.6)
    return f"; did you mean {near[0]}?" if near else ""


def is_missing(others: Iterable[str] = ()) -> str:
    """`is missing`, with the names of what is missing besides."""
    named = list(others)
    if not named:
        return "is missing"
    return f"is missing, and so {'is' if len(named) == 1 else 'are'} {', '.join(named)}"
