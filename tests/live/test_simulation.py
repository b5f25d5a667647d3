"""Simulated robots and their scanners; none of it needs ROS."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.geometry import Array
from cavalcade.live.laser import scan_team
from cavalcade.live.simulation import Simulation
from cavalcade.scenario import parse_scenario
from cavalcade.world import OccupancyMap


def simulation_of(**execution: object) -> Simulation:
    return Simulation(
        parse_scenario(
            {
                "version": 1,
                "name": "two",
                "world": {"empty": {"size": [6.0, 4.0]}},
                "robots": [{"model": "go1", "start": [1.0, y, 0.0]} for y in (1.0, 3.0)],
                "task": {
                    "formation": {"shape": "line", "spacing": 2.0},
                    "goals": [[5.0, 2.0, 0.0]],
                },
                "execution": execution,
            }
        )
    )


def reference(area: OccupancyMap, poses: Array, bodies: Array, rays: int, reach: float) -> Array:
    """Looks along every ray in steps of a millimetre."""
    lengths = np.arange(0.0, reach, 1e-3)
    found = np.full((len(poses), rays), np.inf)
    for robot, (x, y, yaw) in enumerate(poses):
        for ray in range(rays):
            angle = yaw - math.pi + 2.0 * math.pi * ray / rays
            points = np.array([x, y]) + lengths[:, None] * (math.cos(angle), math.sin(angle))
            cells = area.cell_of(points)
            inside = ((cells >= 0) & (cells < area.occupied.shape)).all(axis=1)
            hit = ~inside
            hit[inside] = area.occupied[tuple(cells[inside].T)]
            for other, (ox, oy, oyaw) in enumerate(poses):
                if other != robot:
                    c, s = math.cos(oyaw), math.sin(oyaw)
                    u, v = ((points - (ox, oy)) @ np.array([[c, -s], [s, c]])).T
                    length, width, disc = bodies[other]
                    box = (np.abs(u) <= 0.5 * length) & (np.abs(v) <= 0.5 * width)
                    hit |= np.hypot(u, v) <= disc if disc else box
            if hit.any():
                found[robot, ray] = lengths[hit.argmax()]
    return found


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (-1.0, 2.0, 0.7)])
def test_scans_measure_what_is_there(origin: tuple[float, float, float]) -> None:
    random = np.random.default_rng(3)
    grid = random.random((40, 60)) < 0.02
    grid[15:25, 20:40] = False
    area = OccupancyMap(grid, 0.1, origin)
    places = area.to_map([(2.5, 2.0), (3.3, 2.1), (3.0, 1.6)])
    poses = np.column_stack([places, [0.3, -2.0, 1.0]])
    bodies = np.array([[0.65, 0.28, 0.0], [0.65, 0.28, 0.0], [0.0, 0.0, 0.2]])
    place = np.array([*area.origin, area.resolution])
    found = scan_team(area.occupied, place, poses, bodies, 90, 1.5)
    wanted = reference(area, poses, bodies, 90, 1.5)
    both = np.isfinite(found) & np.isfinite(wanted)
    # Rays that graze a corner by less than a step may miss it.
    assert np.count_nonzero(np.isfinite(found) != np.isfinite(wanted)) <= 2
    assert np.count_nonzero(np.abs(found[both] - wanted[both]) > 2e-3) <= 2


def test_a_robot_that_hears_nothing_stops_by_itself_and_the_other_goes_on() -> None:
    simulation = simulation_of()
    simulation.command(0, (0.4, 0.0, 0.0))
    news = []
    for step in range(200):
        if step % 5 == 0:
            simulation.command(1, (0.4, 0.0, 0.0))
        news += simulation.step()
    assert news == ["robot 0 stops: it heard no command for 0.5 s"]
    assert simulation.body_velocities()[0] == pytest.approx(np.zeros(3), abs=1e-9)
    assert simulation.body_velocities()[1] == pytest.approx((0.4, 0.0, 0.0), abs=1e-6)


def test_commands_that_are_no_numbers_are_not_heard() -> None:
    simulation = simulation_of()
    simulation.command(0, (math.nan, 0.0, 0.0))
    for _ in range(20):
        simulation.step()
    assert simulation.body_velocities() == pytest.approx(np.zeros((2, 3)))


def test_reports_are_late_with_the_stamps_of_their_measurement_and_some_are_lost() -> None:
    simulation = simulation_of(delay={"mean": 0.05, "drop": 0.3}, noise={"position": 0.02})
    ages, told = [], 0
    for _ in range(1000):
        simulation.step()
        simulation.measure()
        for report in simulation.reports():
            ages.append(simulation.time - report.stamp)
            told += 1
    assert ages == pytest.approx([0.05] * len(ages), abs=1e-6)
    assert told == pytest.approx(2 * 995 * 0.7, rel=0.08)


def test_touching_is_told_once() -> None:
    simulation = simulation_of()
    news = []
    for _ in range(1400):
        simulation.command(0, (0.4, 0.0, 0.0))
        simulation.command(1, (0.0, 0.0, 0.0))
        news += [text for text in simulation.step() if "touches" in text]
        if simulation.poses()[0, 0] > 5.9:
            break
    assert news == ["robot 0 touches an obstacle"]
