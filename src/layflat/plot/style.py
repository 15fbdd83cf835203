"""Style of all figures: line styles that are distinct in black and white, units on every axis, no pyplot."""

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO, StringIO
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.files import whole_file

SERIES_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#0b3c5d", "linestyle": "-"},
    {"color": "#c23b4e", "linestyle": "--"},
    {"color": "#4c9a3c", "linestyle": "-."},
    {"color": "#e09f3e", "linestyle": (0, (1, 1))},
    {"color": "#6b4c9a", "linestyle": (0, (5, 1, 1, 1, 1, 1))},
    {"color": "#1f8a8a", "linestyle": (0, (8, 2))},
    {"color": "#7a7a7a", "linestyle": (0, (3, 1, 1, 1))},
)
"""Line styles in order of use: dark to light, and of different dashes; `series_style` has those of more series."""

# Of demands, limits and other guide lines.
GUIDE_STYLE: dict[str, Any] = {"color": "#8a8a8a", "linestyle": "-", "linewidth": 1.0}
SHADE_COLOUR = "#eeeeee"  # of bands and shaded backgrounds

RC: Any = {
    "font.size": 9.5,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "svg.fonttype": "path",
    "svg.hashsalt": "layflat",
}

LEFT_MARGIN, RIGHT_MARGIN, BOTTOM_MARGIN, TOP_MARGIN = 0.72, 0.14, 0.52, 0.12  # margins of a figure, inches
HEAD_ROOM = 0.30  # above the axes for a title or a legend, inches
AXES_GAPS = (0.78, 0.16)  # horizontal and vertical space between axes, inches


CAPTION_HEIGHT, CAPTION_MARGIN = 0.2, 0.1  # of a line of a caption, and around it, inches
CAPTION_LETTERS = 13.0  # of a caption per inch


def series_style(order: int) -> dict[str, Any]:
    """Return the line style of the series with index `order`, distinct for the first 49.

    After those of `SERIES_STYLES`, every round of the colours has the dashes of the next colours.
    """
    rounds, colour = divmod(order, len(SERIES_STYLES))
    dashes = SERIES_STYLES[(colour + rounds) % len(SERIES_STYLES)]["linestyle"]
    return {**SERIES_STYLES[colour], "linestyle": dashes}


class ShownFigure(Figure):
    """Figure that a notebook shows, without pyplot."""

    def _repr_png_(self) -> bytes:
        out = BytesIO()
        self.savefig(out, format="png", dpi=100)
        return out.getvalue()


def add_caption(figure: Figure, text: str) -> Figure:
    """Write a wrapped caption below the content of a figure, which is made higher in place, and return the figure."""
    width, height = figure.get_size_inches()
    lines = wrap(text, int(CAPTION_LETTERS * width))
    more = CAPTION_HEIGHT * len(lines) + CAPTION_MARGIN
    places = [axes.get_position() for axes in figure.axes]
    figure.set_size_inches(width, height + more)

    def lifted(y: float) -> float:
        return float((y * height + more) / (height + more))

    for axes, box in zip(figure.axes, places, strict=True):
        axes.set_position((box.x0, lifted(box.y0), box.width, box.height * height / (height + more)))
    for note in figure.texts:
        note.set_y(lifted(note.get_position()[1]))
    for number, line in enumerate(reversed(lines)):
        y = (0.5 * CAPTION_MARGIN + CAPTION_HEIGHT * number) / (height + more)
        figure.text(CAPTION_MARGIN / width, y, line, fontsize=9, va="bottom")
    return figure


@contextmanager
def styled_figure(
    rows: int = 1, columns: int = 1, *, width: float = 6.4, height: float = 3.6,
    above: float = 0.0, below: float = 0.0, beside: float = 0.0,
    between: float | tuple[float, float] = AXES_GAPS,
) -> Iterator[tuple[Figure, list[Axes]]]:  # fmt: skip
    """Yield a figure in the common style with its axes in reading order; all sizes in inches.

    Axes of a column share their x axis. The margins are fixed: an automatic layout would draw everything twice.

    Args:
        rows: number of rows of axes.
        columns: number of columns of axes.
        width: width of the figure.
        height: height of the figure.
        above: additional margin above the axes, as for a colour bar.
        below: additional margin below the axes, as for notes.
        beside: additional margin on the left, as for names.
        between: horizontal space between axes, or horizontal and vertical.
    """
    horizontal, vertical = between if isinstance(between, tuple) else (between, AXES_GAPS[1])
    top, left = TOP_MARGIN + above, LEFT_MARGIN + beside
    wide = (width - left - RIGHT_MARGIN - (columns - 1) * horizontal) / columns
    high = (height - BOTTOM_MARGIN - below - top - (rows - 1) * vertical) / rows
    with mpl.rc_context(RC):
        drawn = ShownFigure(figsize=(width, height))
        drawn.subplots_adjust(
            left=left / width, right=1.0 - RIGHT_MARGIN / width, wspace=horizontal / wide,
            bottom=(BOTTOM_MARGIN + below) / height, top=1.0 - top / height, hspace=vertical / high,
        )  # fmt: skip
        axes = drawn.subplots(rows, columns, sharex="col", squeeze=False)
        yield drawn, list(axes.ravel())


def draw_mark(axes: Axes, value: float, text: str, *, upright: bool = False, ha: str = "left") -> None:
    """Draw a labelled guide line across the axes at a value.

    Args:
        axes: axes to draw on.
        value: value on the y axis; on the x axis if `upright`.
        text: label.
        upright: whether the line is vertical.
        ha: end of a horizontal line with the label, "left" or "right".
    """
    if upright:
        axes.axvline(value, **GUIDE_STYLE)
        place: dict[str, Any] = {"xy": (value, 0.02), "xycoords": axes.get_xaxis_transform(), "xytext": (4, 0)}
    else:
        axes.axhline(value, **GUIDE_STYLE)
        end, inside = (1.0, -4) if ha == "right" else (0.0, 4)
        place = {"xy": (end, value), "xycoords": axes.get_yaxis_transform(), "xytext": (inside, 2)}
    axes.annotate(text, **place, textcoords="offset points", va="bottom", ha=ha, fontsize=8, color="#555555")


def to_svg(figure: Figure) -> str:
    """Return a figure as an `<svg>` element, the same text for the same data."""
    out = StringIO()
    with mpl.rc_context(RC):
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure in the format of the path's suffix (.png, .svg, .pdf); raise OutputError if it can't be written.

    Returns:
        The path.
    """
    with whole_file(Path(path)) as temporary:
        figure.savefig(temporary, dpi=150)
    return Path(path)
