from __future__ import annotations

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.axes import Axes
from PIL import Image

from cavalcade import eikonal
from cavalcade.drawing import style
from cavalcade.drawing.charts import draw_lines
from cavalcade.drawing.figures import make_figures
from cavalcade.drawing.formation.arrival_field import draw_arrival_field
from cavalcade.drawing.formation.sequence import choose_moments, draw_sequence
from cavalcade.drawing.overview import draw_scenario
from cavalcade.drawing.scene import Scene
from cavalcade.errors import OutputError
from cavalcade.scenario import World, build_world, load_scenario
from cavalcade.world import OccupancyMap

NAMES = ["sequence.png", "obstacle_distance.png", "pair_distance.png", "arrival_field.png"]


@pytest.fixture(autouse=True)
def straight_arrival_times(monkeypatch):
    straight_arrival(monkeypatch)


def straight_arrival(monkeypatch):
    """Distance in a straight line in place of fast marching: the pictures do not care."""

    def surface_distance(occupied, cell):
        from scipy.ndimage import distance_transform_edt

        return np.maximum(distance_transform_edt(~occupied) - 0.5, 0.0) * cell

    def arrival_times(speed, sources, cell):
        row, col = np.indices(speed.shape)
        times = np.hypot(row - sources[0][0], col - sources[0][1]) * cell
        return np.where(speed > 0.0, times, np.inf)

    monkeypatch.setattr(eikonal, "surface_distance", surface_distance, raising=False)
    monkeypatch.setattr(eikonal, "arrival_times", arrival_times, raising=False)


def draw(run, folder):
    return make_figures(run.scenario, run.world, folder, recording=run.recording)


@pytest.fixture(scope="module")
def pictures(run, tmp_path_factory):
    """What the run left, and whether matplotlib's settings were changed by it."""
    import matplotlib

    with pytest.MonkeyPatch.context() as patch:
        straight_arrival(patch)
        before = dict(matplotlib.rcParams)
        files = draw(run, tmp_path_factory.mktemp("run") / "new" / "figures")
        return files, dict(matplotlib.rcParams) == before


def test_a_run_leaves_four_pictures(pictures):
    files, _ = pictures
    assert [file.name for file in files] == NAMES
    assert sorted(path.name for path in files[0].parent.iterdir()) == sorted(NAMES)
    for file in files:
        with Image.open(file) as picture:
            picture.load()
            assert min(picture.size) > 600
            assert (edges(file) == 255).all()
            assert picture.info["dpi"][0] >= 299.0
            # A picture of nothing is of one colour.
            assert len(picture.convert("RGB").getcolors(1 << 24)) > 50


def test_pictures_are_the_widths_of_a_printed_page(pictures):
    sizes = {}
    for file in pictures[0]:
        with Image.open(file) as picture:
            sizes[file.name] = picture.size[0] / picture.info["dpi"][0]
    assert sizes["sequence.png"] == pytest.approx(7.16, abs=0.02)
    for name in NAMES[1:]:
        assert sizes[name] == pytest.approx(3.5, abs=0.02)


def test_the_same_run_gives_the_same_bytes(run, pictures, tmp_path):
    one = {file.name: file.read_bytes() for file in pictures[0]}
    other = {file.name: file.read_bytes() for file in draw(run, tmp_path / "b")}
    assert one == other


@pytest.mark.parametrize("robots", [1, 2, 3, 10])
def test_any_number_of_robots(make_run, tmp_path, robots):
    files = draw(make_run(cycles=60, robots=robots), tmp_path)
    expected = [name for name in NAMES if robots > 1 or name != "pair_distance.png"]
    assert [file.name for file in files] == expected


@pytest.mark.parametrize("cycles", [0, 1, 2, 5])
def test_very_short_recordings(run, tmp_path, cycles):
    short = dataclasses.replace(
        run.recording,
        time=run.recording.time[:cycles],
        poses=run.recording.poses[:cycles],
        status=run.recording.status[:cycles],
    )
    files = make_figures(run.scenario, run.world, tmp_path, recording=short)
    assert [file.name for file in files] == (NAMES if cycles else [])


