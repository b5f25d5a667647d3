"""YAML text to plain values: mappings, lists, text, numbers, true/false and null, nothing else.

Only the composing half of PyYAML is used. The values are made here, because a scenario file comes
from anywhere: tags that build other things, keys given twice, merge keys, values that contain
themselves and aliases that unfold to billions of values end as one clear line.
"""

from __future__ import annotations

import math
from typing import Any

import yaml

from cavalcade.errors import ScenarioError

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DEPTH = 50
_TAG = "tag:yaml.org,2002:"
_TRUE, _FALSE = ("yes", "true", "on"), ("no", "false", "off")


def parse_yaml(text: str, *, file: str | None = None, key: str | None = None) -> Any:
    """The value of one YAML document; None for an empty one.

    Args:
        text: The document.
        file: Named in the error.
        key: Likewise.

    Raises:
        ScenarioError: It is not YAML, or holds what plain values cannot.
    """
    try:
        node = yaml.compose(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        problem = " ".join(part for part in (error.context, error.problem) if part)
        place = _place(error.problem_mark or error.context_mark)
        raise ScenarioError(f"not valid YAML: {problem}{place}", file=file, key=key) from None
    except yaml.YAMLError as error:
        reason = getattr(error, "reason", None) or "unreadable character"
        raise ScenarioError(f"not valid YAML: {reason}", file=file, key=key) from None
    except (RecursionError, ValueError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else "unreadable text"
        raise ScenarioError(f"not valid YAML: {reason}", file=file, key=key) from None
    if node is None:
        return None
    # Text of n characters holds fewer than n values, unless aliases repeat them.
    return _Builder(10_000 + len(text), file, key).value(node, 0)


class _Builder:
    def __init__(self, budget: int, file: str | None, key: str | None) -> None:
        self.left, self.file, self.key = budget, file, key

    def value(self, node: yaml.Node, depth: int) -> Any:
        self.left -= 1
        if self.left < 0:
            raise self.error("aliases unfold to too many values", node)
        if depth > _DEPTH:
            raise self.error("nested too deeply", node)
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, depth)
        if isinstance(node, yaml.SequenceNode):
            if node.tag != _TAG + "seq":
                raise self.error(f"tag {_short(node.tag)} has no place here", node)
            return [self.value(item, depth + 1) for item in node.value]
        return self.scalar(node)

    def mapping(self, node: yaml.MappingNode, depth: int) -> dict[str, Any]:
        if node.tag != _TAG + "map":
            raise self.error(f"tag {_short(node.tag)} has no place here", node)
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise self.error("expected a name before the colon", key_node)
            name = key_node.value
            if key_node.tag == _TAG + "merge":
                raise self.error(
                    "merge keys (<<) are not supported; write the values out", key_node
                )
            if name in result:
                raise self.error(f"key {_short(name)} stands here twice", key_node)
            result[name] = self.value(value_node, depth + 1)
        return result

    def scalar(self, node: yaml.Node) -> Any:
        text: str = node.value
        kind = node.tag.removeprefix(_TAG)
        word = text.lower()
        if kind in ("str", "timestamp", "value"):
            return text
        if kind == "null":
            return None
        if kind == "bool" and word in _TRUE + _FALSE:
            return word in _TRUE
        if kind in ("int", "float"):
            return text if ":" in text else self.number(kind, word.replace("_", ""), node)
        raise self.error(f"{_short(text)} is no {_short(kind)} that has a place here", node)

    def number(self, kind: str, word: str, node: yaml.Node) -> int | float:
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
            raise self.error(f"expected a number, got {_short(word)}", node) from None

    def error(self, message: str, node: yaml.Node) -> ScenarioError:
        return ScenarioError(message + _place(node.start_mark), file=self.file, key=self.key)


def _place(mark: yaml.Mark | None) -> str:
    return "" if mark is None else f" (line {mark.line + 1}, column {mark.column + 1})"


def _short(text: str) -> str:
    text = repr(text.removeprefix(_TAG))
    return text if len(text) <= 40 else text[:36] + "...'"
