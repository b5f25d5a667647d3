"""The pages of the documentation and the blocks of code on them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]

LESSONS = [DOCS / "tutorial" / f"{name}.md" for name in ("first-run", "own-map", "own-loop")]
LESSONS.append(DOCS / "tutorial" / "own-robot.md")
"""They build on each other, in this order."""

LIVE = [DOCS / "tutorial" / "live.md"]
"""They need a ROS 2 graph: `tests/live` runs them."""

_BLOCK = re.compile(r'^```(\w*)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_EXIT = re.compile(r"# Ends with exit code (\d)")


@dataclass(frozen=True)
class Block:
    """What stands between two fences.

    Attributes:
        language: `python`, `sh`, `yaml`, or nothing for listings.
        title: The name of a file that it is; empty without.
        code: Its text.
    """

    language: str
    title: str
    code: str

    @property
    def is_run(self) -> bool:
        """Whether it does not say that it is not."""
        return not self.code.startswith("# Not run by the tests: ")

    @property
    def exit_code(self) -> int:
        """That its commands end with."""
        said = _EXIT.match(self.code)
        return int(said[1]) if said else 0


def blocks(page: Path, *languages: str) -> list[Block]:
    """The blocks of a page in order, of some languages or of all."""
    found = [Block(*parts) for parts in _BLOCK.findall(page.read_text(encoding="utf-8"))]
    return [one for one in found if not languages or one.language in languages]


def name_of(page: Path) -> str:
    """A page's path within the repository."""
    return page.relative_to(ROOT).as_posix()
