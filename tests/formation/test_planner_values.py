"""Arguments of the wrong kind and robots that cannot be driven are named, never a raw exception."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.formation import Springs
from cavalcade.robots import MODELS

GO1 = cv.robot_model("go1")
ROOM = cv.OccupancyMap.empty((8.0, 5.0), 0.05)
SQUARE = cv.Formation.square()
STARTS = np.column_stack([SQUARE.placed((1.5, 2.5, 0.0)), np.zeros(4)])
CIRCLE = cv.Circle((3.0, 2.0), 0.3)


def planner_of(**values) -> cv.FormationPlanner:
    return cv.FormationPlanner(**{"map": ROOM, "formation": SQUARE, **values})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"settings": {}}, "settings: expected FormationSettings or a preset's name, got a dict"),
        ({"map": np.zeros((3, 3))}, "map: expected an OccupancyMap, got a ndarray"),
        ({"formation": "square"}, "formation: expected a Formation, got 'square'"),
        ({"model": ["go1"] * 4}, "model: expected a RobotModel or the name of one, got a list"),
        ({"model": None}, "model: expected a RobotModel or the name of one, got None"),
        ({"robots": 4.0}, "robots: expected a whole number, got 4.0"),
        ({"variant": ["cavalcade"]}, "unknown variant a list"),
        ({"rate": "20"}, "rate: expected a number, got '20'"),
        ({"rate": 1e9}, "rate: expected a number from 0.1 to 1000 Hz"),
        ({"seed": 0.5}, "seed: expected a whole number"),
        ({"expected": 0.1}, "expected: expected an Imperfections"),
        ({"lookahead": [1.0]}, "lookahead: expected a number"),
    ],
)
def test_arguments_of_the_planner(values, message):
    with pytest.raises(cv.InputError) as caught:
        planner_of(**values)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: p.set_goal("kitchen"), "goal: expected a pose (x, y, yaw), got 'kitchen'"),
        (lambda p: p.set_goal((1.0, 2.0)), "goal: expected a pose (x, y, yaw), got an array of"),
        (lambda p: p.set_goals([[1, 2, 3], [4]]), "goal: expected poses (x, y, yaw), got rows"),
        (lambda p: p.update_map(np.zeros((9, 9))), "map: expected an OccupancyMap"),
        (
            lambda p: p.set_dynamic_obstacles([CIRCLE]),
            "obstacles[0]: expected a list of DynamicObstacle(shape, velocity), got a Circle",
        ),
        (lambda p: p.set_dynamic_obstacles(None), "obstacles: expected a list"),
        (lambda p: p.set_formation("line"), "formation: expected a Formation"),
        (lambda p: p.lose("robot 2"), "robot: expected a whole number"),
        (lambda p: p.lose(True), "robot: expected a whole number"),
        (lambda p: p.step(STARTS, "now"), "time: expected a number, got 'now'"),
        (lambda p: p.step(STARTS, None), "time: expected a number"),
        (lambda p: p.step(STARTS.tolist()[:3], 0.0), "poses: expected (4, 3) poses"),
        (lambda p: p.step([[0.0], [1.0, 2.0]], 0.0), "poses: expected (4, 3) poses, got rows"),
        (lambda p: p.step(np.ma.masked_less(STARTS, 1.0), 0.0), "poses: expected (4, 3) poses, s"),
        (lambda p: p.step(STARTS, 0.0, "old"), "stamps: expected (4,) times"),
        (lambda p: p.step(STARTS, 0.0, [0.0, np.nan, 0.0, 0.0]), "stamps: expected (4,) times"),
    ],
)
def test_arguments_while_driving(call, message):
    planner = planner_of()
    planner.set_goal((6.0, 2.5, 0.0))
    with pytest.raises(cv.InputError) as caught:
        call(planner)
    assert message in str(caught.value)
    assert np.isfinite(planner.step(STARTS, 0.05)).all()
    assert planner.status.state != "inactive"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300, "fast", None])
def test_one_bad_velocity_does_not_poison_the_team(value):
    with pytest.raises(cv.InputError, match="velocity: expected"):
        cv.DynamicObstacle(CIRCLE, (value, 0.0))
    with pytest.raises(cv.InputError, match="shape: expected a Box, Circle or Polygon"):
        cv.DynamicObstacle(value, (0.1, 0.0))


@pytest.mark.parametrize("speed", [0.0, 1e-9, 0.5, 30.0, 1e6])
def test_whatever_moves_commands_are_finite(speed):
    planner = planner_of(expected=cv.Imperfections(position=0.01, delay=0.2))
    planner.set_goal((6.0, 2.5, 0.0))
    planner.set_dynamic_obstacles([cv.DynamicObstacle(CIRCLE, (-speed, speed))])
    for cycle in range(5):
        commands = planner.step(STARTS, 0.05 * cycle)
        assert np.isfinite(commands).all()
        assert np.abs(commands).max() <= GO1.max_yaw_rate


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"max_acceleration": np.inf}, "need a finite max_acceleration"),
        ({"max_yaw_acceleration": np.inf}, "need a finite max_yaw_acceleration"),
        ({"max_acceleration": 0.59}, "max_acceleration: expected at least"),
        ({"max_speed_y": 0.0}, "moves sideways"),
        ({"drive": "unicycle"}, "move sideways, too"),
        ({"drive": "unicycle-2"}, "move sideways, too"),
    ],
)
def test_robots_that_cannot_move_in_formation_are_refused(values, message):
    model = replace(GO1, name="own", **values)
    for make in (lambda: planner_of(model=model), lambda: cv.SafetyFilter(model, 0.05)):
        with pytest.raises(cv.InputError) as caught:
            make()
        assert message in str(caught.value)


@pytest.mark.parametrize("name", MODELS)
def test_models_that_there_are_drive_or_are_refused(name):
    model = cv.robot_model(name)
    limited = np.isfinite([model.max_acceleration, model.max_yaw_acceleration]).all()
    if model.drive.startswith("unicycle") or not limited:
        with pytest.raises(cv.InputError, match=f"model: .*{name}"):
            planner_of(model=name)
        return
    planner = planner_of(model=name)
    planner.set_goal((6.0, 2.5, 0.0))
    for cycle in range(3):
        assert np.isfinite(planner.step(STARTS, 0.05 * cycle)).all()


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("length", [np.nan, 0.0, -1.0, 1e9, "0.6", None, True]),
        ("max_speed_x", [np.nan, np.inf, 0.0, -0.5]),
        ("max_acceleration", [np.nan, 0.0, -1.0]),
        ("tracking_error", [np.nan, -0.1]),
        ("name", ["", None, "a b"]),
        ("drive", ["hover", None, []]),
        ("legs", ["four"]),
        ("round", [1, "yes"]),
    ],
)
def test_a_model_checks_itself(key, values):
    for value in values:
        with pytest.raises(cv.InputError) as caught:
            replace(GO1, **{key: value})
        assert caught.value.key == key


@pytest.mark.parametrize("name", MODELS)
def test_the_text_of_a_model_fits_on_a_screen(name):
    assert len(repr(cv.robot_model(name))) < 600


def test_laws_of_springs_check_themselves():
    law = SQUARE.connections[0].law
    with pytest.raises(cv.InputError, match="k_rep"):
        replace(law, k_rep=np.nan)
    with pytest.raises(cv.InputError, match=r"springs\.sides"):
        Springs("stiff", law)
    with pytest.raises(cv.InputError, match="law"):
        cv.Connection(0, 1, 1.0, "stiff")
    with pytest.raises(cv.InputError, match="rest_length"):
        cv.Connection(0, 1, np.inf, law)
