"""YAML text to plain values: mappings, lists, text, numbers, true/false and null, nothing else.

Only the parsing half of PyYAML is used: its events. The values are made here, because files come
from anywhere: tags that build other things, keys given twice, merge keys, values that contain
themselves, nesting without end and aliases that unfold to billions of values end as one clear
line. PyYAML's own composer calls itself for each level, which ends the process where a file
nests deeply enough, and takes several times as long.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import yaml

from cavalcade.errors import InputError, ScenarioError

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_RESOLVERS = yaml.SafeLoader.yaml_implicit_resolvers
_DEPTH = 50
_TAG = "tag:yaml.org,2002:"
_TRUE, _FALSE = ("yes", "true", "on"), ("no", "false", "off")


def parse_yaml(
    text: str | bytes,
    *,
    file: str | Path | None = None,
    key: str | None = None,
    kind: type[InputError] = ScenarioError,
) -> Any:
    """The value of one YAML document; None for an empty one.

    Raises:
        InputError: It is not YAML, or holds what plain values cannot; of that `kind`, and it names
            `file` and `key`.
    """
    place = kind("", file=file, key=key)
    try:
        return _Builder(text, place).document()
    except yaml.MarkedYAMLError as error:
        problem = " ".join(part for part in (error.context, error.problem) if part)
        reason = problem + _place(error.problem_mark or error.context_mark)
    except yaml.YAMLError as error:
        reason = getattr(error, "reason", None) or "unreadable character"
    except (RecursionError, ValueError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else "unreadable text"
    raise kind(f"not valid YAML: {reason}", file=file, key=key)


class _Builder:
    """Values out of the events of one document; `place` is where its errors are said to be."""

    def __init__(self, text: str | bytes, place: InputError) -> None:
        self.events = yaml.parse(text, Loader=_Loader)
        self.place = place
        self.anchors: dict[str, Any] = {}
        # Text of n characters holds fewer than n values, unless aliases repeat them.
        self.left = 10_000 + len(text)

    def document(self) -> Any:
        next(self.events)  # the stream's start
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return None
        value = self.value(next(self.events), 0)
        next(self.events)  # the document's end
        rest = next(self.events)
        if not isinstance(rest, yaml.StreamEndEvent):
            raise self.error("not valid YAML: a second document begins", rest)
        return value

    def value(self, event: yaml.Event, depth: int) -> Any:
        self.count(event, depth)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self.anchors:  # not there, or not at its end yet
                raise self.error(f"alias {_short(event.anchor)} has no value to repeat", event)
            return self.repeated(self.anchors[event.anchor], event, depth)
        if event.anchor in self.anchors:
            raise self.error(f"anchor {_short(event.anchor)} stands here twice", event)
        value: Any
        if isinstance(event, yaml.MappingStartEvent):
            value = self.mapping(event, depth)
        elif isinstance(event, yaml.SequenceStartEvent):
            self.check_tag(event, "seq")
            value = []
            while not isinstance(item := next(self.events), yaml.SequenceEndEvent):
                value.append(self.value(item, depth + 1))
        else:
            value = self.scalar(event)
        if event.anchor is not None:
            self.anchors[event.anchor] = value
        return value

    def mapping(self, event: yaml.Event, depth: int) -> dict[str, Any]:
        self.check_tag(event, "map")
        result: dict[str, Any] = {}
        while not isinstance(name := next(self.events), yaml.MappingEndEvent):
            if not isinstance(name, yaml.ScalarEvent):
                raise self.error("expected a name before the colon", name)
            if _kind(name) == "merge":
                raise self.error("merge keys (<<) are not supported; write the values out", name)
            if name.value in result:
                raise self.error(f"key {_short(name.value)} stands here twice", name)
            if name.anchor is not None:
                self.anchors[name.anchor] = name.value
            result[name.value] = self.value(next(self.events), depth + 1)
        return result

    def scalar(self, event: yaml.Event) -> Any:
        text: str = event.value
        kind = _kind(event)
        word = text.lower()
        if kind in ("str", "timestamp", "value"):
            return text
        if kind == "null":
            return None
        if kind == "bool" and word in _TRUE + _FALSE:
            return word in _TRUE
        if kind in ("int", "float"):
            return text if ":" in text else self.number(kind, word.replace("_", ""), event)
        raise self.error(f"{_short(text)} is no {_short(kind)} that has a place here", event)

    def number(self, kind: str, word: str, event: yaml.Event) -> int | float:
        special = {".inf": math.inf, ".nan": math.nan}.get(word.lstrip("+-"))
        if special is not None:
            return -special if word.startswith("-") else special
        try:
            if len(word) > 400:
                raise ValueError
            if kind == "float":
                return float(word)
            return int(word, 0) if word.lstrip("+-")[:2] in ("0x", "0b", "0o") else int(word)
        except ValueError:
            raise self.error(f"expected a number, got {_short(word)}", event) from None

    def repeated(self, value: Any, event: yaml.Event, depth: int) -> Any:
        """A copy, so that a change of one place does not change another."""
        self.count(event, depth)
        if isinstance(value, dict):
            return {key: self.repeated(item, event, depth + 1) for key, item in value.items()}
        if isinstance(value, list):
            return [self.repeated(item, event, depth + 1) for item in value]
        return value

    def count(self, event: yaml.Event, depth: int) -> None:
        self.left -= 1
        if self.left < 0:
            raise self.error("aliases unfold to too many values", event)
        if depth > _DEPTH:
            raise self.error("nested too deeply", event)

    def check_tag(self, event: yaml.Event, kind: str) -> None:
        if event.tag not in (None, "!", _TAG + kind):
            raise self.error(f"tag {_short(event.tag)} has no place here", event)

    def error(self, message: str, event: yaml.Event) -> InputError:
        place = self.place
        return type(place)(message + _place(event.start_mark), file=place.file, key=place.key)


def _kind(event: yaml.Event) -> str:
    """What a scalar is, by its tag or, of plain text, by what it looks like."""
    tag: str | None = event.tag
    if tag is None or tag == "!":
        tag = _TAG + "str"
        if event.implicit[0]:
            looks = (*_RESOLVERS.get(event.value[:1], ()), *_RESOLVERS.get(None, ()))
            tag = next((name for name, form in looks if form.match(event.value)), tag)
    return tag.removeprefix(_TAG)


def _place(mark: yaml.Mark | None) -> str:
    return "" if mark is None else f" (line {mark.line + 1}, column {mark.column + 1})"


def _short(text: str) -> str:
    text = repr(text.removeprefix(_TAG))
    return text if len(text) <= 40 else text[:36] + "...'"
