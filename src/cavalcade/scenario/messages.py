"""What is said about a scenario that does not fit the schema: one line, one place, what to do."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from cavalcade.errors import ScenarioError
from cavalcade.values import did_you_mean

_EXPECTED = {
    "model_type": "expected a mapping",
    "model_attributes_type": "expected a mapping",
    "tuple_type": "expected a list",
    "string_type": "expected text",
    "int_type": "expected a whole number",
    "int_parsing": "expected a whole number",
    "string_too_short": "expected some text",
}


def scenario_error(
    error: ValidationError, model: type[BaseModel], file: str | Path | None
) -> ScenarioError:
    """The error to show for what pydantic found; of several, the most telling one."""
    found = error.errors(include_url=False)
    # A misspelt key is also a missing one; the spelling is what the user can mend.
    first = next((item for item in found if item["type"] == "extra_forbidden"), found[0])
    place, context = list(first["loc"]), dict(first.get("ctx", {}))
    kind, value = first["type"], first.get("input")
    choices: tuple[str, ...] | None = None
    if kind == "expected":
        message, choices = str(context["text"]), context["choices"]
        key = ".".join(part for part in (dotted(place), context["key"]) if part)
        if context["key"] is None and not isinstance(value, Mapping | BaseModel):
            message += _got(value, message)
        return ScenarioError(message, file=file, key=key, choices=choices)
    if kind == "extra_forbidden":
        section = _section_at(model, place[:-1])
        choices = () if section is None else tuple(section.model_fields)
        message = "unknown key" + did_you_mean(str(place[-1]), choices)
    elif kind == "missing":
        section, message = _section_at(model, place), "missing"
        if section is not None:
            message += f"; expected a mapping with {', '.join(section.model_fields)}"
    elif kind == "literal_error":
        choices = tuple(re.findall(r"'([^']*)'", str(context["expected"])))
        if choices:
            message = f"unknown value {short(value)}" + did_you_mean(str(value), choices)
        else:
            message = f"expected {context['expected']}, got {short(value)}"
    elif kind == "too_short":
        message = f"expected at least {context['min_length']}, got {context['actual_length']}"
    elif kind == "too_long":
        message = f"expected at most {context['max_length']}"
    else:
        message = _EXPECTED.get(kind, first["msg"].replace("Input should be", "expected"))
        section = _section_at(model, place)
        if section is not None and kind.startswith("model_"):
            message += f" with {', '.join(section.model_fields)}"
        message += _got(value, message)
    return ScenarioError(message, file=file, key=dotted(place), choices=choices)


def dotted(place: Iterable[str | int]) -> str:
    """`robots[0].start` for ("robots", 0, "start")."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{_clean(part)}"
    return text.removeprefix(".")


def short(value: Any) -> str:
    """A value for an error message, cut to a few words."""
    if isinstance(value, int) and value.bit_length() > 200:
        return "a huge number"
    if isinstance(value, list | tuple) and len(value) > 8:
        return f"a list of {len(value)}"
    if isinstance(value, Mapping):
        return "a mapping"
    text = ascii(value[:60] if isinstance(value, str) else value)
    return text if len(text) <= 50 else text[:46] + "..."


def _got(value: Any, message: str) -> str:
    """What was found there, unless the message says so already."""
    named = isinstance(value, str) and value != "" and value in message
    return "" if named or ", got" in message else f", got {short(value)}"


def _clean(part: str) -> str:
    return part if re.fullmatch(r"[\w-]{1,40}", part) else short(part)


def _section_at(model: type[BaseModel], place: list[str | int]) -> type[BaseModel] | None:
    section: type[BaseModel] | None = model
    for part in place:
        if isinstance(part, int) or section is None:
            continue
        field = section.model_fields.get(part)
        section = None if field is None else _section_in(field.annotation)
    return section


def _section_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for arg in get_args(annotation) if (found := _section_in(arg))), None)
