"""Planar poses, oriented boxes, trajectories and paths. Radians, metres (REP-103)."""

from cavalcade.geometry.planar import (
    Array,
    inverse_transform_points,
    rectangle_corners,
    rotation,
    transform_points,
    wrap_angle,
)

__all__ = [
    "Array",
    "inverse_transform_points",
    "rectangle_corners",
    "rotation",
    "transform_points",
    "wrap_angle",
]
