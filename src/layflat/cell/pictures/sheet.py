"""A contact sheet of a packing run: an overview, and a picture of each pick with what came of it."""

from functools import lru_cache
from math import ceil
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageOps
from PIL.ImageFont import FreeTypeFont, truetype

from layflat.arrays import Picture
from layflat.errors import InputError, OutputError
from layflat.files import whole_file

INK, PAPER = (26, 26, 26), (255, 255, 255)


def of_kind(path: Path, *suffixes: str) -> str:
    """Return the suffix of a path; raise OutputError unless it is one of those given."""
    suffix = path.suffix.lower()
    if suffix not in suffixes:
        problem = f"{path.suffix!r} is not a kind of file that is written here" if suffix else "has no suffix"
        raise OutputError(problem, where=str(path), right=f"give a path that ends in {' or '.join(suffixes)}")
    return suffix


@lru_cache
def font(size: int, *, bold: bool = False) -> FreeTypeFont:
    """Return DejaVu Sans, which comes with matplotlib, `size` px high."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


def fitted(text: str, written: FreeTypeFont, width: float) -> str:
    """Return a text, or as much of its beginning as has room in `width` px, with an ellipsis."""
    if written.getlength(text) <= width:
        return text
    while text and written.getlength(text + "\N{HORIZONTAL ELLIPSIS}") > width:
        text = text[:-1]
    return text.rstrip() + "\N{HORIZONTAL ELLIPSIS}"


Lines = tuple[str, str]
TILE = (300, 225)  # width and height of a pick's picture, px: as many of the camera's, so that drawings stay legible
GAP, TEXT, TITLE = 20, 14, 22  # between tiles, and heights of captions and title, px
CAPTION = 3 * TEXT  # height of the two lines under a picture, px
ACROSS, DOWN = 2, 2  # tiles in whose place the overview stands
EDGE, ALARM, BEYOND = (150, 150, 150), (176, 0, 32), 205
"""Colours of frames, of a failed pick's, and of what lies beyond a picture."""


class ContactSheet:
    """Pictures of picks in columns (at least 2, or InputError), with an overview at the upper left where there is one.

    The title is the head line, settable until it is drawn.
    """

    def __init__(self, title: str, columns: int = 5) -> None:
        if columns < ACROSS:
            raise InputError(f"{columns} is too few", where="columns of a sheet", right=f"give {ACROSS} or more")
        self.title, self._columns = title, columns
        self._overview: tuple[Picture, Lines] | None = None
        self._tiles: list[tuple[Image.Image, Lines, str]] = []

    def overview(self, picture: Picture, lines: Lines) -> None:
        """Show a picture large, (H, W, 3) RGB, with two lines under it."""
        self._overview = picture.copy(), lines

    def add(self, picture: Picture, at: tuple[float, float], lines: Lines, *, failed: str = "") -> None:
        """Show what a picture (H, W, 3), RGB, has around a pick `at` (px from the left, from the top), with two lines.

        A word for how the pick failed, such as "missed", marks the tile, which is then framed in dashes.
        """
        tile = Image.new("RGB", TILE, (BEYOND,) * 3)
        tile.paste(Image.fromarray(picture), (TILE[0] // 2 - round(at[0]), TILE[1] // 2 - round(at[1])))
        self._tiles.append((tile, lines, failed))

    def picture(self) -> Picture:
        """The sheet, (H, W, 3) RGB."""
        return np.asarray(self._drawn())

    def save(self, path: Path) -> Path:
        """Write the sheet; raise OutputError if the path does not end in .png, or can't be written."""
        of_kind(path, ".png")
        with whole_file(path) as temporary:
            self._drawn().save(temporary)
        return path

    def _drawn(self) -> Image.Image:
        (wide, high), columns = TILE, self._columns
        across, below = (0, 1) if self._overview is None else (ACROSS, DOWN)
        taken = {(row, column) for row in range(below) for column in range(across)}
        rows = max(ceil((len(self._tiles) + len(taken)) / columns), below)
        cells = [(row, column) for row in range(rows) for column in range(columns) if (row, column) not in taken]
        top, down, right = GAP + 2 * TITLE, high + CAPTION + GAP, wide + GAP
        sheet = Image.new("RGB", (GAP + columns * right, top + rows * down), PAPER)
        draw = ImageDraw.Draw(sheet)
        head = font(TITLE, bold=True)
        draw.text((GAP, GAP), fitted(self.title, head, sheet.width - 2 * GAP), INK, head)
        if self._overview is not None:
            picture, lines = self._overview
            room = ACROSS * right - GAP, DOWN * down - GAP - CAPTION
            large = ImageOps.contain(Image.fromarray(picture), room, Image.Resampling.LANCZOS)
            _paste(sheet, draw, large, (GAP, top), lines)
        for (tile, lines, failed), (row, column) in zip(self._tiles, cells, strict=False):
            at = GAP + column * right, top + row * down
            _paste(sheet, draw, tile, at, lines)
            _aim(draw, at)
            if failed:
                _mark(draw, at, failed)
        return sheet


def _paste(
    sheet: Image.Image, draw: ImageDraw.ImageDraw, picture: Image.Image, at: tuple[int, int], lines: Lines
) -> None:
    (x, y), (wide, high) = at, picture.size
    sheet.paste(picture, at)
    draw.rectangle((x - 1, y - 1, x + wide, y + high), outline=EDGE)
    for i, line in enumerate(lines):
        written = font(TEXT, bold=i == 0)
        draw.text((x, y + high + (0.4 + 1.3 * i) * TEXT), fitted(line, written, wide), INK, written)


def _aim(draw: ImageDraw.ImageDraw, at: tuple[int, int]) -> None:
    """Ticks at the edges of a tile, which point to its middle."""
    (x, y), (wide, high), long = at, TILE, 12
    for colour, thick in ((INK, 5), (PAPER, 3)):
        for side in (x, x + wide - long):
            draw.line((side, y + high // 2, side + long - 1, y + high // 2), colour, thick)
        for side in (y, y + high - long):
            draw.line((x + wide // 2, side, x + wide // 2, side + long - 1), colour, thick)


def _mark(draw: ImageDraw.ImageDraw, at: tuple[int, int], word: str) -> None:
    """Frame a tile in thick dashes, and write a word at its upper left."""
    (x, y), (wide, high), thick, dash = at, TILE, 5, 15
    for begin in range(0, wide, 2 * dash):
        for side in (y, y + high - thick):
            draw.rectangle((x + begin, side, x + begin + dash - 1, side + thick - 1), fill=ALARM)
    for begin in range(0, high, 2 * dash):
        for side in (x, x + wide - thick):
            draw.rectangle((side, y + begin, side + thick - 1, y + begin + dash - 1), fill=ALARM)
    written, text = font(TEXT, bold=True), f"\N{MULTIPLICATION X} {word}"
    box = x + 2 * thick, y + 2 * thick, x + 2 * thick + written.getlength(text) + TEXT, y + 2 * thick + 1.7 * TEXT
    draw.rectangle(box, fill=PAPER, outline=ALARM, width=2)
    draw.text(((box[0] + box[2]) / 2, (box[1] + box[3]) / 2), text, ALARM, written, "mm")
