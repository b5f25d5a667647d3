"""The reference of scenario and team files, from what `cavalcade schema` prints."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from cavalcade.formation.settings import IMPROVED, FormationSettings
from cavalcade.live.team_file import team_schema
from cavalcade.scenario import scenario_schema
from cavalcade.world import TERRAINS, terrain_options
from cavalcade.world.generators import GENERATORS
from cavalcade.world.generators.model import options_of

_MORE = {"GenerateSource": " They are [below](#generated)."}
"""What the page has besides about a mapping."""

_UNBOUNDED = 1e6
"""Bounds of this size are those of all coordinates; the page says so once."""


_ELSEWHERE = {
    "FormationSection": "scenario.md#task-formation",
    "PlannerSection": "scenario.md#planner",
}
"""Mappings of team files that are those of scenarios."""


def scenario_keys() -> str:
    """A section for the file and for each mapping in it, with a table of its keys."""
    return _keys(scenario_schema(), {})


def team_keys() -> str:
    """The same of team files; what they share with scenarios is told there."""
    return _keys(team_schema(), _ELSEWHERE)


def _keys(schema: Any, elsewhere: dict[str, str]) -> str:
    parts: dict[str, Any] = schema["$defs"]
    places: dict[str, list[str]] = {}
    for name, place in _mappings(schema, "", parts, elsewhere):
        places.setdefault(name, []).append(place)
    anchors = {name: f"#{_anchor(found[0])}" for name, found in places.items()} | elsewhere
    sections = [f"## The file {{ #file }}\n\n{_table(schema, '', anchors)}"]
    for name, (place, *others) in places.items():
        level = "##" if "." not in place else "###"
        also = f" Also: {', '.join(f'`{one}`' for one in others)}." if others else ""
        about = parts[name].get("description", "") + also + _MORE.get(name, "")
        table = _table(parts[name], name, anchors)
        sections.append(f"{level} `{place}` {{ {anchors[name]} }}\n\n{about}\n\n{table}")
    return "\n\n".join(sections)


def generator_options() -> str:
    """A table of the kinds of generated worlds and terrain, with their options and defaults."""
    rows = ["| kind | what | options with their defaults |", "|---|---|---|"]
    for kind, generator in GENERATORS.items():
        rows.append(f"| `{kind}` | obstacles | {_options(options_of(generator))} |")
    rows += [f"| `{kind}` | terrain | {_options(terrain_options(kind))} |" for kind in TERRAINS]
    return "\n".join(rows)


def _options(options: Any) -> str:
    said = (
        f"`{name}`" + ("" if default is None else f" {default:g}")
        for name, default in options.items()
    )
    return ", ".join(said)


def _mappings(
    schema: Any, place: str, parts: dict[str, Any], elsewhere: dict[str, str]
) -> Iterator[tuple[str, str]]:
    """Every mapping of the file, by the name of its part, and where it stands."""
    for key, value in schema.get("properties", {}).items():
        for name, is_list in _references(value):
            if name in elsewhere:
                continue
            below = f"{place}.{key}" if place else key
            below += "[]" if is_list else ""
            yield name, below
            yield from _mappings(parts[name], below, parts, elsewhere)


def _references(schema: Any, is_list: bool = False) -> Iterator[tuple[str, bool]]:
    if "$ref" in schema:
        yield schema["$ref"].rpartition("/")[2], is_list
    for one in schema.get("anyOf", ()):
        yield from _references(one, is_list)
    if isinstance(schema.get("items"), dict):
        yield from _references(schema["items"], True)


def _anchor(place: str) -> str:
    return place.replace("[]", "").replace(".", "-")


def _table(schema: Any, name: str, anchors: dict[str, str]) -> str:
    rows = ["| key | value | unit | default | meaning |", "|---|---|---|---|---|"]
    for key, value in schema["properties"].items():
        default = _default(schema, name, key, value)
        cells = (f"`{key}`", _kind(value, anchors), value.get("unit", ""), default)
        rows.append(f"| {' | '.join(cells)} | {value['description']} |")
    return "\n".join(rows)


def _default(schema: Any, name: str, key: str, value: Any) -> str:
    if key in schema.get("required", ()) or "default" not in value:
        return "needed" if key in schema.get("required", ()) else ""
    default = value["default"]
    if name == "PlannerSection" and default is None and hasattr(IMPROVED, key):
        ours, published = getattr(IMPROVED, key), getattr(FormationSettings(), key)
        return f"{ours:g}" if ours == published else f"{ours:g}, `published` {published:g}"
    if default is None or default == "" or isinstance(default, dict):
        return ""
    return f"`{default}`" if isinstance(default, str) else json.dumps(default)


def _kind(schema: Any, anchors: dict[str, str]) -> str:
    """What a value may be, in words; null is left to the default."""
    if "$ref" in schema:
        return f"[mapping]({anchors[schema['$ref'].rpartition('/')[2]]})"
    if "anyOf" in schema:
        return " or ".join(_kind(one, anchors) for one in schema["anyOf"] if one != _NULL)
    if "const" in schema or "enum" in schema:
        values = schema.get("enum", [schema.get("const")])
        return ", ".join(f"`{json.dumps(one).strip(chr(34))}`" for one in values)
    if schema.get("type") == "array" and "prefixItems" in schema:
        return f"[{', '.join(_kind(one, anchors) for one in schema['prefixItems'])}]"
    if schema.get("type") == "array":
        return f"list of {_kind(schema['items'], anchors)}"
    if schema.get("format") == "path":
        return "file"
    return _WORDS[schema["type"]] + _bounds(schema)


_NULL = {"type": "null"}
_WORDS = {
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "string": "text",
}
_SIGNS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def _bounds(schema: Any) -> str:
    """Such as ` > 0, ≤ 10`."""
    bounds = {key: schema[key] for key in _SIGNS if abs(schema.get(key, _UNBOUNDED)) < _UNBOUNDED}
    if bounds.get("minimum", 0.0) > 0.0:
        bounds.pop("exclusiveMinimum", None)  # says less
    text = ", ".join(f"{_SIGNS[key]} {bound:g}" for key, bound in bounds.items())
    return f" {text}" if text else ""
