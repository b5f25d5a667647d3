"""Colours of the scene, by day and by night; those of robots are the figures'."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.drawing import style
from cavalcade.geometry import Array

Color = tuple[int, int, int]


def rgb(color: str) -> Color:
    """`#rrggbb` as three numbers from 0 to 255."""
    red, green, blue = bytes.fromhex(color.removeprefix("#"))
    return red, green, blue


def linear(colors: Array) -> NDArray[np.uint8]:
    """Colours `(..., 3)` from 0 to 255 in the scale of light, which instances and lines take.

    Meshes by themselves take the usual scale, that of the eye.
    """
    share = np.asarray(colors, dtype=float) / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.rint(255.0 * light).astype(np.uint8)


@dataclass(frozen=True)
class Palette:
    """What has which colour.

    Attributes:
        springs: Short, as long as they should be, long.
    """

    robots: tuple[Color, ...]
    floor: Color
    terrain: Color
    barred: Color
    wall: Color
    unknown: Color
    obstacle: Color
    mover: Color
    cell: Color
    section: Color
    figures: Color
    ink: Color
    soft: Color
    leg: Color
    star: Color
    limit: Color
    springs: tuple[Color, Color, Color]
    field: tuple[Color, Color]

    def robot(self, index: int) -> Color:
        """The colour of a robot."""
        return self.robots[index % len(self.robots)]


LIGHT = Palette(
    robots=tuple(rgb(color) for color in style.ROBOTS),
    floor=(243, 244, 246),
    terrain=(206, 200, 188),
    barred=(160, 140, 124),
    wall=(148, 155, 164),
    unknown=(217, 219, 222),
    obstacle=(136, 146, 158),
    mover=(168, 108, 72),
    cell=(226, 229, 233),
    section=(196, 201, 208),
    figures=(120, 127, 136),
    ink=rgb(style.INK),
    soft=(120, 127, 136),
    leg=(58, 62, 68),
    star=(245, 190, 30),
    limit=rgb(style.LIMIT),
    springs=((44, 110, 190), (150, 156, 164), (205, 66, 48)),
    field=((253, 253, 246), (39, 64, 111)),
)
DARK = Palette(
    robots=tuple(rgb(color) for color in style.ROBOTS_ON_DARK),
    floor=(40, 44, 51),
    terrain=(92, 88, 80),
    barred=(70, 58, 50),
    wall=(96, 104, 116),
    unknown=(58, 62, 69),
    obstacle=(112, 122, 136),
    mover=(178, 118, 80),
    cell=(52, 57, 65),
    section=(72, 78, 88),
    figures=(140, 147, 158),
    ink=(236, 238, 241),
    soft=(150, 157, 166),
    leg=(70, 76, 86),
    star=(255, 214, 77),
    limit=(255, 92, 112),
    springs=((90, 165, 245), (128, 136, 147), (250, 110, 90)),
    field=((62, 86, 120), (214, 234, 200)),
)
