from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import cavalcade as cv
from cavalcade.drawing.physics.video import render_video
from cavalcade.errors import InputError


@pytest.fixture
def walked(trot):
    scenario = cv.parse_scenario(
        {
            "version": 1,
            "name": "one",
            "world": {"empty": {"size": [4, 4]}},
            "robots": [{"model": "go1", "start": [1, 2, 0], "goal": [3, 2, 0]}],
            "task": {"goals": "individual"},
        }
    )
    poses = np.array([[(1.0, 2.0, 0.0)], [(1.2, 2.0, 0.0)]])
    return scenario, cv.build_world(scenario), trot(np.array([0.0, 0.5]), poses)


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("a.mp4", {}, r"a\.mp4 \(one of: \.webp"),
        ("a.webp", {"rate": 0.0}, "pictures a second"),
        ("a.webp", {"size": (8, 8)}, "pixels"),
    ],
)
def test_what_cannot_be_made_is_said_in_one_line(walked, tmp_path, name, options, said):
    with pytest.raises(InputError, match=said) as caught:
        render_video(*walked, tmp_path / name, **options)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_without_a_way_to_draw_one_line_says_so(walked, tmp_path, monkeypatch):
    mujoco = pytest.importorskip("mujoco")

    def fail(*_):
        raise RuntimeError("no\ncontext")

    monkeypatch.setattr(mujoco, "Renderer", fail)
    with pytest.raises(InputError, match="MUJOCO_GL=egl or osmesa") as caught:
        render_video(*walked, tmp_path / "a.webp")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a.webp", "a.gif"])
def test_a_video_shows_the_robot(walked, tmp_path, name):
    pytest.importorskip("mujoco")
    try:
        file = render_video(*walked, tmp_path / name, rate=10.0, size=(160, 120))
    except InputError as error:
        if "MUJOCO_GL" not in str(error):
            raise
        pytest.skip(str(error))
    with Image.open(file) as video:
        assert video.n_frames == 6
        seen = np.asarray(video.convert("RGB")).astype(int)
    blue = (seen[..., 2] > 90) & (seen[..., 2] - seen[..., 0] > 40)
    assert 40 < blue.sum() < 4000
