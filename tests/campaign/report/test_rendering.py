"""The templates: Markdown and a page, whatever the trials are called."""

import json
import re
from html.parser import HTMLParser

import pytest

from cavalcade.campaign.report import html_text, markdown_text, write_report
from cavalcade.campaign.report.tables import Table
from cavalcade.campaign.report.wording import code, plain


class Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.texts, self.sources, self.ids = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.sources += [value for key, value in attrs if key in ("src", "href")]
        self.ids += [value for key, value in attrs if key == "id"]
        if tag not in ("meta", "img", "input", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture
def odd(tmp_path, make_lines, suite):
    """Markdown and page of trials whose names and details look like markup."""
    lines = [
        {
            **line,
            "trial": f"a<!--<script><b>{k}|",
            "scenario": "a|b <i>",
            "outcome": "stuck",
            "success": False,
            "feasible": True,
            "detail": "5 < 6 & it _is_ **loud** {{ 1 }} `x`",
        }
        for k, line in enumerate(make_lines(4, ("clutter",), variants=("cavalcade",)))
    ]
    write_report(tmp_path, suite, lines, command="cavalcade campaign a --out b && echo <")
    return [(tmp_path / n).read_text(encoding="utf-8") for n in ("report.md", "report.html")]


def test_markdown_keeps_what_is_said(odd):
    text, _ = odd
    assert text.startswith("# Campaign `made-up`\n\nFour robots")
    assert "| stuck | 5 \\< 6 &amp; it \\_is\\_ \\* \\*loud\\* \\* {{ 1 }} 'x' | 4 |" in text
    assert "| `a\\|b <i>` | 4 |" in text
    assert "|---|--:|" in text
    assert "```sh\ncavalcade campaign a --out b && echo <\n```" in text
    assert "![Success in feasible worlds with 95 % interval" in text
    assert "\n\n\n" not in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    heads = [k for k, line in enumerate(rows) if re.fullmatch(r"\|[-:|]+", line)]
    assert heads
    for k in heads:
        assert len(re.findall(r"(?<!\\)\|", rows[k - 1])) == rows[k].count("|")


def test_the_page_is_whole_and_needs_nothing_else(odd):
    _, page = odd
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    assert all(source.startswith(("data:", "#")) for source in reader.sources)
    links = [source[1:] for source in reader.sources if source.startswith("#")]
    assert {"verdict", "worst-trials", "how-to-read-this", "trials"} <= set(links)
    assert set(links) <= set(reader.ids)
    assert "<title>Campaign made-up</title>" in page
    assert "5 &lt; 6 &amp; it _is_ * *loud* * {{ 1 }}" in page
    assert "<!--<script>" not in page
    assert "data:image/svg+xml;base64," in page
    data = json.loads(re.search(r'application/json">(.*?)</script>', page, re.S)[1])
    assert [row[0] for row in data["rows"]] == [f"a<!--<script><b>{k}|" for k in range(4)]
    assert data["rows"][0][-1] == "5 < 6 & it _is_ **loud** {{ 1 }} `x`"


def test_texts_have_two_kinds_of_markup():
    assert markdown_text("5 < 6 & **so** it _is_ `<b>`") == "5 \\< 6 &amp; **so** it \\_is\\_ `<b>`"
    assert str(html_text("5 < 6 & **so** `<b>`")) == (
        "5 &lt; 6 &amp; <strong>so</strong> <code>&lt;b&gt;</code>"
    )


def test_what_trials_say_is_no_markup():
    assert code("a`b") == "`a'b`"
    assert plain("**loud**") == "* *loud* *"


def test_columns_are_numbers_texts_or_long_texts():
    table = Table(("a", "b", "c"), [("x", "1", "w" * 41)], 1, last=True)
    assert table.kinds == ("text", "number", "long")


def test_empty_columns_go(tmp_path, make_lines, suite):
    lines = make_lines(4, ("clutter",), variants=("cavalcade",))
    for line in lines:
        del line["summary"]["cycle_ms"]
    write_report(tmp_path, suite, lines, pictures=False)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    head = text.split("## Time, formation, clearance")[1].split("|---")[0]
    assert "formation error p50 (cm)" in head
    assert "cycle" not in head
