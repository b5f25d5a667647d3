"""Heights and slopes between the cells' centres."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine


@subroutine
def corner(rows, cols, scale, x, y):
    """The cell whose centre is the lower left one around a point, and the point's place between.

    Args:
        scale: Cells per m.

    Returns:
        Row and column, unsigned, and the shares 0 to 1 along x and y. Beyond the edge, the edge.
    """
    u = min(max(x * scale - 0.5, 0.0), cols - 1.0)
    v = min(max(y * scale - 0.5, 0.0), rows - 1.0)
    j, i = min(np.uint64(u), np.uint64(cols - 2)), min(np.uint64(v), np.uint64(rows - 2))
    return i, j, u - np.float64(j), v - np.float64(i)


@subroutine
def blend(layer, i, j, fu, fv):
    """A layer's bilinear value at the place that `corner` gives."""
    one = np.uint64(1)
    a, b = layer[i, j], layer[i + one, j]
    low = a + fu * (layer[i, j + one] - a)
    high = b + fu * (layer[i + one, j + one] - b)
    return low + fv * (high - low)


@kernel
def bilinear(layer, cell, x, y):
    """A layer's value at a point; beyond the edge that of the edge."""
    i, j, fu, fv = corner(layer.shape[0], layer.shape[1], 1.0 / cell, x, y)
    return blend(layer, i, j, fu, fv)


@kernel
def surface(ground, x, y):
    """Height and its derivatives along x and y of the surface that the body follows.

    The quadratic B-spline of `ground.smooth`: its derivatives are continuous, so that a body
    that keeps its clearance has a velocity without jumps. It differs from bilinear heights by an
    eighth of the second differences, millimetres on smoothed ground.
    """
    if ground.flat:
        return 0.0, 0.0, 0.0
    layer, cell = ground.smooth, ground.cell
    rows, cols = layer.shape
    u, v = x / cell - 0.5, y / cell - 0.5
    j, i = math.floor(u + 0.5), math.floor(v + 0.5)
    fu, fv = u - j, v - i
    a0, a1, a2 = 0.5 * (0.5 - fu) ** 2, 0.75 - fu * fu, 0.5 * (0.5 + fu) ** 2
    d0, d1, d2 = fu - 0.5, -2.0 * fu, fu + 0.5
    j0 = int(min(max(j - 1, 0), cols - 1))
    j1 = int(min(max(j, 0), cols - 1))
    j2 = int(min(max(j + 1, 0), cols - 1))
    i0 = int(min(max(i - 1, 0), rows - 1))
    i1 = int(min(max(i, 0), rows - 1))
    i2 = int(min(max(i + 1, 0), rows - 1))
    p0 = a0 * layer[i0, j0] + a1 * layer[i0, j1] + a2 * layer[i0, j2]
    p1 = a0 * layer[i1, j0] + a1 * layer[i1, j1] + a2 * layer[i1, j2]
    p2 = a0 * layer[i2, j0] + a1 * layer[i2, j1] + a2 * layer[i2, j2]
    q0 = d0 * layer[i0, j0] + d1 * layer[i0, j1] + d2 * layer[i0, j2]
    q1 = d0 * layer[i1, j0] + d1 * layer[i1, j1] + d2 * layer[i1, j2]
    q2 = d0 * layer[i2, j0] + d1 * layer[i2, j1] + d2 * layer[i2, j2]
    b0, b1, b2 = 0.5 * (0.5 - fv) ** 2, 0.75 - fv * fv, 0.5 * (0.5 + fv) ** 2
    height = b0 * p0 + b1 * p1 + b2 * p2
    along_x = (b0 * q0 + b1 * q1 + b2 * q2) / cell
    along_y = ((fv - 0.5) * p0 - 2.0 * fv * p1 + (fv + 0.5) * p2) / cell
    return height, along_x, along_y


@kernel
def surface_along(ground, points):
    """`surface` at points `(N, 2)`: heights and derivatives, each `(N,)`."""
    height, along_x, along_y = np.empty(len(points)), np.empty(len(points)), np.empty(len(points))
    for k in range(len(points)):
        height[k], along_x[k], along_y[k] = surface(ground, points[k, 0], points[k, 1])
    return height, along_x, along_y