def edges(file):
    """The outermost points of a picture, `(K, 3)`."""
    seen = np.asarray(Image.open(file).convert("RGB"))
    return np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])


@pytest.mark.parametrize("slowness", [1e-3, 1.0, 40.0, 1e4])
def test_labels_were_cut_off(run, tmp_path, monkeypatch, slowness):
    """Whatever room numbers take, nothing reaches the picture's edge."""
    usual = eikonal.arrival_times
    monkeypatch.setattr(eikonal, "arrival_times", lambda *said: slowness * usual(*said))
    file = draw_arrival_field(Scene(run.scenario, run.world, run.recording), tmp_path / "a.png")
    assert (edges(file) == 255).all()


def test_a_figure_grows_where_something_would_be_cut_off(tmp_path):
    sizes = []
    for label in ("a", "a label that is far too long for where it stands"):
        figure = style.new_figure(2.0, 1.0)
        figure.text(0.5, 0.5, label)
        file = style.save(figure, tmp_path / "figure.png", dpi=100)
        assert (edges(file) == 255).all()
        with Image.open(file) as picture:
            sizes.append(picture.size)
    assert sizes[0] == (200, 100)
    assert sizes[1][0] > 250


def test_robots_were_numbered_by_slot(run, tmp_path, monkeypatch):
    """The numbers on the map are those of the legend, whatever slots the robots have."""
    said = []
    text = Axes.text

    def note(axes, x, y, label, *rest, **options):
        said.append((float(x), float(y), label))
        return text(axes, x, y, label, *rest, **options)

    monkeypatch.setattr(Axes, "text", note)
    draw_sequence(Scene(run.scenario, run.world, run.recording), tmp_path / "sequence.png")
    moments = choose_moments(Scene(run.scenario, run.world, run.recording)).tolist()
    assert len(said) == 4 * len(moments)
    assert any(run.recording.roles[cycle].tolist() != [0, 1, 2, 3] for cycle in moments)
    for cycle, labels in zip(moments, zip(*[iter(said)] * 4, strict=True), strict=True):
        assert [label for _, _, label in labels] == ["0", "1", "2", "3"]
        for (x, y, _), pose in zip(labels, run.recording.poses[cycle], strict=True):
            assert np.hypot(x - pose[0], y - pose[1]) < 0.8


@pytest.mark.parametrize("robots", [2, 3, 7])
@pytest.mark.parametrize("apart", [0.0, 1e-6])
def test_curves_were_hidden_under_each_other(robots, apart):
    """Each of several that run together can be seen, for about as long as the others."""
    figure = style.new_figure(6.0, 2.0)
    axes = style.add_panel(figure, 0.0, 0.0, 6.0, 2.0)
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 1.0)
    axes.axis("off")
    time = np.array([0.0, 3.0, 10.0])
    lines = [(time, np.array([0.2, 0.5, 0.4]) + apart * k) for k in range(robots)]
    draw_lines(axes, lines, [style.robot_line(k) for k in range(robots)], 1.5)
    figure.canvas.draw()
    seen = np.asarray(figure.canvas.buffer_rgba())[..., :3]
    counts = []
    for k in range(robots):
        color = [int(style.robot_color(k)[i : i + 2], 16) for i in (1, 3, 5)]
        counts.append(int((seen == color).all(axis=2).sum()))
    assert min(counts) > 0.6 * max(counts)


def test_curves_that_are_apart_are_whole():
    figure = style.new_figure(6.0, 2.0)
    axes = style.add_panel(figure, 0.0, 0.0, 6.0, 2.0)
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 1.0)
    time = np.array([0.0, 10.0])
    draw_lines(axes, [(time, time / 20.0), (time, time / 20.0 + 0.3)], [{}, {}], 1.0)
    assert all(np.isnan(line.get_ydata()).all() for line in axes.lines[2:])


def test_a_team_without_a_goal_has_no_arrival_field(make_run, tmp_path):
    run = make_run(cycles=20)
    idle = tuple(
        dataclasses.replace(status, goal=None, state="inactive", leader=-1, paths=((),) * 4)
        for status in run.recording.status
    )
    recording = dataclasses.replace(run.recording, status=idle)
    files = make_figures(run.scenario, run.world, tmp_path, recording=recording)
    assert [file.name for file in files] == NAMES[:3]


