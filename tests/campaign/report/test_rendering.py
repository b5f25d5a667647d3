from html.parser import HTMLParser

from cavalcade.campaign.report.blocks import (
    Bullets,
    Command,
    Figure,
    Folded,
    Heading,
    Instance,
    Table,
    Text,
    code,
    plain,
    without_empty_columns,
)

from cavalcade.campaign.report import markdown, page

TABLE = Table(("name", "value"), (("`a|b`", "1"), ("c<d>", "–")))
BLOCKS = [
    Heading("Campaign `x`", 1),
    Text("5 < 6 & **so** it _is_ `<b>`"),
    Bullets(("one", "two")),
    Command("cavalcade trial . a --out b && echo <"),
    Heading("Verdict"),
    TABLE,
    Folded("more", TABLE),
    Figure(Instance("f.png", b"PNG", b"<svg/>"), "A `figure`"),
]
TRIALS = page.trial_rows([("trial", None), ("n", 1)], [("a</script><b>", 1.5), ("b", None)])


class Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.texts, self.sources = [], [], []

    def handle_starttag(self, tag, attrs):
        self.sources += [value for key, value in attrs if key in ("src", "href")]
        if tag not in ("meta", "img", "input", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def test_markdown_keeps_what_is_said():
    text = markdown.render(BLOCKS)
    assert text.startswith("# Campaign `x`\n\n5 \\< 6 &amp; **so** it \\_is\\_ `<b>`\n")
    assert "| `a\\|b` | 1 |" in text
    assert "|---|--:|" in text
    assert "```sh\ncavalcade trial . a --out b && echo <\n```" in text
    assert "![A figure](figures/f.png)" in text


def test_the_page_is_whole_and_needs_nothing_else():
    text = page.render("T & t", BLOCKS, TRIALS)
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert all(source.startswith(("data:", "#")) for source in reader.sources)
    assert "<title>T &amp; t</title>" in text
    assert "5 &lt; 6 &amp; <strong>so</strong>" in text
    assert 'href="#verdict"' in text
    assert "{{" not in text
    assert "a</script>" not in text
    assert "data:image/svg+xml;base64,PHN2Zy8+" in text


def test_what_trials_say_is_no_markup():
    assert code("a`b") == "`a'b`"
    assert plain("**loud**") == "* *loud* *"


def test_empty_columns_go():
    table = Table(("a", "b", "c", "d"), (("x", "–", "1", "w"),), 1, words=(3,))
    found = without_empty_columns(table)
    assert found.head == ("a", "c", "d")
    assert [found.is_word(k) for k in range(3)] == [True, False, True]
