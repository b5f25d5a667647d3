from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.metrics.run_summary import leader_changes, role_changes
from cavalcade.metrics.summary import (
    Collisions,
    Summary,
    package_versions,
    summary_columns,
    summary_table,
)
from cavalcade.recording.frames import Recording

SQUARE = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)])


@pytest.fixture
def recording_of(straight: Any, make_scenario: Any) -> Any:
    status = straight(make_scenario(robots=3), None).status

    def make(*cycles: dict[str, Any]) -> Recording:
        made = tuple(
            replace(
                status,
                slots=SQUARE,
                **{k: np.array(v) if k != "leader" else v for k, v in c.items()},
            )
            for c in cycles
        )
        nothing = np.zeros((len(made), 3, 3))
        time = np.arange(len(made)) * 0.05
        return Recording(time, nothing, nothing, nothing, made, (), ())

    return make


@pytest.mark.parametrize(
    ("leaders", "changes"), [([0, 0, 0], 0), ([0, 1, 1, 0], 2), ([-1, 0, -1, 0, -1], 0), ([-1], 0)]
)
def test_leader_changes(recording_of: Any, leaders: list[int], changes: int) -> None:
    assert leader_changes(recording_of(*({"leader": leader} for leader in leaders))) == changes


def test_role_changes_count_every_robot(recording_of: Any) -> None:
    roles = [(0, 1, 2), (1, 0, 2), (1, 0, 2), (2, 0, 1)]
    assert role_changes(recording_of(*({"roles": r} for r in roles))) == 4


def test_losing_a_role_or_changing_shape_is_no_exchange(recording_of: Any) -> None:
    lost = recording_of({"roles": (0, 1, 2)}, {"roles": (0, 1, -1)}, {"roles": (0, 1, 2)})
    assert role_changes(lost) == 0
    reshaped = recording_of({"roles": (0, 1, 2)}, {"roles": (2, 1, 0)})
    second = replace(reshaped.status[1], slots=2 * SQUARE)
    assert role_changes(replace(reshaped, status=(reshaped.status[0], second))) == 0


def test_versions_are_plain_text() -> None:
    assert all(isinstance(value, str) and value for value in package_versions().values())


def test_the_documentation_lists_every_key_with_its_meaning() -> None:
    docs = Path(__file__).resolve().parents[2] / "docs" / "reference" / "recording.md"
    assert summary_table() in docs.read_text(encoding="utf-8")


def test_a_summary_is_a_mapping_of_plain_values() -> None:
    summary = Summary(
        name="a",
        version=1,
        seed=3,
        method="formation",
        variant="cavalcade",
        robots=2,
        success=True,
        reason="arrived",
        collisions=Collisions(1, 0),
        path_length_m=(1.5, None),
        versions={"python": "3"},
    )
    assert summary["collisions"] == {"robot_robot": 1, "robot_obstacle": 0}
    assert summary["path_length_m"] == [1.5, None]
    assert summary == json.loads(json.dumps(summary.to_dict()))
    assert list(summary) == [field.name for field in fields(Summary)]
    with pytest.raises(KeyError):
        summary["to_dict"]


def test_every_value_of_a_summary_has_a_column() -> None:
    columns = summary_columns()
    flat = {name.split(".")[0] for name in columns}
    # What a search counts differs by method: such columns are added where they are known.
    assert flat == {field.name for field in fields(Summary)} - {"counts"}
