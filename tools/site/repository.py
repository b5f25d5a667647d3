"""Parts of pages that are files of the repository: examples, changes, shipped scenarios."""

from __future__ import annotations

import ast
from pathlib import Path

from cavalcade.scenario import scenario_descriptions

ROOT = Path(__file__).resolve().parents[2]


def changes() -> str:
    """The changelog below its title."""
    return (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").partition("\n")[2].strip()


def examples() -> str:
    """Every example: its first sentence as heading, and the file."""
    return "\n\n".join(_example(path) for path in sorted((ROOT / "examples").glob("*.py")))


def _example(path: Path) -> str:
    code = path.read_text(encoding="utf-8")
    about = (ast.get_docstring(ast.parse(code)) or path.stem).splitlines()[0].rstrip(".")
    return f'## {about} {{ #{path.stem} }}\n\n```python title="examples/{path.name}"\n{code}```'


def shipped_scenarios() -> str:
    """A table of the scenarios that can be run by name."""
    rows = [f"| `{name}` | {about} |" for name, about in scenario_descriptions().items()]
    return "\n".join(("| scenario | |", "|---|---|", *rows))
