"""Robot models of one's own: registered in a program, or read from a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

import cavalcade as cv
from cavalcade.robots import MODELS, check_model, load_model, robot_model

GO1 = robot_model("go1")
FIGURES = {
    "length": 0.8, "width": 0.4, "height": 0.5, "max_speed_x": 0.8, "max_speed_y": 0.3,
    "max_yaw_rate": 1, "max_acceleration": 1.0, "max_yaw_acceleration": 2.0,
}  # fmt: skip


@pytest.fixture
def mine():
    model = cv.register_model(replace(GO1, name="mine", length=0.8, width=0.4))
    yield model
    MODELS.remove("mine")


def test_a_registered_model_is_known_by_its_name(mine):
    assert robot_model("mine") is mine
    assert "mine" in MODELS
    world = cv.OccupancyMap.empty((8.0, 8.0), 0.1)
    assert (
        cv.FormationPlanner(world, cv.Formation.line(2, 1.2), robots=2, model="mine").model is mine
    )
    data = {
        "version": 1, "name": "x", "world": {"empty": {"size": [8, 8]}},
        "robots": [{"model": "mine", "start": [2, 2, 0]}],
        "task": {"formation": {"shape": "line"}, "goals": [[5, 5, 0]]},
    }  # fmt: skip
    assert cv.parse_scenario(data).models == (mine,)


def test_the_same_model_may_be_registered_again_but_no_other_of_that_name(mine):
    assert cv.register_model(replace(mine)) == mine
    with pytest.raises(cv.InputError, match="name: there is another robot model 'mine'"):
        cv.register_model(replace(mine, width=0.5))
    with pytest.raises(cv.InputError, match="another robot model 'go1'"):
        cv.register_model(replace(GO1, width=0.5))


def test_a_model_is_gone_when_it_is_removed_and_shipped_ones_stay(mine):
    cv.register_model(replace(mine, name="other"))
    MODELS.remove("other")
    with pytest.raises(cv.InputError, match=r"unknown robot model 'other' .*go1"):
        robot_model("other")
    for name in ("go1", "other"):
        with pytest.raises(cv.InputError, match="was added"):
            MODELS.remove(name)


@pytest.mark.parametrize("name", MODELS)
def test_what_comes_with_the_package_fits(name):
    check_model(robot_model(name))


BAD = [
    ("name", "", "expected a name"),
    ("name", "a b", "expected a name"),
    ("name", "x.yaml", "expected a name"),
    ("length", 0.0, "expected 0.01 to 100, got 0"),
    ("width", float("nan"), "expected 0.01 to 100, got nan"),
    ("height", "tall", "expected a number"),
    ("max_speed_x", True, "expected a number"),
    ("max_speed_y", -1.0, "expected 0 to 100"),
    ("max_speed_y", 0.0, "moves sideways"),
    ("max_acceleration", 0.5, "max_speed_x * max_yaw_rate, 0.6, which turning at full speed"),
    ("drive", "hover", "unknown drive (one of: legged, unicycle"),
    ("round", True, "the same length and width"),
]


@pytest.mark.parametrize(("key", "value", "message"), BAD)
def test_a_model_that_nothing_can_plan_for_is_refused(tmp_path, key, value, message):
    with pytest.raises(cv.InputError) as caught:
        cv.register_model(replace(GO1, **{"name": "mine", key: value}))
    assert str(caught.value).startswith(f"{key}: ")
    assert message in str(caught.value)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"like": "go1", key: value}))
    with pytest.raises(cv.InputError) as caught:
        load_model(path)
    assert str(caught.value).startswith(f"{path}: {key}: ")
    assert message in str(caught.value)


def test_a_file_says_all_or_what_it_is_like(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(FIGURES))
    model = load_model(path)
    assert {key: getattr(model, key) for key in FIGURES} == FIGURES
    assert (model.name, model.source, model.legs) == ("mine", "mine.yaml", None)
    path.write_text("{name: wide, like: go1, width: 0.4, source: tape measure}")
    assert load_model(path) == replace(GO1, name="wide", width=0.4, source="tape measure")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a mapping of keys such as name"),
        ("a: [", "not valid YAML"),
        ("{length: 1}", "width: is missing, and so are height, max_speed_x, "),
        ("{length: 1}", "; or say what it is like, as `like: go1`"),
        ("{like: go1, max_sped_x: 1}", "max_sped_x: unknown key; did you mean max_speed_x? (one"),
        ("{like: go1, 7: 1}", "7: unknown key (one of: like"),
        ("{like: go1, colour: red}", "colour: unknown key (one of: like, name, length"),
        ("{like: go9}", "like: unknown robot model 'go9' (one of: go1"),
        ("{like: [go1]}", "like: unknown robot model"),
        ("{like: go1, round: 1.5}", "round: expected yes or no"),
        ("{like: go1, source: [a]}", "source: expected text"),
        ("{like: go1, name: go2}", "name: there is another robot model 'go2'"),
        ("{like: go1, drive: [legged]}", "drive: unknown drive"),
    ],
)
def test_bad_files_are_one_clear_line(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(cv.InputError) as caught:
        load_model(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


SCENARIO = """
version: 1
name: own
world: {empty: {size: [8, 6]}}
robots:
  - {model: robots/mine.yaml, start: [2, 2, 0]}
  - {model: robots/mine.yaml, start: [2, 4, 0]}
