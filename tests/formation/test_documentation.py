"""The method note says what the code does."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

from cavalcade.formation import PRESETS, VARIANTS, FormationSettings
from cavalcade.formation.settings import default_settings
from cavalcade.formation.shapes import SHAPES

NOTE = (Path(__file__).resolve().parents[2] / "docs" / "explanation" / "formation.md").read_text(
    encoding="utf-8"
)


def test_the_table_of_parameters():
    columns = [
        default_settings("cavalcade"),
        default_settings("published"),
        PRESETS["simulation"][0],
        PRESETS["laboratory"][0],
    ]
    rows = {}
    for line in NOTE.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 7 and cells[0].startswith("`"):
            rows[cells[0].strip("`")] = [float(cell) for cell in cells[2:6]]
    assert list(rows) == [field.name for field in fields(FormationSettings)]
    for name, values in rows.items():
        assert values == [getattr(column, name) for column in columns], name


def test_every_variant_and_shape_is_named():
    for name in (*VARIANTS, *SHAPES):
        assert f"`{name}`" in NOTE


def test_every_reference_is_there_and_used():
    text, references = NOTE.split("## References")
    numbers = [line.split(".")[0] for line in references.splitlines() if line[:1].isdigit()]
    assert numbers == [str(k) for k in range(1, len(numbers) + 1)]
    assert all(f"[{number}]" in text for number in numbers)
