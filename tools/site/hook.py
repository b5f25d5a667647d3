"""What mkdocs asks when it builds the site: fills in the parts of pages that come from the code.

A page says where with a line `<!-- generated: NAME -->`; the names are those of `PARTS`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from command_line import commands
from repository import changes, examples, shipped_scenarios
from scenario_keys import generator_options, scenario_keys, team_keys

PARTS: dict[str, Callable[[], str]] = {
    "changes": changes,
    "commands": commands,
    "examples": examples,
    "generator options": generator_options,
    "scenario keys": scenario_keys,
    "shipped scenarios": shipped_scenarios,
    "team keys": team_keys,
}

_PLACE = re.compile(r"^<!-- generated: (.+?) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """The page with its generated parts; an unknown name ends the build."""
    return _PLACE.sub(lambda place: PARTS[place[1]](), markdown)
