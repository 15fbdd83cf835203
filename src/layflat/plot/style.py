"""One look for all figures: colours that can be told apart in black and white, units on every axis, no pyplot."""

from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.files import whole_file

LINES: tuple[dict[str, Any], ...] = (
    {"color": "#0b3c5d", "linestyle": "-"},
    {"color": "#c23b4e", "linestyle": "--"},
    {"color": "#4c9a3c", "linestyle": "-."},
    {"color": "#e09f3e", "linestyle": (0, (1, 1))},
    {"color": "#6b4c9a", "linestyle": (0, (5, 1, 1, 1, 1, 1))},
    {"color": "#1f8a8a", "linestyle": (0, (8, 2))},
    {"color": "#7a7a7a", "linestyle": (0, (3, 1, 1, 1))},
)
"""Line styles in order of use: dark to light, and of different dashes; one for each joint of an arm."""

# For demands, limits and other things that only help to read.
QUIET: dict[str, Any] = {"color": "#8a8a8a", "linestyle": "-", "linewidth": 1.0}
SHADE = "#eeeeee"  # for bands, and the ground behind what counts otherwise

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

LEFT, RIGHT, BOTTOM, TOP = 0.72, 0.14, 0.52, 0.12  # margins of a figure, inches
HEAD = 0.30  # room above the axes for a title or a legend, inches
BETWEEN = (0.78, 0.16)  # space between axes, beside and above each other, inches


@contextmanager
def figure(
    rows: int = 1, columns: int = 1, *, width: float = 6.4, height: float = 3.6,
    above: float = 0.0, below: float = 0.0, beside: float = 0.0,
    between: float | tuple[float, float] = BETWEEN,
) -> Iterator[tuple[Figure, list[Axes]]]:  # fmt: skip
    """Give a figure in the house style, with its axes in reading order; sizes in inches.

    Where asked there is more room `above` the axes, for a scale of colours, `below` them, for notes, and on the left
    `beside` them, for names; `between` says how far they are beside, or beside and above each other. What is across is
    shared by axes above each other. The margins are fixed: a layout that is solved for would draw everything twice.
    """
    aside, over = between if isinstance(between, tuple) else (between, BETWEEN[1])
    top, left = TOP + above, LEFT + beside
    wide = (width - left - RIGHT - (columns - 1) * aside) / columns
    high = (height - BOTTOM - below - top - (rows - 1) * over) / rows
    with mpl.rc_context(RC):
        made = Figure(figsize=(width, height))
        made.subplots_adjust(
            left=left / width, right=1.0 - RIGHT / width, wspace=aside / wide,
            bottom=(BOTTOM + below) / height, top=1.0 - top / height, hspace=over / high,
        )  # fmt: skip
        axes = made.subplots(rows, columns, sharex="col", squeeze=False)
        yield made, list(axes.ravel())


def mark(axes: Axes, at: float, text: str, *, upright: bool = False, ha: str = "left") -> None:
    """Draw a quiet line across the axes at a value, and write at its left or right end what it stands for."""
    if upright:
        axes.axvline(at, **QUIET)
        place: dict[str, Any] = {"xy": (at, 0.02), "xycoords": axes.get_xaxis_transform(), "xytext": (4, 0)}
    else:
        axes.axhline(at, **QUIET)
        end, inside = (1.0, -4) if ha == "right" else (0.0, 4)
        place = {"xy": (end, at), "xycoords": axes.get_yaxis_transform(), "xytext": (inside, 2)}
    axes.annotate(text, **place, textcoords="offset points", va="bottom", ha=ha, fontsize=8, color="#555555")


def to_svg(made: Figure) -> str:
    """Return a figure as SVG text, the same for the same data."""
    out = StringIO()
    with mpl.rc_context(RC):
        made.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


def save(made: Figure, path: Path) -> Path:
    """Write a figure; the suffix says how (.png, .svg, .pdf). Raise OutputError if it can't be written there."""
    with whole_file(path) as temporary:
        made.savefig(temporary, dpi=150)
    return path
