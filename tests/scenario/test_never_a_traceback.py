"""Whatever stands in a scenario file, the answer is a scenario or one clear line."""

from __future__ import annotations

import copy
import warnings
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.scenario import (
    Scenario,
    build_world,
    dump_scenario,
    load_scenario,
    parse_scenario,
    resolve_scenario,
    scenario_names,
)
from cavalcade.scenario.shipped import LIBRARY

pytestmark = pytest.mark.filterwarnings("ignore::cavalcade.scenario.ScenarioWarning")

_FEW = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

_WORDS = st.sampled_from(
    [
        *("version", "name", "world", "robots", "task", "planner", "execution", "events", "at"),
        *("map", "empty", "generate", "movingai", "barn", "terrain", "size", "kind", "seed"),
        *("obstacles", "box", "circle", "polygon", "center", "radius", "points", "yaw", "start"),
        *("formation", "shape", "goals", "slots", "connections", "a", "b", "add", "move", "to"),
        *("remove", "lose", "rejoin", "speed", "square", "line", "custom", "go1", "individual"),
        *("goal", "gap", "rough", "step", "width", "height", "method", "cbs", "auto", "leaps"),
        *("unicycle", "spirit", "budget", "iterations", "origin", "constraints", "static"),
    ]
)
_VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=6)
    | _WORDS
    | st.sampled_from([0, 1, -1, 1e308, 2**63, 10**400, "1e400", "../x", "\x00", "2024-01-01"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_WORDS, inner, max_size=4),
    max_leaves=15,
)


def _shipped() -> dict[str, dict[str, Any]]:
    found = {}
    for name in scenario_names():
        if name != "office":  # its map is a file beside the library, not beside the test
            found[name] = yaml.safe_load((LIBRARY / f"{name}.yaml").read_text(encoding="utf-8"))
    return found


_SHIPPED = _shipped()


def _survives(path: Path) -> Scenario | None:
    """Load, build and write; only a typed error of one line may come out."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scenario = load_scenario(path)
            # Large but legal worlds are not what is tested here.
            size = scenario.world.empty or scenario.world.generate
            if size is not None and (max(size.size) > 60 or scenario.world.resolution < 0.02):
                return None
            build_world(scenario)
    except InputError as error:
        said = str(error)
    else:
        return scenario
    assert "\n" not in said
    assert len(said) < 2000
    return None


@given(st.binary(max_size=300))
@_FEW
def test_random_bytes(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "s.yaml"
    path.write_bytes(content)
    assert _survives(path) is None


@given(_VALUES)
@_FEW
def test_random_structures(tmp_path: Path, value: object) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(yaml.safe_dump(value, allow_unicode=True), encoding="utf-8", errors="replace")
    _survives(path)


@given(st.dictionaries(st.sampled_from([*Scenario.model_fields]), _VALUES))
@_FEW
def test_random_sections_without_a_file(value: dict[str, Any]) -> None:
    try:
        said = parse_scenario(value).name
    except InputError as error:
        said = str(error)
    assert "\n" not in said


@st.composite
def _mutated(draw: st.DrawFn) -> dict[str, Any]:
    """A shipped scenario with a few places replaced, removed or renamed."""
    data = copy.deepcopy(_SHIPPED[draw(st.sampled_from(sorted(_SHIPPED)))])
    for _ in range(draw(st.integers(1, 3))):
        here: Any = data
        while True:
            keys = list(here) if isinstance(here, dict) else list(range(len(here)))
            if not keys:
                break
            key = draw(st.sampled_from(keys))
            inner = here[key]
            if isinstance(inner, dict | list) and inner and draw(st.integers(0, 3)):
                here = inner
                continue
            change = draw(st.sampled_from(["replace", "remove", "rename", "scale", "repeat"]))
            if change == "remove":
                del here[key]
            elif change == "rename" and isinstance(here, dict):
                here[draw(_WORDS)] = here.pop(key)
            elif change == "scale" and isinstance(inner, int | float) and abs(inner) < 1e300:
                here[key] = inner * draw(st.sampled_from([-1, 0, 1.01, 3, 1e3, 1e300]))
            elif change == "repeat" and isinstance(here, list):
                here.append(copy.deepcopy(inner))
            else:
                here[key] = draw(_VALUES)
            break
    return data


@given(_mutated())
@_FEW
def test_mutated_scenarios(tmp_path: Path, value: dict[str, Any]) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(yaml.safe_dump(value, allow_unicode=True), encoding="utf-8", errors="replace")
    scenario = _survives(path)
    if scenario is not None:
        # What is accepted can be written, and says the same.
        dump_scenario(scenario, tmp_path / "again.yaml")
        assert load_scenario(tmp_path / "again.yaml") == resolve_scenario(scenario)


@given(st.sampled_from(sorted(_SHIPPED)), st.data())
@_FEW
def test_damaged_text(tmp_path: Path, name: str, data: st.DataObject) -> None:
    content = bytearray((LIBRARY / f"{name}.yaml").read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    path = tmp_path / "s.yaml"
    path.write_bytes(bytes(content))
    _survives(path)


@pytest.mark.parametrize("text", ["- &a [*a]", "? [a]\n: b", "a: &b {c: *b}", "%YAML 9.9\n---\na"])
def test_odd_yaml(tmp_path: Path, text: str) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(text, encoding="utf-8")
    assert _survives(path) is None
