"""The method note says what the code does."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

from cavalcade.kinodynamic.settings import VARIANTS, BodySettings

NOTE = (
    Path(__file__).resolve().parents[2] / "docs" / "explanation" / "body-planning.md"
).read_text("utf-8")


def test_the_table_of_settings():
    table = NOTE.split("## Settings")[1].split("##")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|", table, flags=re.MULTILINE))
    defaults = BodySettings()
    assert list(rows) == ["BodySettings", *(field.name for field in fields(BodySettings))]
    for name in ("iterations", "seconds", "improve", "leaps", "variant", "margin"):
        assert rows[name] == str(getattr(defaults, name)), name
    assert all(f"`{name}`" in NOTE or name == defaults.variant for name in VARIANTS)


def test_the_example_runs(capsys):
    code = NOTE.split("```python")[1].split("```")[0]
    exec(compile(code, "body-planning.md", "exec"), {})
    reason, length = capsys.readouterr().out.split()
    assert reason == "solved"
    assert abs(float(length) - 5.2) < 0.05
