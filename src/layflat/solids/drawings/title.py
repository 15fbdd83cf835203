"""Frame and title block of a sheet: ISO 5457 and ISO 7200; mm."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.paper import FORMATS
from layflat.solids.drawings.text import fit_height, shorten_text, text_width, wrap_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.solids.drawings.paper import Paper
    from layflat.solids.drawings.table import HoleTable

FILING_MARGIN, FRAME_MARGIN = 20.0, 10.0  # between the edge of the sheet and the frame: on the left, and elsewhere
FIELD_WIDTH = 50.0  # width of a field of the grid reference
FIELD_BORDER = 5.0  # outside the frame, with the names of the fields
BLOCK_WIDTH, BLOCK_ROW, BLOCK_ROWS = 180.0, 9.0, 4  # of the title block
BLOCK_HEIGHT = BLOCK_ROW * BLOCK_ROWS
CAPTION_HEIGHT = 1.8  # height of captions
TABLE_TEXT, TABLE_ROW = 2.2, 4.6  # height of the text and of a row of a table
TABLE_GAP = 4.0  # between a table and what is beside it
CELL_GAP = 1.6  # between a text and the lines of a table


class TitleBlock(NamedTuple):
    """Contents of a title block."""

    machine: str
    name: str
    number: str
    quantity: str
    material: str
    stock: str
    making: str
    tolerance: str
    mass: str
    assembly: str
    scale: str
    file: str

    def rows(self, paper: str) -> tuple[tuple[tuple[str, str, float], ...], ...]:
        """Return rows of cells: caption, value, width (mm)."""
        return (
            (("Machine", self.machine, 60), ("Name", self.name, 90), ("Item", self.number, 30)),
            (("Material", self.material, 75), ("Made from", self.stock, 75), ("Quantity", self.quantity, 30)),
            (("Making", self.making, 40), ("General tolerances", self.tolerance, 40), ("Mass of one", self.mass, 35),
             ("Assembly", self.assembly, 35), ("Scale", self.scale, 30)),
            (("Drawing", self.file, 104), ("Sizes in", "mm", 20), ("Projection", "", 36), ("Sheet", paper, 20)),
        )  # fmt: skip


class Area(NamedTuple):
    """Rectangle on a sheet."""

    left: float
    low: float
    right: float
    high: float

    @property
    def width(self) -> float:
        """Width, mm."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Height, mm."""
        return self.high - self.low


def free_areas(paper_format: str, table: HoleTable | None = None) -> list[Area]:
    """Return the areas of a format above the title block: the whole, or that beside a table and that below it."""
    width, height = FORMATS[paper_format]
    whole = Area(FILING_MARGIN, FRAME_MARGIN + BLOCK_HEIGHT, width - FRAME_MARGIN, height - FRAME_MARGIN)
    if table is None:
        return [whole]
    beside = whole.right - sum(column_widths(table)) - TABLE_GAP
    below = whole.high - (len(table.rows) + 1) * TABLE_ROW - TABLE_GAP
    return [whole._replace(right=beside), whole._replace(high=below)]


