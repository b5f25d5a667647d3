"""Values that callers give: numbers, arrays and objects, refused by the name of the argument."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError

MAX_VALUE = 1e6
"""Largest coordinate, length or speed, in SI units; beyond it arithmetic loses the millimetres."""

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


def whole_number(value: object, key: str, least: int = -(10**18), most: int = 10**18) -> int:
    """`value` as an int from `least` to `most`.

    Raises:
        InputError: It is something else.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError(f"expected a whole number, got {described(value)}", key=key)
    if not least <= value <= most:
        raise InputError(f"expected {least} to {most}, got {described(int(value))}", key=key)
    return int(value)


def number_array(
    values: object, key: str, shape: tuple[int | None, ...], what: str, most: float = MAX_VALUE
) -> NDArray[np.float64]:
    """An own float array of a shape, in which None stands for any length.

    Args:
        values: Numbers, nested as deep as the shape has parts.
        key: The argument's name.
        shape: What is expected.
        what: The same in words, such as `(N, 3) poses`.
        most: Largest value and, negated, the least.

    Raises:
        InputError: Another shape; something that is no number, is masked, not finite or too large.
    """
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"expected {what}, got rows of different lengths", key=key) from None
    if np.ma.is_masked(values):
        raise InputError(f"expected {what}, some values are masked", key=key)
    if array.dtype.kind not in "iuf":
        # An empty list is an array of floats; of texts, None and truth values none can be made.
        raise InputError(f"expected {what}, got {described(values)}", key=key)
    fits = len(array.shape) == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise InputError(f"expected {what}, got an array of shape {array.shape}", key=key)
    with np.errstate(over="ignore"):
        result: NDArray[np.float64] = np.array(array, dtype=float)
    # One pass: nan fails every comparison.
    if not (np.abs(result) <= most).all():
        if not np.isfinite(result).all():
            raise InputError(f"expected {what}, all finite", key=key)
        raise InputError(f"expected {what} within ±{most:g}", key=key)
    return result


def instance_of(value: Any, kind: type[_T], key: str, what: str = "") -> _T:
    """`value`, which must be one of a class.

    Raises:
        InputError: It is something else.
    """
    if not isinstance(value, kind):
        wanted = what or _with_article(kind.__name__)
        raise InputError(f"expected {wanted}, got {described(value)}", key=key)
    return value


def instances_of(values: Any, kind: type[_T], key: str, what: str = "") -> tuple[_T, ...]:
    """`values` as a tuple, each of a class.

    Raises:
        InputError: They are something else.
    """
    wanted = what or f"a list, each {_with_article(kind.__name__)}"
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise InputError(f"expected {wanted}, got {described(values)}", key=key)
    return tuple(instance_of(v, kind, f"{key}[{k}]", what) for k, v in enumerate(values))


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
