"""Triangles of the scene: they cover what they should and look outwards."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra.numpy import array_shapes, arrays

from cavalcade.robots import body_of, robot_model
from cavalcade.studio.scene import meshes
from cavalcade.studio.scene.meshes import Mesh

Masks = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=9))


def _normals(mesh: Mesh) -> np.ndarray:
    """Of each triangle, as long as its area."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2.0


def _volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


@given(Masks)
def test_rectangles_cover_the_cells_once(mask: np.ndarray) -> None:
    covered = np.zeros(mask.shape, dtype=int)
    for r0, c0, r1, c1 in meshes.cell_rectangles(mask):
        covered[r0:r1, c0:c1] += 1
    assert (covered == mask).all()


@given(Masks)
@settings(max_examples=50)
def test_walls_stand_between_true_and_false_cells_and_look_outwards(mask: np.ndarray) -> None:
    sides = meshes.cell_sides(mask, 0.5, 0.0, 2.0)
    padded = np.pad(mask, 1)
    edges = (np.diff(padded.astype(int), axis=0) != 0).sum()
    edges += (np.diff(padded.astype(int), axis=1) != 0).sum()
    normals = _normals(sides)
    assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(edges * 0.5 * 2.0)
    for number in range(0, len(normals), 2):
        corners = sides.vertices[4 * (number // 2) : 4 * (number // 2) + 4]
        outwards = normals[number] / np.linalg.norm(normals[number])
        # The middle of the first cell's side.
        place = corners.min(axis=0) + 0.25 * (np.ptp(corners, axis=0) > 0.0)
        col, row = np.floor((place + 0.1 * outwards)[:2] / 0.5).astype(int)
        assert not padded[row + 1, col + 1]
        col, row = np.floor((place - 0.1 * outwards)[:2] / 0.5).astype(int)
        assert padded[row + 1, col + 1]


def test_tops_are_as_large_as_the_cells() -> None:
    mask = np.array([[1, 0, 1], [1, 1, 0]], dtype=bool)
    normals = _normals(meshes.cell_tops(mask, 0.5, 1.0))
    assert normals[:, :2] == pytest.approx(0.0)
    assert normals[:, 2].sum() == pytest.approx(4 * 0.25)
    assert (normals[:, 2] > 0.0).all()


@pytest.mark.parametrize("way", [1, -1])
def test_a_prism_is_the_same_for_both_ways_round(way: int) -> None:
    ring = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)[::way]
    normals = _normals(meshes.prism(ring, 0.0, 0.5))
    assert normals[:, 2].sum() == pytest.approx(3.0)
    assert np.linalg.norm(normals[:, :2], axis=1).sum() == pytest.approx(8 * 0.5)


def test_bodies_are_closed_and_outward() -> None:
    assert _volume(meshes.box((1.0, 0.5, 0.25))) == pytest.approx(1.0)
    assert _volume(meshes.cylinder(0.5, 1.0, 400)) == pytest.approx(np.pi * 0.5, rel=1e-3)
    ball = 4.0 / 3.0 * np.pi
    assert _volume(meshes.capsule(1.0, 0.0, 80, 40)) == pytest.approx(ball, rel=0.01)
    whole = np.pi * 0.25 * 2.0 + ball / 8.0
    assert _volume(meshes.capsule(0.5, 1.0, 80, 40)) == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize("name", ["go1", "go2", "spirit"])
def test_robots_shapes_stand_where_their_descriptions_say(name: str) -> None:
    body = body_of(robot_model(name))
    assert body is not None
    for shape in body.looks:
        mesh = meshes.body_shape(shape)
        middle = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2.0
        # Coarse bodies are not quite as wide as they should be.
        assert middle == pytest.approx(np.array(shape.position), abs=6e-3)
        assert _volume(mesh) > 0.0