def draw_frame(paper: Paper) -> None:
    """Draw the frame with centring marks and the fields of the grid reference."""
    width, height = FORMATS[paper.format]
    left, low, right, high = FILING_MARGIN, FRAME_MARGIN, width - FRAME_MARGIN, height - FRAME_MARGIN
    paper.line([(left, low), (right, low), (right, high), (left, high)], "frame", closed=True)
    sides = ("top", "right") if paper.format == "A4" else ("top", "right", "bottom", "left")
    for side in sides:
        across = side in {"top", "bottom"}
        first, last, middle = (left, right, width / 2) if across else (low, high, height / 2)
        edge, out = {"top": (high, 1), "bottom": (low, -1), "right": (right, 1), "left": (left, -1)}[side]
        count = int((middle - first) // FIELD_WIDTH) + 1
        marks = [middle + FIELD_WIDTH * k for k in range(-count, count + 1)]
        borders = [first, *(mark for mark in marks if first + 1 < mark < last - 1), last]

        def border_point(
            along: float, beyond: float, across: bool = across, edge: float = edge, out: int = out
        ) -> tuple[float, float]:
            return (along, edge + out * beyond) if across else (edge + out * beyond, along)

        for mark in borders[1:-1]:
            if abs(mark - middle) > 1:
                paper.line([border_point(mark, 0.0), border_point(mark, FIELD_BORDER)], "thin")
        names = [str(k + 1) for k in range(20)] if across else [chr(ord("A") + k) for k in range(20)]
        fields = list(pairwise(borders))
        for name, (one, other) in zip(names, fields if across else fields[::-1], strict=False):
            x, y = border_point((one + other) / 2, FIELD_BORDER / 2)
            paper.text(x, y - 1.25, name, 2.5, "center")
        paper.line(
            [border_point(middle, -5.0), border_point(middle, 9.0 if across or side == "right" else 10.0)], "frame"
        )


def draw_title_block(paper: Paper, block: TitleBlock) -> None:
    """Draw the title block in the lower right corner."""
    width, _ = FORMATS[paper.format]
    left, y = width - FRAME_MARGIN - BLOCK_WIDTH, FRAME_MARGIN + BLOCK_HEIGHT
    paper.line([(left, FRAME_MARGIN), (left, y), (left + BLOCK_WIDTH, y)], "frame")
    for row in block.rows(paper.format):
        x = left
        for caption, value, cell in row:
            paper.text(x + 1.2, y - 1.0 - CAPTION_HEIGHT, caption, CAPTION_HEIGHT)
            room, height = cell - 2.4, 3.5 if caption in {"Name", "Item"} else 2.5
            paper.text(x + 1.2, y - BLOCK_ROW + 1.6, value, fit_height(value, height, room))
            if caption == "Projection":
                _draw_projection(paper, x + cell - 11.0, y - BLOCK_ROW / 2)
            x += cell
            if x < left + BLOCK_WIDTH - 1:
                paper.line([(x, y), (x, y - BLOCK_ROW)], "thin")
        y -= BLOCK_ROW
        if y > FRAME_MARGIN + 1:
            paper.line([(left, y), (left + BLOCK_WIDTH, y)], "thin")


def _draw_projection(paper: Paper, x: float, y: float) -> None:
    """Draw the symbol of the first-angle method (ISO 5456-2) about a point."""
    angles = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    for radius in (1.4, 2.8):
        paper.line(
            np.stack((x + 4.5 + radius * np.cos(angles), y + radius * np.sin(angles)), axis=-1), "thin", closed=True
        )
    paper.line([(x - 7.0, y - 1.4), (x - 1.0, y - 2.8), (x - 1.0, y + 2.8), (x - 7.0, y + 1.4)], "thin", closed=True)
    paper.line([(x - 8.0, y), (x, y)], "centre")
    paper.line([(x + 0.8, y), (x + 8.2, y)], "centre")
    paper.line([(x + 4.5, y - 3.6), (x + 4.5, y + 3.6)], "centre")


def draw_notes(paper: Paper, notes: Sequence[str]) -> None:
    """Write notes on the left of the title block."""
    width, _ = FORMATS[paper.format]
    room = width - FRAME_MARGIN - BLOCK_WIDTH - FILING_MARGIN - 6.0
    lines = [line for note in notes for line in wrap_text(note, TABLE_TEXT, room)]
    step = min(4.2, (BLOCK_HEIGHT - 4.0) / max(len(lines), 1))
    height = min(TABLE_TEXT, 0.62 * step)
    for k, line in enumerate(lines):
        paper.text(FILING_MARGIN + 3.0, FRAME_MARGIN + BLOCK_HEIGHT - 4.0 - k * step, line, height)


def column_widths(table: HoleTable) -> list[float]:
    """Return the widths of a table's columns, mm."""
    columns = zip(table.head, *table.rows, strict=True)
    return [max(text_width(text, TABLE_TEXT) for text in column) + 2 * CELL_GAP for column in columns]


def draw_table(paper: Paper, table: HoleTable, right: float, high: float) -> None:
    """Draw a table below and on the left of a corner.

    Args:
        paper: the sheet.
        table: its contents.
        right: x of the corner.
        high: y of the corner.
    """
    widths = column_widths(table)
    left, count = right - sum(widths), 1 + len(table.rows)
    borders = left + np.r_[0.0, np.cumsum(widths)]
    low = high - count * TABLE_ROW
    for x in borders:
        paper.line([(x, low), (x, high)], "thin")
    for k in range(count + 1):
        y = high - k * TABLE_ROW
        paper.line([(left, y), (right, y)], "outline" if k in {0, 1, count} else "thin")
    for k, row in enumerate((table.head, *table.rows)):
        y = high - (k + 1) * TABLE_ROW + (TABLE_ROW - TABLE_TEXT) / 2
        for end, text in zip(borders[1:], row, strict=True):
            paper.text(end - CELL_GAP, y, text, TABLE_TEXT, "right")


def draw_list(paper: Paper, rows: Sequence[tuple[str, str, str]], area: Area, columns: int) -> None:
    """Write a list of items in columns that fill an area from its top: number, name, quantity.

    Args:
        paper: the sheet.
        rows: of texts.
        area: of the sheet.
        columns: number of columns.
    """
    per_column = -(-len(rows) // columns)
    step = min(TABLE_ROW, area.height / (per_column + 1))
    height, wide = min(TABLE_TEXT, 0.5 * step), area.width / columns
    for k in range(columns):
        x = area.left + k * wide
        for row, (number, name, quantity) in enumerate(
            (("No.", "Name", "Qty"), *rows[k * per_column : (k + 1) * per_column])
        ):
            y = area.high - (row + 1) * step
            paper.text(x + 8.0, y + 0.3 * step, number, height, "right")
            paper.text(x + 10.0, y + 0.3 * step, shorten_text(name, height, wide - 20.0), height)
            paper.text(x + wide - 2.0, y + 0.3 * step, quantity, height, "right")
            paper.line([(x + 1.0, y), (x + wide - 1.0, y)], "outline" if row == 0 else "thin")
