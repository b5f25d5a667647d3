"""How the scene is lit: colours look as they are meant, and it is drawn fast in software."""

from __future__ import annotations

from typing import Any


def light(server: Any) -> None:
    """Light a page's scene; once per page.

    A sun from above, and as much light from everywhere that sides are not black. There are neither
    shadows nor reflections: without a graphics card they take longer than all the rest, and
    reflections wash colours out.
    """
    scene = server.scene
    scene.configure_default_lights(True, cast_shadow=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/light", intensity=1.15)
