import pytest

from cavalcade.campaign.table import is_private, scrubbed


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("OSError: /tmp/a/b/run.yaml: no such file", "OSError: run.yaml: no such file"),
        ("ValueError: bad (/usr/lib/p/foo.py:12)", "ValueError: bad (foo.py:12)"),
        ("at ../shared/data/x.pgm and ~/x/y.png", "at x.pgm and y.png"),
        ("C:\\Users\\x\\a.yaml is bad", "a.yaml is bad"),
        ("see file:" + "//" + "/a/x/y.html", "see y.html"),
        ("worker 1234 died (pid=33)", "worker died (pid)"),
        ("lost host: abc.local at 10.0.0.1:80", "lost host at host"),
        ("two\nlines", "two lines"),
    ],
)  # fmt: skip
def test_what_says_where_it_was_made_is_taken_out(text, kept):
    assert scrubbed(text) == kept


@pytest.mark.parametrize(
    "text",
    [
        "robot 2 within 0.10 m at 3.0 s; wall [3.1, 2]",
        "1.2 m/s over 3/4 of the way, a / b, -/+",
        "watchdog: robot 1 leaves its envelope (0.31 m)",
        "",
    ],
)
def test_everything_else_stays(text):
    assert scrubbed(text) == text


def test_private_keys():
    assert is_private("pid")
    assert is_private("Host")
    assert not is_private("path_length_m")
