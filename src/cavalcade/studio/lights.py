"""How the scene is lit: colours look as they are meant, and bodies cast shadows on the ground."""

from __future__ import annotations

from typing import Any


def light(server: Any) -> None:
    """Light a page's scene; once per page.

    A sun from above with shadows, and as much light from everywhere that sides are not black. There
    are no reflections: they wash colours out, and take long to draw without a graphics card.
    """
    scene = server.scene
    scene.configure_environment_map(None)
    scene.add_light_ambient("/light", intensity=1.15)
