"""What is masked is unknown: no value that stands below a mask is ever used."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking import check_motion
from cavalcade.coordination import TeamProblem
from cavalcade.eikonal import TravelGrid, arrival_times, surface_distance
from cavalcade.errors import InputError
from cavalcade.fleet import IdealFleet
from cavalcade.formation import Formation, FormationPlanner, SafetyInputs
from cavalcade.lattice.ground import make_ground
from cavalcade.robots import robot_model
from cavalcade.values import number_array, real_array
from cavalcade.world import Circle, OccupancyMap, Terrain

_FILLS = (0, 1, 5)
"""Values below the mask: none of them may matter."""


def _wall(fill: float, value: float = 1.0, rows: int = 9, cols: int = 15) -> np.ma.MaskedArray:
    """A grid whose middle column is masked."""
    grid = np.full((rows, cols), value)
    grid[:, cols // 2] = fill
    mask = np.zeros((rows, cols), bool)
    mask[:, cols // 2] = True
    return np.ma.array(grid, mask=mask)


@pytest.mark.parametrize("fill", [*_FILLS, np.nan, -1.0, np.inf])
def test_fronts_marched_through_masked_walls(fill):
    times = arrival_times(_wall(fill), [(4, 0)], 0.1)
    assert np.isfinite(times[:, :7]).all()
    assert np.isinf(times[:, 7:]).all()
    assert not np.ma.isMaskedArray(times)
    grid = TravelGrid(_wall(fill), 0.1)
    assert not grid.is_free((0.75, 0.45))
    assert grid.speed[0, 7] == 0.0


@pytest.mark.parametrize("fill", _FILLS)
def test_distances_were_measured_past_masked_cells(fill):
    masked = _wall(fill, 0.0).astype(bool)
    open_ended = surface_distance(masked, 0.1, border=False)
    assert open_ended[4, 6] == pytest.approx(0.05)
    assert open_ended[4, 7] == 0.0


@pytest.mark.parametrize("fill", _FILLS)
@pytest.mark.parametrize("kind", [bool, np.int8, np.uint8, np.int64, "rows"])
def test_masked_cells_of_maps_became_free(fill, kind):
    given = _wall(fill, 0.0).astype(np.int8 if kind == "rows" else kind)
    map = OccupancyMap(list(given) if kind == "rows" else given, 0.1)
    assert (map.grid[:, 7] == -1).all()
    assert map.occupied[:, 7].all()
    assert not map.occupied[:, :7].any()
    assert not OccupancyMap(given, 0.1, unknown="free").occupied.any()


def test_what_a_mask_hides_need_not_be_a_value_of_a_map():
    grid = np.ma.array([[0, 255], [100, -7]], mask=[[0, 1], [0, 1]])
    assert OccupancyMap(grid, 0.1).grid.tolist() == [[0, -1], [100, -1]]
    with pytest.raises(InputError, match="grid: occupancy values"):
        OccupancyMap(grid.data, 0.1)


@pytest.mark.parametrize("fill", [-9999.0, 0.0, np.nan, 1e30])
def test_masked_heights_became_pits(fill):
    terrain = Terrain.from_heights(_wall(fill, 0.5, 40, 61), 0.05)
    assert terrain.height.min() == pytest.approx(0.5)
    assert terrain.in_hole([[30.5 * 0.05, 1.0]]).all()
    assert not terrain.in_hole([[0.2, 1.0]]).any()
    with pytest.raises(InputError, match="height: expected finite numbers"):
        Terrain(_wall(0.0), _wall(0.0), terrain.normals, terrain.traversability, 0.05)


POSES = np.array([[1.0, 2.0, 0.0], [3.0, 2.0, 0.0], [1.0, 4.0, 0.0], [3.0, 4.0, 0.0]])
ROOM = OccupancyMap.empty((8.0, 6.0))
GO1 = robot_model("go1")


def _uses(poses, key):
    """Every way in for poses, and the key it gives to them."""
    planner = FormationPlanner(ROOM, Formation.square())
    return {
        "step": lambda: planner.step(poses, 0.0),
        "goals": lambda: planner.set_goals(poses),
        "goal": lambda: planner.set_goal(poses[0]),
        "filter": lambda: SafetyInputs.of(ROOM, poses, POSES * 0, POSES * 0),
        "fleet": lambda: IdealFleet([GO1] * 4, poses),
        "send": lambda: IdealFleet([GO1] * 4, POSES).send(poses),
        "problem": lambda: TeamProblem.on_map(ROOM, ["go1"] * 4, poses, POSES),
        "parts": lambda: TeamProblem(make_ground(ROOM), (GO1,) * 4, POSES, poses),
        "slots": lambda: Formation.custom([row[:2] for row in poses]),
        "places": lambda: ROOM.cell_of([row[:2] for row in poses]),
        "distance": lambda: Circle((0.0, 0.0), 1.0).distance([row[:2] for row in poses]),
        "checked": lambda: check_motion([0.0, 1.0], [poses, poses], [GO1] * 4, size=(8, 6)),
    }[key]


_WAYS = ("step", "goals", "goal", "filter", "fleet", "send", "problem", "parts", "slots", "places",
         "distance", "checked")  # fmt: skip


@pytest.mark.parametrize("way", _WAYS)
def test_masked_poses_were_taken_as_known(way):
    masked = np.ma.array(POSES, mask=np.zeros((4, 3), bool))
    _uses(masked, way)()
    masked.mask[0, 1] = True
    with pytest.raises(InputError):
        _uses(masked, way)()


@pytest.mark.parametrize("way", _WAYS)
@pytest.mark.parametrize(
    "poses",
    [
        [["1", 2.0, 0.0], *POSES[1:].tolist()],
        [["east", 2.0, 0.0], *POSES[1:].tolist()],
        [[None, 2.0, 0.0], *POSES[1:].tolist()],
        [[1.0 + 2.0j, 2.0, 0.0], *POSES[1:].tolist()],
        [[[1.0], 2.0, 0.0], *POSES[1:].tolist()],
    ],
)
def test_texts_and_ragged_rows_ended_in_numpys_words(way, poses):
    with pytest.raises(InputError):
        _uses(poses, way)()


@pytest.mark.parametrize("poses", [[[1.0, 2.0, 0.0], [3.0, 2.0]], "here", None, 5.0, {}])
@pytest.mark.parametrize("way", ["step", "fleet", "problem", "parts", "filter"])
def test_ragged_teams_are_refused(way, poses):
    with pytest.raises(InputError, match=r"(poses|starts|goals): "):
        _uses(poses, way)()


@pytest.mark.parametrize("time", ["now", None, [0.0], "0.0"])
def test_times_that_are_no_numbers(time):
    planner = FormationPlanner(ROOM, Formation.square())
    with pytest.raises(InputError, match="time: expected"):
        planner.step(POSES, time)
    with pytest.raises(InputError, match="stamps: "):
        planner.step(POSES, 0.0, [time] * 4)


def test_numbers_of_any_kind_are_taken():
    for values in ([1, 2], (1.0, 2), np.array([1, 2], np.uint8), np.float32([1, 2])):
        assert real_array(values, "x", "numbers").tolist() == [1.0, 2.0]
        assert number_array(values, "x", (2,), "two numbers").tolist() == [1.0, 2.0]
    own = np.zeros(2)
    number_array(own, "x", (2,), "two numbers")[0] = 1.0
    assert own[0] == 0.0
