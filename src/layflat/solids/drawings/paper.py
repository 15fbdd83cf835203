"""Sheets of paper with lines and texts, and their files: SVG and PDF. Lengths are in mm, from the lower left corner.

Line widths and text heights are those of ISO 128-2 and ISO 3098-1, sizes of sheets those of ISO 5457.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from io import BytesIO
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.text import CAPITAL_HEIGHT, FONT_NAME

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.arrays import Array

Pen = Literal["outline", "part", "thin", "hidden", "centre", "frame", "none"]
Fill = Literal["", "white", "black", "hatched", "hatched back"]
Anchor = Literal["left", "center", "right"]

PEN_STYLES: dict[Pen, tuple[float, tuple[float, ...]]] = {  # width, and lengths of dashes and gaps, mm
    "outline": (0.5, ()),
    "part": (0.3, ()),
    "thin": (0.18, ()),
    "hidden": (0.25, (2.0, 1.0)),
    "centre": (0.18, (6.0, 1.0, 0.8, 1.0)),
    "frame": (0.7, ()),
    "none": (0.0, ()),
}
FORMATS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}
"""Width and height of sheets that lie on their long side, mm."""
INCH_LENGTH = 25.4  # mm
HATCH_PATTERNS = {"hatched": "/////", "hatched back": "\\\\\\\\\\"}
HATCH_WIDTH = 0.13  # of the lines of hatched sections, mm


class Path(NamedTuple):
    """Closed or open line, or an area of several closed lines, with a pen, filled white or hatched."""

    lines: tuple[Array, ...]  # (n, 2) each
    pen: Pen
    closed: bool = False
    fill: Fill = ""


class Text(NamedTuple):
    """Line of text; its height is that of capital letters."""

    at: tuple[float, float]  # on the base line
    text: str
    height: float
    anchor: Anchor = "left"
    rotation: float = 0.0  # deg


@dataclass
class Paper:
    """Sheet with what is drawn on it, later elements above earlier ones."""

    format: str  # a key of `FORMATS`
    title: str
    elements: list[Path | Text] = field(default_factory=list)

    @property
    def text_height(self) -> float:
        """Height of ordinary text: legible on A4, also where a larger sheet is printed on A4."""
        return 2.5 if self.format == "A4" else 3.0

    def line(self, points: Sequence[Any] | Array, pen: Pen, *, closed: bool = False) -> None:
        """Draw a line through points.

        Args:
            points: (n, 2).
            pen: its pen.
            closed: whether the last point is connected with the first.
        """
        self.elements.append(Path((np.asarray(points, float),), pen, closed))

    def area(self, lines: Sequence[Array], pen: Pen, fill: Fill) -> None:
        """Fill what a closed line encloses, less the areas within further ones.

        Args:
            lines: (n, 2) each.
            pen: pen of the lines.
            fill: white, black or hatched, in one direction or the other.
        """
        # Backends fill by the winding number: holes run clockwise.
        turned = [_anticlockwise(np.asarray(line, float)) for line in lines]
        self.elements.append(Path((turned[0], *(line[::-1] for line in turned[1:])), pen, True, fill))

    def text(
        self, x: float, y: float, text: str, height: float = 0.0, anchor: Anchor = "left", rotation: float = 0.0
    ) -> None:
        """Write a line of text.

        Args:
            x: position of the anchor.
            y: position of the base line.
            text: the text.
            height: of capital letters, by default that of ordinary text.
            anchor: side of the text at x.
            rotation: of the base line, anticlockwise, deg.
        """
        self.elements.append(Text((x, y), text, height or self.text_height, anchor, rotation))


def _anticlockwise(line: Array) -> Array:
    """Return a closed line (n, 2) in the direction that has its area on the left."""
    x, y = line.T
    return line if x @ np.roll(y, -1) >= y @ np.roll(x, -1) else line[::-1]


def svg_and_pdf(paper: Paper) -> tuple[bytes, bytes]:
    """Return the SVG and the PDF of a sheet; the same sheet gives the same bytes."""
    import matplotlib as mpl  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    rules: Any = {"svg.fonttype": "none", "svg.hashsalt": paper.title, "pdf.fonttype": 3, "font.family": FONT_NAME,
                  "hatch.linewidth": HATCH_WIDTH / INCH_LENGTH * 72, "path.simplify": False}  # fmt: skip
    width, height = FORMATS[paper.format]
    with mpl.rc_context(rules):
        figure = Figure(figsize=(width / INCH_LENGTH, height / INCH_LENGTH))
        _draw(figure, paper)
        svg, pdf = BytesIO(), BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": "layflat", "Title": paper.title})
        about = {"CreationDate": None, "Creator": "layflat", "Producer": None, "Title": paper.title}
        figure.savefig(pdf, format="pdf", metadata=about)
    return svg.getvalue(), pdf.getvalue()


def _draw(figure: Any, paper: Paper) -> None:
    """Draw the elements of a sheet on a figure of its size; neighbours with the same pen become one path."""
    from matplotlib.patches import PathPatch  # noqa: PLC0415
    from matplotlib.path import Path as Outline  # noqa: PLC0415
    from matplotlib.transforms import Affine2D  # noqa: PLC0415

    from layflat.solids.drawings.text_line import TextLine, font_of  # noqa: PLC0415  # imports matplotlib

    on_paper = Affine2D().scale(1 / INCH_LENGTH) + figure.dpi_scale_trans
    order = 0
    for group in _groups(paper.elements):
        order += 1
        first = group[0]
        if isinstance(first, Text):
            size = first.height / CAPITAL_HEIGHT / INCH_LENGTH * 72
            figure.add_artist(
                TextLine(*first.at, first.text, transform=on_paper, fontproperties=font_of(size), ha=first.anchor,
                         rotation=first.rotation, rotation_mode="anchor", zorder=order)
            )  # fmt: skip
            continue
        lines = [(line, one.closed) for one in group if isinstance(one, Path) for line in one.lines]
        outline = Outline.make_compound_path(
            *(Outline(np.vstack((line, line[:1])) if closed else line, closed=closed) for line, closed in lines)
        )
        width, dashes = PEN_STYLES[first.pen]
        look: dict[str, Any] = {
            "linewidth": width / INCH_LENGTH * 72,
            "linestyle": (0.0, tuple(part / width for part in dashes)) if dashes else "solid",
            "facecolor": first.fill if first.fill in {"white", "black"} else "none",
            "hatch": HATCH_PATTERNS.get(first.fill),
        }
        patch = PathPatch(outline, transform=on_paper, edgecolor="black", capstyle="butt", joinstyle="round", **look)
        figure.add_artist(patch)
        patch.set_zorder(order)


def _groups(elements: Sequence[Path | Text]) -> list[list[Path | Text]]:
    """Return elements in order, neighbours that are lines with the same pen together."""
    groups: list[list[Path | Text]] = []
    for one in elements:
        last = groups[-1][0] if groups else None
        if isinstance(one, Path) and isinstance(last, Path) and not one.fill and not last.fill and one.pen == last.pen:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups
