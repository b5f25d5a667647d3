"""The values of a scenario file that have a field on the page, as the file's schema has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from cavalcade.formation import FormationSettings, default_settings
from cavalcade.formation.settings import PRESETS
from cavalcade.scenario import scenario_schema

_ELSEWHERE = ("execution.events",)
"""What has a place of its own on the page."""

_SIGNS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
_UNBOUNDED = 1e6
_NULL = {"type": "null"}
_PAPER = "Norén et al."


@dataclass(frozen=True)
class Parameter:
    """One value of the file.

    Attributes:
        path: Its dotted key.
        unit: None where it has none.
        meaning: In words.
        choices: The values that there are; empty for others.
        default: What it is where nothing is said; None where that depends on others.
        range: Such as `> 0, ≤ 10`; empty without bounds.
        flag: Whether it is true or false.
    """

    path: str
    unit: str | None
    meaning: str
    choices: tuple[str, ...]
    default: Any
    range: str
    flag: bool = False

    @property
    def key(self) -> str:
        """The path below its section."""
        return self.path.partition(".")[2]

    @property
    def label(self) -> str:
        """Key and unit."""
        return f"{self.key} ({self.unit})" if self.unit else self.key


def parameters(section: str) -> tuple[Parameter, ...]:
    """All values of a section of the file that are no lists of mappings, in the schema's order."""
    schema = scenario_schema()
    return tuple(_leaves(schema["properties"][section], section, schema["$defs"]))


def _leaves(schema: Mapping[str, Any], path: str, parts: Mapping[str, Any]) -> Iterator[Parameter]:
    name = _reference(schema)
    if name is None:
        yield _parameter(schema, path)
        return
    for key, value in parts[name]["properties"].items():
        below = f"{path}.{key}"
        if below in _ELSEWHERE:
            continue
        if "properties" not in parts.get(_reference(value) or "", {}):
            yield _parameter(value, below)
            continue
        for leaf in _leaves(value, below, parts):
            # What is said of a mapping is said of each value in it.
            meaning = f"{value.get('description', '')} {leaf.meaning}".strip()
            unsaid = "default" in value and value["default"] is None
            yield replace(leaf, meaning=meaning, default=None if unsaid else leaf.default)


def _parameter(schema: Mapping[str, Any], path: str) -> Parameter:
    said = [one for one in schema.get("anyOf", [schema]) if one != _NULL]
    choices: list[str] = []
    for one in said:
        choices += one.get("enum", [one["const"]] if "const" in one else [])
    return Parameter(
        path,
        schema.get("unit"),
        schema.get("description", ""),
        tuple(map(str, choices)),
        schema.get("default"),
        ", ".join(filter(None, map(_bounds, said))),
        any(one.get("type") == "boolean" for one in said),
    )


def _reference(schema: Mapping[str, Any]) -> str | None:
    for one in (schema, *schema.get("anyOf", ())):
        if "$ref" in one:
            return str(one["$ref"]).rpartition("/")[2]
    return None


def _bounds(schema: Mapping[str, Any]) -> str:
    bounds = {key: schema[key] for key in _SIGNS if abs(schema.get(key, _UNBOUNDED)) < _UNBOUNDED}
    if bounds.get("minimum", 0.0) > 0.0:
        bounds.pop("exclusiveMinimum", None)  # says less
    text = ", ".join(f"{_SIGNS[key]} {bound:g}" for key, bound in bounds.items())
    return text if schema.get("type") != "integer" else f"whole number {text}".strip()


def default_of(parameter: Parameter, planner: Mapping[str, Any]) -> tuple[Any, str]:
    """What a parameter is where the file says nothing, and where that comes from.

    Args:
        planner: The file's `planner` as it stands: variant and preset have defaults of their own.
    """
    key = parameter.path.removeprefix("planner.")
    if not parameter.path.startswith("planner.") or not hasattr(FormationSettings(), key):
        return parameter.default, ""
    published = getattr(FormationSettings(), key)
    preset = planner.get("preset")
    if preset is not None:
        value, source = getattr(PRESETS[preset][0], key), f"{preset} experiment of {_PAPER}"
    else:
        value = getattr(default_settings(planner.get("variant", "cavalcade")), key)
        source = _PAPER if value == published else f"ours; {_PAPER}: {published:g}"
    return value, source


def hint(parameter: Parameter, planner: Mapping[str, Any]) -> str:
    """All that is to be said of a parameter: meaning, default, source, range."""
    default, source = default_of(parameter, planner)
    words = [parameter.meaning]
    if default not in (None, "", [], ()) and not isinstance(default, dict):
        unit = f" {parameter.unit}" if parameter.unit else ""
        shown = text_of_value(default) + unit
        words.append(f"Default {shown}{f' ({source})' if source else ''}.")
    if parameter.range:
        words.append(f"Range: {parameter.range}.")
    return " ".join(words).replace("`", "")


def text_of_value(value: Any) -> str:
    """A value as it may stand in a YAML file, on one line."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return _number(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(text_of_value, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {text_of_value(item)}' for key, item in value.items())}}}"
    return str(value)


def _number(value: float) -> str:
    if value in (float("inf"), float("-inf")):
        return ".inf" if value > 0 else "-.inf"
    short = f"{value:.10g}"
    text = short if float(short) == value else repr(value)
    # YAML takes 1e-9 for text; the dot is what makes it a number.
    return text.replace("e", ".0e") if "e" in text and "." not in text else text
