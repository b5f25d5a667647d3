"""The page of faults and messages has every fault, and every message of a live team."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import cavalcade
from cavalcade.execution import supervisor
from cavalcade.fleet.unitree.sport import Posture

from .pages import DOCS

SOURCE = Path(cavalcade.__file__).parent
LIVE = ("execution", "fleet", "live")
COMMANDS = ("cli/navigating.py", "cli/ros2.py")
PAGE = (DOCS / "reference" / "messages.md").read_text("utf-8")

KIND = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
SAID = ("FleetError", "refuse", "say", "_say")
"""Who is told something: what they are called with are messages."""


def sources() -> Iterator[ast.Module]:
    files = [file for folder in LIVE for file in sorted((SOURCE / folder).rglob("*.py"))]
    for file in (*files, *(SOURCE / name for name in COMMANDS)):
        if file.name != "mock.py":
            yield ast.parse(file.read_text("utf-8"))


def called(call: ast.Call) -> str:
    return getattr(call.func, "attr", getattr(call.func, "id", ""))


def text_of(node: ast.expr | None) -> str:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def fault_kinds() -> set[str]:
    """What is given to `Fault` and to a supervisor's `stop`, and pairs (kind, detail) that are
    made where faults are looked for."""
    found = set(re.findall(r"`([a-z-]+)`", (supervisor.__doc__ or "").partition("Fleets have")[0]))
    for module in sources():
        for node in ast.walk(module):
            if isinstance(node, ast.Call) and called(node) == "Fault" and len(node.args) > 1:
                found.add(text_of(node.args[1]))
            elif isinstance(node, ast.Call) and called(node) == "stop" and node.args:
                if "supervisor" in ast.unparse(node.func):
                    found.add(text_of(node.args[0]))
            elif isinstance(node, ast.FunctionDef) and node.name in ("fault", "faults"):
                pairs = (pair for pair in ast.walk(node) if isinstance(pair, ast.Tuple))
                found |= {text_of(pair.elts[0]) for pair in pairs if len(pair.elts) == 2}
    found |= set(Posture.__args__) - {"ready"}
    return {kind for kind in found if KIND.fullmatch(kind)} - {"reset_stop"}


def messages() -> set[str]:
    """The longest unchanging part of each message."""
    found = set()
    for module in sources():
        for node in ast.walk(module):
            if isinstance(node, ast.Call) and called(node) in SAID and node.args:
                found.add(longest_part(node.args[0]))
            elif isinstance(node, ast.FunctionDef) and node.name in ("missing", "_wrong_frame"):
                made = (one for one in ast.walk(node) if isinstance(one, ast.Return) and one.value)
                found |= {longest_part(one.value) for one in made if one.value is not None}
    return {text for text in found if len(text) >= 8}


def longest_part(node: ast.expr) -> str:
    parts = [text_of(one) for one in ast.walk(node) if isinstance(one, ast.Constant)]
    return max((part.strip(" :;,(") for part in parts), key=len, default="")


def test_every_fault_is_on_the_page() -> None:
    kinds = fault_kinds()
    assert {"stale", "frame", "deadline", "e-stop", "link-down", "guard", "ros2"} <= kinds
    assert len(kinds) >= 24
    table = PAGE.partition("{ #faults }")[2].partition("\n## ")[0]
    named = {kind for row in re.findall(r"^\| (`.*?) \|", table, re.M) for kind in row.split("`")}
    assert not kinds - named


def test_every_message_is_on_the_page() -> None:
    known = messages()
    assert len(known) > 15
    plain = PAGE.replace("`", "")
    # What all goes well with needs no explanation.
    fine = ("were heard", "active", "inactive", "Ctrl-C ends", "ended; all robots", "waits to be")
    missing = [text for text in known if text not in plain and not any(w in text for w in fine)]
    assert not missing
