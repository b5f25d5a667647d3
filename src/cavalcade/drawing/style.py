"""One look for all figures: sizes of an IEEE page, a colour-blind-safe palette, marks, writing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cavalcade.errors import OutputError
from cavalcade.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

COLUMN = 3.5
"""Width of a single column, inches."""
PAGE = 7.16
"""Width of both columns, inches."""
DPI = 300

_EDGE = 0.015
"""Least room between what is drawn and the page's edge, inches."""

INK = "#1b1b1b"
GREY = "#6b6b6b"
WALL = "#3f444a"
SHAPE = "#596068"
UNKNOWN = "#d9dbde"
MOVER = "#8a4b2a"
LIMIT = "#b00020"
BEYOND = "#f6d5d9"
GRID = "#dcdee1"

WALKING, FLYING, WAITING, TURNING = "#d7191c", "#1f5fe0", "#c9cdd2", "#f0a3a0"
"""The colours of walking and of flight are those of the paper's Fig. 6."""

LEGS = (
    ("front left", "#0072B2", "o"),
    ("front right", "#E69F00", "s"),
    ("rear left", "#009E73", "^"),
    ("rear right", "#B5478D", "D"),
)
"""Names of the legs, and how their footholds are marked."""

# Okabe and Ito's palette without its yellow, which vanishes on white, then three darker tones;
# beside each the same hue for a dark page.
_HUES = (
    ("#0072B2", "#4aa8e8"),
    ("#E69F00", "#f2b632"),
    ("#009E73", "#2cc492"),
    ("#CC79A7", "#e79ac4"),
    ("#D55E00", "#f07b3f"),
    ("#56B4E9", "#9ad7fa"),
    ("#7A5195", "#b792d8"),
    ("#8C6D1F", "#c9a84c"),
    ("#5B5B5B", "#b4b8bd"),
    ("#004B49", "#4db6ac"),
)
ROBOTS, ROBOTS_ON_DARK = zip(*_HUES, strict=True)

_TICKS = {
    "labelsize": 7.0,
    "color": INK,
    "direction": "in",
    "major.size": 2.5,
    "major.width": 0.5,
    "major.pad": 2.5,
}
_RC: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.0,
    "legend.fontsize": 7.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    **{f"{axis}tick.{part}": value for axis in "xy" for part, value in _TICKS.items()},
    "axes.labelpad": 2.0,
    "lines.linewidth": 1.0,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "patch.linewidth": 0.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": 1.2,
    "legend.borderpad": 0.0,
    "legend.borderaxespad": 0.0,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "path.simplify_threshold": 0.05,
}


def robot_color(index: int) -> str:
    """The colour of a robot in all figures and in the replay."""
    return ROBOTS[index % len(ROBOTS)]


def robot_line(index: int) -> Any:
    """Options of a robot's line; its style tells robots of the same colour apart."""
    styles = ("-", (0, (4, 1.2)), (0, (1, 1.2)), (0, (5, 1.2, 1, 1.2)))
    dash = styles[(index // len(ROBOTS)) % len(styles)]
    return {"color": robot_color(index), "linestyle": dash}


def mark(shape: str, size: float, edge: str, width: float = 0.8, face: str = "white") -> Any:
    """Options of a marker without a line, for `plot` as well as for `key`."""
    return {
        "linestyle": "none",
        "marker": shape,
        "markersize": size,
        "markerfacecolor": face,
        "markeredgecolor": edge,
        "markeredgewidth": width,
    }


def key(label: str, **options: Any) -> Line2D:
    """What stands for lines or markers of these options in a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **options)


def halo(width: float) -> Any:
    """Text and lines with a white border of so many points, readable on any ground."""
    from matplotlib.patheffects import Normal, withStroke

    return [withStroke(linewidth=width, foreground="white"), Normal()]


def note(
    axes: Axes, text: str, place: tuple[float, float], away: tuple[float, float], **options: Any
) -> None:
    """A text so many points away from a place, in the axes' coordinates unless `xycoords` says."""
    options = {"fontsize": 7, **options}
    axes.annotate(text, place, xytext=away, textcoords="offset points", **options)


@contextmanager
def paper_style() -> Iterator[None]:
    """Matplotlib with this module's look, and only inside the `with` block."""
    import matplotlib

    settings: Any = _RC  # matplotlib's stubs want each key as a literal
    with matplotlib.rc_context(settings):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of that size in inches, drawn by Agg whatever the user's backend."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


class Margins(NamedTuple):
    """Room around a figure's panels, inches."""

    left: float
    right: float
    bottom: float
    top: float


def add_panel(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in inches from the figure's lower left corner."""
    page, total = figure.get_size_inches()
    return figure.add_axes((left / page, bottom / total, width / page, height / total))


def make_directory(path: str | Path) -> Path:
    """The folder, made if it was missing.

    Raises:
        OutputError: It cannot be made.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make folder {folder}: {error.strerror}") from error
    return folder


def save(figure: Figure, path: Path, dpi: int = DPI) -> Path:
    """Write the figure as PNG, whole or not at all.

    It gets larger where something would be cut off, a wide label for instance.

    Raises:
        OutputError: The file cannot be written.
    """
    from matplotlib.transforms import Bbox

    drawn = figure.get_tightbbox().padded(_EDGE)
    box = Bbox.union([drawn, Bbox.from_extents(0.0, 0.0, *figure.get_size_inches())])
    # Two levels below the usual compression: a third of its time for a hundredth of the size.
    packing = {"compress_level": 4}
    with replacing(path) as temporary:
        figure.savefig(
            temporary,
            format="png",
            dpi=dpi,
            bbox_inches=box,
            metadata={"Software": None},
            pil_kwargs=packing,
        )
    return path
