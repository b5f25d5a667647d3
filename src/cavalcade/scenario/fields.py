"""The kinds of value a scenario file is made of, and what is said when one is wrong."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    Strict,
    ValidationInfo,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError

LIMIT = 1e6
"""Largest magnitude of a coordinate or length, m: beyond it single cells are lost to rounding."""

# YAML 1.1 reads `1e-3` as text because the dot is missing; a user means a number.
_SCIENTIFIC = re.compile(r"[-+]?\d{1,20}(\.\d{0,20})?[eE][-+]?\d{1,3}")


class Section(BaseModel):
    """A mapping of the file: unknown keys are errors, values do not change.

    Its docstring describes its keys below `Attributes:`, with the unit in brackets; the JSON
    Schema says the same as `description` and `unit`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        schema = handler(core_schema)
        whole = handler.resolve_ref_schema(schema)
        whole["description"], _ = _described(cls)
        described = {k: v for base in reversed(cls.__mro__) for k, v in _described(base)[1].items()}
        for key, (unit, meaning) in described.items():
            if key in whole.get("properties", {}):
                whole["properties"][key] |= {"description": meaning}
                whole["properties"][key] |= {"unit": unit} if unit else {}
        return schema


_KEYS = re.compile(r"^    (\w[\w, ]*?)(?: \((.+?)\))?: (.+?)(?=^    \w|\Z)", re.M | re.S)


def _described(cls: type) -> tuple[str, dict[str, tuple[str | None, str]]]:
    """What a docstring says of its class, and of each attribute: its unit, if any, and meaning."""
    about, _, attributes = (inspect.getdoc(cls) or "").partition("\nAttributes:\n")
    return about.strip(), {
        name: (unit or None, " ".join(meaning.split()))
        for names, unit, meaning in _KEYS.findall(attributes)
        for name in names.split(", ")
    }


def expected(
    text: str, *, key: str | None = None, choices: Iterable[str] | None = None
) -> PydanticCustomError:
    """The error to raise in a validator.

    Args:
        text: What is wrong and what was expected, one line.
        key: Where, below the validated value (`goals[2]`), if not the value itself.
        choices: The valid values, if there is a short list of them.
    """
    context = {"text": text, "key": key, "choices": None if choices is None else tuple(choices)}
    return PydanticCustomError("expected", "{text}", context)


class Choice(Section):
    """A mapping in which exactly one of several keys says what it is.

    Attributes:
        kinds: These keys.
        wanted: What is said where there is none or more than one of them.
    """

    kinds: ClassVar[tuple[str, ...]]
    wanted: ClassVar[str]

    @model_validator(mode="after")
    def _exactly_one(self) -> Self:
        if sum(getattr(self, kind) is not None for kind in self.kinds) != 1:
            raise expected(self.wanted, choices=self.kinds)
        return self

    @property
    def kind(self) -> str:
        """Which of the keys is there."""
        return next(kind for kind in self.kinds if getattr(self, kind) is not None)

    @property
    def value(self) -> Any:
        """What it says."""
        return getattr(self, self.kind)


def _number(value: Any) -> float:
    number = _number_or_inf(value)
    if not math.isfinite(number):
        raise expected("expected a finite number")
    return number


def _number_or_inf(value: Any) -> float:
    if isinstance(value, str) and _SCIENTIFIC.fullmatch(value):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise expected("expected a number")
    try:
        number = float(value)
    except OverflowError:
        raise expected("expected a finite number") from None
    if math.isnan(number):
        raise expected("expected a finite number")
    return number


def _numbers(names: str) -> BeforeValidator:
    count = names.count(",") + 1

    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != count:
            raise expected(f"expected [{names}]: {count} numbers")
        return value

    return BeforeValidator(check)


def checked_path(value: Any) -> Any:
    """A name that a file can have."""
    if not isinstance(value, str | Path) or not str(value).strip():
        raise expected("expected a file name")
    if not str(value).isprintable():
        raise expected("expected a file name of printable characters")
    return value


def below_file(path: Path, info: ValidationInfo) -> Path:
    """A name in the file: relative to the file, not to the folder the program runs in."""
    base = (info.context or {}).get("base")
    return path if base is None or path.is_absolute() else Path(base) / path


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
NotNegativeOrInf = Annotated[float, BeforeValidator(_number_or_inf), Field(ge=0)]
Fraction = Annotated[Number, Field(ge=0, le=1)]
Coordinate = Annotated[Number, Field(ge=-LIMIT, le=LIMIT)]
Length = Annotated[Number, Field(gt=0, le=LIMIT)]
Speed = Annotated[Number, Field(gt=0, le=100)]
Seconds = Annotated[Number, Field(ge=0, le=LIMIT)]
Index = Annotated[int, Strict(), Field(ge=0)]
Seed = Annotated[int, Strict(), Field(ge=0, lt=2**63)]
Point = Annotated[tuple[Coordinate, Coordinate], _numbers("x, y")]
Size = Annotated[tuple[Length, Length], _numbers("width, height")]
Pose = Annotated[tuple[Coordinate, Coordinate, Coordinate], _numbers("x, y, yaw")]
File = Annotated[Path, BeforeValidator(checked_path), AfterValidator(below_file)]


def in_time(said: tuple[Any, ...]) -> tuple[Any, ...]:
    """What happens `at` some time, in order of time."""
    return tuple(sorted(said, key=lambda one: one.at))


class OneLine(dict[str, Any]):
    """A mapping that is written to a file on one line."""
