"""From a name or a file to a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from cavalcade.errors import ScenarioError
from cavalcade.scenario import load_scenario, scenario_names, scenario_schema
from cavalcade.scenario.shipped import MAX_BYTES

Data = dict[str, Any]


@pytest.fixture
def file(tmp_path: Path, data: Data) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def test_a_file_is_read_and_remembered(file: Path) -> None:
    for given in (file, str(file)):
        scenario = load_scenario(given)
        assert scenario.name == "small"
        assert scenario.file == file


def test_a_shipped_name_is_enough() -> None:
    assert load_scenario("square-clutter").name == "square-clutter"


def test_the_folder_of_a_run_stands_for_its_scenario(file: Path) -> None:
    file.rename(file.with_name("scenario.yaml"))
    assert load_scenario(file.parent).name == "small"


def test_seed_and_overrides_win_over_the_file(file: Path) -> None:
    scenario = load_scenario(file, ["execution.seed=3", "planner.variant=no-springs"], seed=8)
    assert scenario.seed == 8
    assert scenario.planner.variant == "no-springs"


@pytest.mark.parametrize("seed", [-1, 1.5, True, "x"])
def test_a_bad_seed_is_named(file: Path, seed: Any) -> None:
    with pytest.raises(ScenarioError, match=r"execution\.seed: expected"):
        load_scenario(file, seed=seed)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("square-cluter", "did you mean square-clutter?"),
        ("no/such/file.yaml", "no such file or shipped scenario"),
        ("a\x00b", "no file can be named"),
        ("x" * 5000, "no file can be named"),
        ("", "no file can be named"),
    ],
)
def test_what_does_not_exist_is_said_with_what_does(name: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(name)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "expected a mapping with version"),
        (b"- 1\n- 2", "expected a mapping with version"),
        (b"just text", "expected a mapping with version"),
        (b"\xff\xfe\x00\x01", "not a text file"),
        (b"name: [1", "not valid YAML"),
        (b"#" * (MAX_BYTES + 1), "larger than 8 MB"),
    ],
)
def test_files_of_another_kind(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "odd.yaml"
    path.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)


def test_a_folder_is_no_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"a folder without scenario\.yaml"):
        load_scenario(tmp_path)


def test_a_byte_order_mark_is_no_obstacle(file: Path) -> None:
    file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    assert load_scenario(file).name == "small"


def test_the_schema_knows_every_section() -> None:
    schema = scenario_schema()
    assert schema["$schema"].endswith("2020-12/schema")
    assert set(schema["required"]) == {"version", "name", "world", "robots", "task"}
    assert schema["additionalProperties"] is False
    assert schema["properties"]["version"]["const"] == 1
    assert "cavalcade" in str(schema["$defs"]["PlannerSection"]["properties"]["variant"]["enum"])


def test_names_are_sorted_and_complete() -> None:
    names = scenario_names()
    assert list(names) == sorted(names)
    assert {
        "square-clutter",
        "cone",
        "triangle-lab",
        "triangle-corridor",
        "tour-ten",
        "office",
        "maze-solo",
        "infeasible",
    } <= set(names)
