"""`docs/how-to/campaigns.md` says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

from cavalcade.campaign.samplers import SAMPLERS
from cavalcade.campaign.suite import load_suite, parse_suite, suite_names
from cavalcade.campaign.table import COLUMNS

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "how-to" / "campaigns.md").read_text(
    encoding="utf-8"
)


def section(title: str) -> str:
    """What stands below a heading, up to the next one."""
    return re.split(r"^#+ ", TEXT.split(f"# {title}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)[0]


def test_the_suite_shown_can_be_read() -> None:
    shown = yaml.safe_load(re.search(r"```yaml\n(.*?)```", TEXT, re.DOTALL)[1])
    assert list(parse_suite(shown).disturbances) == ["calm", "noise", "radio"]


def test_every_shipped_suite_is_listed() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \|", section("Shipped suites"), re.MULTILINE)
    assert sorted(rows) == list(suite_names())


def test_the_numbers_of_trials_are_those_of_the_suites() -> None:
    rows = re.findall(
        r"^\| `([\w-]+)` \| [\d,× ]+ \| ([\d,]+) \|", section("Shipped suites"), re.MULTILINE
    )
    said = {name: int(count.replace(",", "")) for name, count in rows}
    for name in said.keys() - {"barn"}:  # its data say how many
        suite = load_suite(name)
        runs = sum((group.seeds or 0) * len(group.variants) for group in suite.worlds)
        assert said[name] == runs * (len(suite.disturbances) or 1)


@pytest.mark.parametrize("kind", sorted(SAMPLERS))
def test_every_key_of_a_sampler_is_listed(kind: str) -> None:
    keys = set(SAMPLERS[kind].model_fields) - {"sampler"}
    said = set(re.findall(r"`(\w+)`", section(f"sampler: {kind}")))
    assert not keys - said


def test_every_column_is_listed() -> None:
    text = section("trials.parquet")
    for column in COLUMNS:
        assert f"`{column}`" in text or f"`.{column.partition('.')[2]}`" in text, column
