"""What of the Go2 fleet needs neither robots nor the vendor's SDK."""

from __future__ import annotations

import gc
import importlib.util
import math
import mmap
import os
from typing import Any

import pytest

from cavalcade.errors import InputError, ScenarioError
from cavalcade.fleet.unitree import Go2Fleet, Go2Link, load_sdk
from cavalcade.fleet.unitree.records import Order, Report, SharedRecords, Slot, Stage, Wish
from cavalcade.fleet.unitree.robot import Robot
from cavalcade.fleet.unitree.sport import Api, meaning_of, name_of, posture_of
from cavalcade.scenario import load_scenario

ORDER = Order(12.5, Wish.MOVE, 3, 0.5, -0.25, 1.0)


def test_records_hold_what_was_written_last() -> None:
    records = SharedRecords()
    other = SharedRecords(records.file)  # as the helper has them
    assert other.order.read() is None
    records.order.write(Order(1.0, Wish.STAND, 1, 0.0, 0.0, 0.0))
    records.order.write(ORDER)
    report = Report(
        1.0, 3, Stage.READY, 2.0, 1, 2, math.pi, 0.1, 0.2, 7, 1001, 80.0, 1008, 4201, 9.0
    )
    other.report.write(report)
    assert other.order.read() == ORDER
    assert records.report.read() == report


def test_robots_that_were_closed_leave_nothing_open() -> None:
    def opened() -> int:
        gc.collect()
        return len(os.listdir("/proc/self/fd"))

    before = opened()
    robots = [Robot(number, f"robot_{number}", Go2Link(), None, 0.0) for number in range(5)]
    assert opened() > before
    for robot in robots:
        robot.close()
        robot.close()
        robot.look()
    del robot, robots
    assert opened() == before


@pytest.mark.parametrize("broken", [0, 8, 24, 51])
def test_a_record_whose_writer_died_while_writing_is_none(broken: int) -> None:
    memory = mmap.mmap(-1, 128)
    slot = Slot(memory, 0, Order)
    slot.write(ORDER)
    memory[broken] ^= 1
    assert slot.read() is None
    slot.write(ORDER)
    assert slot.read() == ORDER


@pytest.mark.parametrize(
    ("error_code", "mode", "posture"),
    [
        (1001, 0, "damping"),
        (0, 7, "damping"),
        (1002, 0, "locked"),
        (1002, 1, "locked"),
        (0, 6, "locked"),
        (2006, 0, "lying"),
        (0, 5, "lying"),
        (1013, 0, "ready"),
        (100, 0, "ready"),
        (0, 0, "ready"),
        (0, 1, "ready"),
        (0, 3, "ready"),
    ],
)
def test_postures_of_old_and_new_firmware(error_code: int, mode: int, posture: str) -> None:
    assert posture_of(error_code, mode) == posture


def test_requests_and_codes_have_names() -> None:
    assert [name_of(api) for api in (Api.STAND_UP, 1008, 77)] == ["StandUp", "Move", "request 77"]
    assert "not initialised" in meaning_of(4202)
    assert meaning_of(99) == "unknown to the SDK"


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        ({"domain": -1}, "domain"),
        ({"domain": 233}, "domain"),
        ({"domain": True}, "domain"),
        ({"interface": ""}, "interface"),
        ({"interface": 'e"th'}, "interface"),
        ({"interface": 1}, "interface"),
        ({"pose_source": "mocap"}, "pose_source"),
        ({"offset": (0.0, 1.0)}, "offset"),
        ({"offset": (0.0, 1.0, math.nan)}, "offset"),
        ({"battery_min": 101}, "battery_min"),
        ({"battery_min": math.nan}, "battery_min"),
    ],
)
def test_links_that_cannot_be_are_refused(wrong: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError, match=rf"^{key}"):
        Go2Link(**wrong)


def test_two_robots_at_one_place_are_refused() -> None:
    with pytest.raises(
        InputError, match=r"links\[2\]: robots 0 and 2 are both in domain 1 on eth1"
    ):
        Go2Fleet(
            [Go2Link(1, "eth1"), Go2Link(2, "eth1"), Go2Link(1, "eth1")], starts=[(0, 0, 0)] * 3
        )
    with pytest.raises(InputError, match=r"expected a robot"):
        Go2Fleet([])


def test_odometry_needs_a_place_on_the_map() -> None:
    with pytest.raises(InputError, match=r"links\[1\]\.offset: expected an offset, or starts"):
        Go2Fleet([Go2Link(offset=(0, 0, 0)), Go2Link(1)])


@pytest.mark.skipif(importlib.util.find_spec("unitree_sdk2py") is not None, reason="it is there")
def test_a_missing_sdk_is_said_with_how_to_get_it() -> None:
    with pytest.raises(InputError, match=r"pip install 'cavalcade\[unitree\]'"):
        load_sdk()


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        ("[]", r"execution.unitree.robots: expected the place of each of 4 robots .*got 0"),
        ("[{domain: 1}]", r"execution.unitree.robots: .*got 1"),
        (
            "[{domain: 1}, {interface: eth1}, {domain: 1, interface: eth1}, {domain: 1}]",
            r"execution.unitree.robots\[3\]: is where robot 0 is",
        ),
        ("[{domain: 233}]", r"execution.unitree.robots\[0\].domain: "),
        ("[{battery_min: 101}]", r"execution.unitree.robots\[0\].battery_min: "),
    ],
)
def test_scenarios_say_where_each_go2_is(robots: str, message: str) -> None:
    overrides = ["execution.backend=unitree", f"execution.unitree.robots={robots}"]
    with pytest.raises(ScenarioError, match=message):
        load_scenario("square-clutter", overrides=overrides)


def test_places_of_go2s_mean_nothing_to_other_backends() -> None:
    scenario = load_scenario("square-clutter", overrides=["execution.unitree.robots=[{domain: 1}]"])
    assert scenario.execution.unitree.robots[0].domain == 1
