"""Scenario files out: a file that says by itself everything that was run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from cavalcade.files import write_file
from cavalcade.robots import is_model_file
from cavalcade.scenario.fields import OneLine, Section
from cavalcade.scenario.model import Scenario
from cavalcade.scenario.rules import UNUSED_KEYS
from cavalcade.scenario.task import INDIVIDUAL, FormationSection, TaskSection
from cavalcade.scenario.worlds import resolve_scenario
from cavalcade.values import instance_of, path_of


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]  # PyYAML has no types
    """Plain values only; nothing is shared, so nothing gets an anchor."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_representer(
    OneLine,
    lambda dumper, data: dumper.represent_mapping(
        "tag:yaml.org,2002:map", data.items(), flow_style=True
    ),
)


def dump_scenario(scenario: Scenario, path: str | Path) -> None:
    """Write a scenario with every default and override written out.

    A `generate` or `barn` source becomes `empty` with the obstacles listed, so that the file
    alone says where they stand; generated terrain is written with its seed. Names of maps,
    terrains and robot models are written relative to the new file. Reading the file gives
    `resolve_scenario(scenario)`.

    Raises:
        ScenarioError, MapError: The world cannot be made.
        OutputError: The file cannot be written.
    """
    path = path_of(path)
    instance_of(scenario, Scenario, "scenario")
    write_file(path, scenario_text(_plain(resolve_scenario(scenario), Path(path).parent)))


def scenario_text(data: Mapping[str, Any]) -> str:
    """The YAML of a scenario's plain data as it stands; what is `OneLine` is on one line."""
    text: str = yaml.dump(
        dict(data),
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=10**9,
    )
    return text


def _plain(scenario: Scenario, folder: Path) -> dict[str, Any]:
    data = scenario.model_dump(mode="json", exclude={"world", "robots"})
    world = scenario.world.model_dump(mode="json", exclude_none=True)
    if scenario.world.generate is not None:
        world["generate"] = scenario.world.generate.to_dict()
    world["obstacles"] = [OneLine(obstacle) for obstacle in world["obstacles"]]
    robots = [_line(robot) for robot in scenario.robots]
    names = [(world, "map"), (world, "terrain"), (world.get("movingai", {}), "file")]
    names += [(robot, "mjcf") for robot in robots]
    names += [(robot, "model") for robot in robots if is_model_file(robot["model"])]
    for place, key in names:
        if key in place:
            place[key] = _relative(Path(place[key]), folder)
    data["task"] = _task(scenario.task, data["task"])
    for key in UNUSED_KEYS[scenario.task.kind]:
        del data["planner"][key]
    events = [_line(event) for event in scenario.execution.events]
    for said, event in zip(events, scenario.execution.events, strict=True):
        if event.formation is not None:
            said["formation"] = _formation(event.formation)
    data["execution"]["events"] = events
    data |= {"world": world, "robots": robots}
    return {key: data[key] for key in Scenario.model_fields}


def _line(section: Section) -> OneLine:
    """What is said in a section, on one line."""
    return OneLine(section.model_dump(mode="json", exclude_none=True))


def _task(task: TaskSection, said: dict[str, Any]) -> dict[str, Any]:
    """The dumped `task` section without what does not apply."""
    if task.formation is not None:
        return {"formation": _formation(task.formation), "goals": said["goals"]}
    if task.commands is None:
        return {"goals": INDIVIDUAL}
    return {"commands": [_line(one) for one in task.commands], "duration": said["duration"]}


def _formation(formation: FormationSection) -> dict[str, Any]:
    said = formation.model_dump(mode="json", exclude_none=True)
    joints = formation.connections
    # Null stands for the shape's own springs: that is a choice, and is written out.
    lines = [OneLine(joint.model_dump(mode="json")) for joint in joints or ()]
    said["connections"] = None if joints is None else lines
    return said


def _relative(path: Path, folder: Path) -> str:
    path, folder = path.resolve(), folder.resolve()
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # on another drive
        return path.as_posix()
