"""Sheet of a diagram in SVG: lines, shapes and text in mm with y downwards, black on white."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from html import escape
from typing import Literal

Point = tuple[float, float]
LineStyle = Literal["line", "thin", "pilot", "frame", "bold"]

LINE_RULES: dict[LineStyle, str] = {
    "line": "stroke-width:0.35",
    "thin": "stroke-width:0.2",
    "pilot": "stroke-width:0.25;stroke-dasharray:1.2 0.7",
    "frame": "stroke-width:0.25;stroke-dasharray:3 0.8 0.6 0.8",
    "bold": "stroke-width:0.6",
}
PAPER_SIZES = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "A2": (594.0, 420.0), "A1": (841.0, 594.0)}  # landscape, mm
SHEET_MARGIN = 10.0  # of a sheet, mm
TEXT_HEIGHT = 2.5  # mm, of ISO 3098


def shorten_text(text: str, letters: int) -> str:
    """Return a text of at most so many letters; a longer one ends with three dots."""
    return text if len(text) <= letters else f"{text[: letters - 3]}..."


def title_height(notes: Sequence[str]) -> float:
    """Return the height of a title block with notes above the edge of the sheet, mm."""
    return SHEET_MARGIN + 6.0 + 3.6 * len(notes)


class Diagram:
    """Elements of a diagram on a sheet of paper, in the order in which they are drawn."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._elements: list[str] = []

    def line(self, *points: Point, style: LineStyle = "line") -> None:
        """Draw a polyline through points."""
        steps = " L".join(f"{x:.2f},{y:.2f}" for x, y in points)
        self._elements.append(f'<path class="{style}" d="M{steps}"/>')

    def curve(self, path: str, style: LineStyle = "line") -> None:
        """Draw a path in SVG's own notation."""
        self._elements.append(f'<path class="{style}" d="{path}"/>')

    def box(self, corner: Point, width: float, height: float, style: LineStyle = "line") -> None:
        """Draw a rectangle.

        Args:
            corner: its upper left corner.
            width: mm.
            height: mm.
            style: style of its lines.
        """
        x, y = corner
        size = f'width="{width:.2f}" height="{height:.2f}"'
        self._elements.append(f'<rect class="{style}" x="{x:.2f}" y="{y:.2f}" {size}/>')

    def circle(self, centre: Point, radius: float, style: LineStyle = "line") -> None:
        """Draw a circle.

        Args:
            centre: its centre.
            radius: mm.
            style: style of its line.
        """
        x, y = centre
        self._elements.append(f'<circle class="{style}" cx="{x:.2f}" cy="{y:.2f}" r="{radius:.2f}"/>')

    def polygon(self, *points: Point, filled: bool = False) -> None:
        """Draw a closed polygon."""
        corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in points)
        self._elements.append(f'<polygon class="{"solid" if filled else "line"}" points="{corners}"/>')

    def dot(self, point: Point) -> None:
        """Draw the dot of a connection."""
        x, y = point
        self._elements.append(f'<circle class="solid" cx="{x:.2f}" cy="{y:.2f}" r="0.65"/>')

    def arrow(self, *points: Point, style: LineStyle = "line") -> None:
        """Draw a polyline with an arrow head at its last point."""
        self.line(*points, style=style)
        (x0, y0), (x1, y1) = points[-2:]
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        along, across = ((x1 - x0) / length, (y1 - y0) / length), ((y0 - y1) / length, (x1 - x0) / length)
        back = (x1 - 1.8 * along[0], y1 - 1.8 * along[1])
        left = (back[0] + 0.6 * across[0], back[1] + 0.6 * across[1])
        right = (back[0] - 0.6 * across[0], back[1] - 0.6 * across[1])
        self.polygon((x1, y1), left, right, filled=True)

    def text(
        self, point: Point, text: str, *, height: float = TEXT_HEIGHT, anchor: str = "start", bold: bool = False
    ) -> None:
        """Write a line of text.

        Args:
            point: its anchor on the baseline.
            text: the text.
            height: of the letters, mm.
            anchor: "start", "middle" or "end" of the text.
            bold: whether in bold.
        """
        x, y = point
        weight = ' font-weight="bold"' if bold else ""
        place = f'x="{x:.2f}" y="{y:.2f}" font-size="{1.35 * height:.2f}" text-anchor="{anchor}"{weight}'
        self._elements.append(f"<text {place}>{escape(text, quote=False)}</text>")

    @contextmanager
    def moved(self, point: Point, rotation: float = 0.0) -> Iterator[None]:
        """Draw the elements of the block with their origin at a point, turned clockwise by degrees."""
        x, y = point
        self._elements.append(f'<g transform="translate({x:.2f} {y:.2f}) rotate({rotation:g})">')
        yield
        self._elements.append("</g>")

    @property
    def inner_width(self) -> float:
        """Width within the margins, mm."""
        return self.width - 2 * SHEET_MARGIN

    def title_block(self, title: str, notes: Sequence[str]) -> None:
        """Draw the border of the sheet, and below a title with notes."""
        top = self.height - title_height(notes)
        self.box((SHEET_MARGIN / 2, SHEET_MARGIN / 2), self.width - SHEET_MARGIN, self.height - SHEET_MARGIN, "bold")
        self.line((SHEET_MARGIN / 2, top), (self.width - SHEET_MARGIN / 2, top))
        self.text((SHEET_MARGIN, top + 5.0), title, height=3.5, bold=True)
        for i, note in enumerate(notes):
            self.text((SHEET_MARGIN, top + 9.5 + 3.6 * i), note, height=2.0)

    def document(self, title: str) -> str:
        """Return the SVG document, with a title for readers."""
        rules = "".join(f".{name}{{fill:none;stroke:#000;{rule}}}" for name, rule in LINE_RULES.items())
        size = f'width="{self.width:g}mm" height="{self.height:g}mm" viewBox="0 0 {self.width:g} {self.height:g}"'
        head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n<title>{escape(title, quote=False)}</title>'
        fonts = "text{font-family:Arial,Helvetica,sans-serif;fill:#000}"
        style = f"<style>{rules}.solid{{fill:#000;stroke:none}}{fonts}</style>"
        return "\n".join((head, style, '<rect width="100%" height="100%" fill="#fff"/>', *self._elements, "</svg>\n"))
