"""What commands print."""

from __future__ import annotations

import json
from typing import Any


def print_json(value: Any) -> None:
    """One value as JSON on stdout; mappings of any kind are objects."""
    print(json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False, default=dict))