def test_a_lost_robot_and_a_new_shape_are_drawn(make_run, tmp_path):
    run = make_run(cycles=40)
    changed = tuple(
        dataclasses.replace(
            status,
            roles=np.array([0, 1, -1, 2]),
            slots=1.2 * status.slots[:3],
            connections=np.array([[0, 1], [1, 3]]),
            eta=np.array([1.0, 2.0, np.inf, 3.0]),
        )
        if i > 20
        else status
        for i, status in enumerate(run.recording.status)
    )
    recording = dataclasses.replace(run.recording, status=changed)
    assert len(make_figures(run.scenario, run.world, tmp_path, recording=recording)) == 4


def test_a_map_with_unknown_ground_and_a_turned_origin(make_run, tmp_path):
    run = make_run(cycles=20)
    grid = np.zeros((200, 280), dtype=np.int8)
    grid[:20], grid[90:100, 200:230] = -1, 100
    ground = OccupancyMap(grid, 0.05, (0.5, -0.5, 0.1))
    world = World(ground.with_shapes(run.world.shapes), ground, run.world.shapes, ())
    assert len(make_figures(run.scenario, world, tmp_path, recording=run.recording)) == 4


def test_a_place_that_cannot_be_written_is_named(run, tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="file"):
        draw(run, tmp_path / "file" / "figures")
    (tmp_path / "figures" / "sequence.png").mkdir(parents=True)
    with pytest.raises(OutputError, match=r"sequence\.png"):
        draw(run, tmp_path / "figures")
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["sequence.png"]


def test_drawing_leaves_matplotlib_as_it_was(pictures):
    _, unchanged = pictures
    assert unchanged


def test_a_scenario_is_drawn_without_running_it(run, tmp_path):
    file = draw_scenario(run.scenario, run.world, tmp_path / "scenario.png")
    with Image.open(file) as picture:
        assert picture.size[0] / picture.info["dpi"][0] == pytest.approx(7.16, abs=0.02)


@pytest.mark.parametrize("name", ["rough", "alcove"])
def test_individual_goals_and_terrain_are_drawn(name, tmp_path):
    scenario = load_scenario(name)
    world = build_world(scenario)
    file = draw_scenario(scenario, world, tmp_path / "scenario.png")
    with Image.open(file) as picture:
        size = picture.size[0] / picture.size[1]
    assert size == pytest.approx(world.map.size[0] / world.map.size[1], rel=0.25)


def test_importing_the_package_does_not_import_matplotlib():
    code = "import sys, cavalcade.drawing.figures; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_moments_start_and_end_with_the_run_and_rise(run):
    scene = Scene(run.scenario, run.world, run.recording)
    moments = choose_moments(scene)
    assert len(moments) == 6
    assert moments[0] == 0
    assert moments[-1] == len(scene.recording.time) - 1
    assert (np.diff(moments) > 0).all()


def test_moments_do_not_crowd_where_the_team_waits(run):
    waiting = np.repeat(np.arange(240), np.where(np.arange(240) == 120, 400, 1))
    recording = dataclasses.replace(
        run.recording,
        time=np.arange(len(waiting)) * 0.1,
        poses=run.recording.poses[waiting],
        status=tuple(run.recording.status[i] for i in waiting),
    )
    moments = waiting[choose_moments(Scene(run.scenario, run.world, recording))]
    assert (moments == 120).sum() <= 1


def test_the_whole_map_is_shown_unless_the_team_used_little_of_it(make_run):
    run = make_run(cycles=20)
    scene = Scene(run.scenario, run.world, run.recording)
    assert scene.view() == pytest.approx([0.0, 0.0, 14.0, 10.0])
    big = OccupancyMap.empty((60.0, 60.0), 0.1)
    world = World(big, big, (), ())
    view = Scene(run.scenario, world, run.recording).view()
    width, height = view[2:] - view[:2]
    assert width < 20.0
    assert height >= 0.49 * width
    assert (view[:2] >= 0.0).all()