task: {formation: {shape: line, spacing: 1.4}, goals: [[5, 3, 0]]}
"""


@pytest.fixture
def scenario_file(tmp_path) -> Path:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "mine.yaml").write_text("{like: go1, width: 0.4}")
    (tmp_path / "own.yaml").write_text(SCENARIO)
    return tmp_path / "own.yaml"


def test_a_scenario_names_the_file_and_what_is_dumped_finds_it(scenario_file, tmp_path):
    scenario = cv.load_scenario(scenario_file)
    assert [model.name for model in scenario.models] == ["mine", "mine"]
    assert scenario.models[0].width == 0.4
    (tmp_path / "runs").mkdir()
    cv.dump_scenario(scenario, tmp_path / "runs" / "scenario.yaml")
    text = (tmp_path / "runs" / "scenario.yaml").read_text()
    assert "model: ../robots/mine.yaml" in text
    again = cv.load_scenario(tmp_path / "runs" / "scenario.yaml")
    assert again.models == scenario.models
    with pytest.raises(cv.ScenarioError, match=r"robots\[0\].model: unknown robot model 'go9'"):
        cv.load_scenario(scenario_file, ["robots.0.model=go9"])


def test_a_name_that_no_file_can_have_is_refused(scenario_file):
    with pytest.raises(cv.ScenarioError, match=r"robots\[0\].model: expected a file name of"):
        cv.load_scenario(scenario_file, {"robots.0.model": "a\0b.yaml"})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "no such file"),
        ("{like: go1, width: 0}", "width: expected 0.01 to 100, got 0"),
        ("{like: go1, colour: red}", "colour: unknown key (one of: like"),
    ],
)
def test_a_bad_file_is_named_with_its_key_and_its_place_in_the_scenario(
    scenario_file, text, message
):
    file = scenario_file.parent / "robots" / "mine.yaml"
    file.unlink() if text is None else file.write_text(text)
    with pytest.raises(cv.ScenarioError) as caught:
        cv.load_scenario(scenario_file)
    assert str(caught.value).startswith(f"{scenario_file}: robots[0].model: {file}: {message}")


def test_a_run_of_it_passes_the_check(scenario_file, tmp_path):
    result = cv.run(cv.load_scenario(scenario_file), out=tmp_path / "run")
    assert result.summary["success"]
    assert cv.check(tmp_path / "run").ok


def test_a_file_given_for_a_name_is_told_how_files_are_read(tmp_path):
    with pytest.raises(cv.InputError, match=r"'mine\.yaml'; cavalcade\.robots\.load_model reads"):
        robot_model("mine.yaml")
