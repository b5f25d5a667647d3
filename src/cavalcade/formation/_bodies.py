"""Clearances of oriented footprints, for the last filter. Compiled.

The checker judges by other code of its own; nothing here is shared with it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True)
def distance_at(distance, cell, x, y):
    """Bilinear distance to the nearest obstacle at a point, and its gradient; m.

    Beyond the border it is negative: all ground out there is occupied.
    """
    rows, cols = distance.shape
    u = min(max(x / cell - 0.5, 0.0), cols - 1.0)
    v = min(max(y / cell - 0.5, 0.0), rows - 1.0)
    c, r = min(int(u), max(cols - 2, 0)), min(int(v), max(rows - 2, 0))
    c1, r1 = min(c + 1, cols - 1), min(r + 1, rows - 1)
    a, b = u - c, v - r
    d00, d01, d10, d11 = distance[r, c], distance[r, c1], distance[r1, c], distance[r1, c1]
    value = (d00 * (1 - a) + d01 * a) * (1 - b) + (d10 * (1 - a) + d11 * a) * b
    gx = ((d01 - d00) * (1 - b) + (d11 - d10) * b) / cell
    gy = ((d10 - d00) * (1 - a) + (d11 - d01) * a) / cell
    # The outermost half cell and what lies beyond: measure to the border itself.
    edge = min(min(x, cols * cell - x), min(y, rows * cell - y))
    if edge < value:
        value = edge
        gx = 1.0 if edge == x else (-1.0 if edge == cols * cell - x else 0.0)
        gy = 0.0 if gx != 0.0 else (1.0 if edge == y else -1.0)
    return value, gx, gy


@njit(cache=True)
def point_rectangle(px, py, x, y, c, s, half_l, half_w):
    """Distance from a point to a rectangle and the nearest point of it; 0 inside."""
    dx, dy = px - x, py - y
    bx, by = c * dx + s * dy, -s * dx + c * dy
    qx = min(max(bx, -half_l), half_l)
    qy = min(max(by, -half_w), half_w)
    return math.hypot(bx - qx, by - qy), x + c * qx - s * qy, y + s * qx + c * qy


@njit(cache=True)
def rectangle_gap(a, la, wa, b, lb, wb):
    """Signed gap between two oriented rectangles.

    Args:
        a, b: Poses (x, y, yaw).
        la, wa, lb, wb: Half lengths and half widths, m.

    Returns:
        Gap in m (negative: depth of overlap), unit normal (2) from b towards a, and the nearest
        points on a (2) and on b (2).
    """
    ca, sa, cb, sb = math.cos(a[2]), math.sin(a[2]), math.cos(b[2]), math.sin(b[2])
    dx, dy = a[0] - b[0], a[1] - b[1]
    # The axis of greatest separation tells overlap, and its depth.
    depth, nx, ny = -np.inf, 1.0, 0.0
    for k in range(4):
        ux = ca if k == 0 else (-sa if k == 1 else (cb if k == 2 else -sb))
        uy = sa if k == 0 else (ca if k == 1 else (sb if k == 2 else cb))
        along = dx * ux + dy * uy
        reach = (
            la * abs(ca * ux + sa * uy) + wa * abs(-sa * ux + ca * uy)
            + lb * abs(cb * ux + sb * uy) + wb * abs(-sb * ux + cb * uy)
        )  # fmt: skip
        if abs(along) - reach > depth:
            depth = abs(along) - reach
            sign = 1.0 if along >= 0.0 else -1.0
            nx, ny = sign * ux, sign * uy
    if depth <= 0.0:
        mx, my = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
        return depth, nx, ny, mx, my, mx, my
    best = np.inf
    px, py, qx, qy = 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        i, j = (1.0 if k < 2 else -1.0), (1.0 if k % 2 == 0 else -1.0)
        vx, vy = a[0] + ca * i * la - sa * j * wa, a[1] + sa * i * la + ca * j * wa
        d, rx, ry = point_rectangle(vx, vy, b[0], b[1], cb, sb, lb, wb)
        if d < best:
            best, px, py, qx, qy = d, vx, vy, rx, ry
        vx, vy = b[0] + cb * i * lb - sb * j * wb, b[1] + sb * i * lb + cb * j * wb
        d, rx, ry = point_rectangle(vx, vy, a[0], a[1], ca, sa, la, wa)
        if d < best:
            best, px, py, qx, qy = d, rx, ry, vx, vy
    if best > 1e-9:
        nx, ny = (px - qx) / best, (py - qy) / best
    return best, nx, ny, px, py, qx, qy


@njit(cache=True)
def contact_centres(a, la, wa, b, lb, wb, slop):
    """Centres of the parts of two rectangles that lie within `slop` of their gap.

    Between parallel faces the nearest points jump from corner to corner with the slightest turn;
    these do not.

    Args:
        a, b: Poses (x, y, yaw).
        la, wa, lb, wb: Half lengths and half widths, m.
        slop: m.

    Returns:
        The point on a (2) and the point on b (2).
    """
    gap, _, _, px, py, qx, qy = rectangle_gap(a, la, wa, b, lb, wb)
    if gap <= 0.0:
        return px, py, qx, qy
    ca, sa, cb, sb = math.cos(a[2]), math.sin(a[2]), math.cos(b[2]), math.sin(b[2])
    total, ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        i, j = (1.0 if k < 2 else -1.0), (1.0 if k % 2 == 0 else -1.0)
        vx, vy = a[0] + ca * i * la - sa * j * wa, a[1] + sa * i * la + ca * j * wa
        d, rx, ry = point_rectangle(vx, vy, b[0], b[1], cb, sb, lb, wb)
        weight = max(0.0, 1.0 - (d - gap) / slop)
        total += weight
        ax, ay, bx, by = ax + weight * vx, ay + weight * vy, bx + weight * rx, by + weight * ry
        vx, vy = b[0] + cb * i * lb - sb * j * wb, b[1] + sb * i * lb + cb * j * wb
        d, rx, ry = point_rectangle(vx, vy, a[0], a[1], ca, sa, la, wa)
        weight = max(0.0, 1.0 - (d - gap) / slop)
        total += weight
        ax, ay, bx, by = ax + weight * rx, ay + weight * ry, bx + weight * vx, by + weight * vy
    return ax / total, ay / total, bx / total, by / total
