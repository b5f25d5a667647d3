from __future__ import annotations

import pytest

from cavalcade.coordination import PlanSettings
from cavalcade.jobs.planning import settings_of


def test_without_words_the_defaults_hold(make_scenario):
    assert settings_of(make_scenario()) == PlanSettings()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({"constraints": "static"}, {"constraints": "static"}),
        ({"conflict": "earliest"}, {"conflict": "earliest"}),
        ({"leaps": False}, {"leaps": False}),
        ({"improve": 500}, {"improve": 500}),
        (
            {"budget": {"iterations": 9, "seconds": 2.5}},
            {"iterations": 9, "seconds": 2.5},
        ),
        (
            {"variant": "published"},
            {"variant": "published", "constraints": "static", "conflict": "first"},
        ),
        (
            {"variant": "published", "constraints": "timed"},
            {"variant": "published", "constraints": "timed", "conflict": "first"},
        ),
    ],
)
def test_words_go_over_the_defaults(make_scenario, words, expected):
    assert settings_of(make_scenario(**words)) == PlanSettings(**expected)
