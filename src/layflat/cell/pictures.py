"""Pictures of a packing run: a contact sheet with a picture of each pick, and films as MP4 or GIF."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from math import ceil
from pathlib import Path
from typing import Any, Self

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageOps
from PIL.ImageFont import FreeTypeFont, truetype

from layflat import extras
from layflat.arrays import Picture
from layflat.errors import InputError, OutputError
from layflat.files import whole_file

__all__ = ["ContactSheet", "Film", "add_caption"]

INK_COLOUR, PAPER_COLOUR = (26, 26, 26), (255, 255, 255)
CaptionLines = tuple[str, str]
TILE_SIZE = (
    300,
    225,
)  # width and height of a pick's picture, px: as many of the camera's, so that drawings stay legible
TILE_GAP, TEXT_HEIGHT, TITLE_HEIGHT = 20, 14, 22  # between tiles, and heights of captions and title, px
CAPTION_HEIGHT = 3 * TEXT_HEIGHT  # height of the two lines under a picture, px
OVERVIEW_COLUMNS, OVERVIEW_ROWS = 2, 2  # tiles that the overview replaces
FRAME_COLOUR, FAILURE_COLOUR, OUTSIDE_GREY = (150, 150, 150), (176, 0, 32), 205
"""Colours of frames, of a failed pick's, and of what lies beyond a picture."""
H264 = {"preset": "veryfast", "crf": "23"}  # of x264: a film of the cell takes some 30 kB a second
ENCODER_THREADS = 1  # with two the same film has other bytes now and then, and is not there sooner


def check_suffix(path: Path, *suffixes: str) -> str:
    """Return the suffix of a path in lower case; raise OutputError unless it is one of `suffixes`."""
    suffix = path.suffix.lower()
    if suffix not in suffixes:
        problem = f"{path.suffix!r} is not a kind of file that is written here" if suffix else "has no suffix"
        raise OutputError(problem, where=str(path), right=f"give a path that ends in {' or '.join(suffixes)}")
    return suffix


@lru_cache
def load_font(size: int, *, bold: bool = False) -> FreeTypeFont:
    """Return DejaVu Sans, which comes with matplotlib, `size` px high."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


def fit_text(text: str, font: FreeTypeFont, width: float) -> str:
    """Return a text, cut with an ellipsis where it is wider than allowed.

    Args:
        text: one line.
        font: font of the text.
        width: upper limit of its width, px.
    """
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "\N{HORIZONTAL ELLIPSIS}") > width:
        text = text[:-1]
    return text.rstrip() + "\N{HORIZONTAL ELLIPSIS}"


class ContactSheet:
    """Contact sheet: pictures of picks in columns (at least 2, or InputError), with an optional overview at its corner.

    The title, its head line, may be set until it is drawn.
    """

    def __init__(self, title: str, columns: int = 5) -> None:
        """Begin a sheet without tiles; raise InputError for less than 2 columns."""
        if columns < OVERVIEW_COLUMNS:
            raise InputError(
                f"{columns} is too few", where="columns of a sheet", right=f"give {OVERVIEW_COLUMNS} or more"
            )
        self.title, self._columns = title, columns
        self._overview: tuple[Picture, CaptionLines] | None = None
        self._tiles: list[tuple[Image.Image, CaptionLines, str]] = []

    def overview(self, picture: Picture, lines: CaptionLines) -> None:
        """Set the large picture, (H, W, 3) RGB, and the two lines below it."""
        self._overview = picture.copy(), lines

    def add(self, picture: Picture, at: tuple[float, float], lines: CaptionLines, *, failed: str = "") -> None:
        """Add a tile: the part of a picture around a pick, with two lines below it.

        Args:
            picture: (H, W, 3) RGB.
            at: position of the pick from the left and from the top, px.
            lines: text below the tile.
            failed: word for how the pick failed, such as "missed": the tile is framed in dashes; empty: it did not.
        """
        tile = Image.new("RGB", TILE_SIZE, (OUTSIDE_GREY,) * 3)
        tile.paste(Image.fromarray(picture), (TILE_SIZE[0] // 2 - round(at[0]), TILE_SIZE[1] // 2 - round(at[1])))
        self._tiles.append((tile, lines, failed))

    def picture(self) -> Picture:
        """Return the sheet, (H, W, 3) RGB."""
        return np.asarray(self._draw_sheet())

    def save(self, path: Path) -> Path:
        """Write the sheet; raise OutputError if the path does not end in .png, or can't be written."""
        check_suffix(path, ".png")
        with whole_file(path) as temporary:
            self._draw_sheet().save(temporary)
        return path

    def _draw_sheet(self) -> Image.Image:
        """Return the sheet as an image: title, overview at its corner, and tiles with captions and marks."""
        (wide, high), columns = TILE_SIZE, self._columns
        across, overview_rows = (0, 1) if self._overview is None else (OVERVIEW_COLUMNS, OVERVIEW_ROWS)
        occupied = {(row, column) for row in range(overview_rows) for column in range(across)}
        rows = max(ceil((len(self._tiles) + len(occupied)) / columns), overview_rows)
        cells = [(row, column) for row in range(rows) for column in range(columns) if (row, column) not in occupied]
        top, down, right = TILE_GAP + 2 * TITLE_HEIGHT, high + CAPTION_HEIGHT + TILE_GAP, wide + TILE_GAP
        sheet = Image.new("RGB", (TILE_GAP + columns * right, top + rows * down), PAPER_COLOUR)
        draw = ImageDraw.Draw(sheet)
        head = load_font(TITLE_HEIGHT, bold=True)
        draw.text((TILE_GAP, TILE_GAP), fit_text(self.title, head, sheet.width - 2 * TILE_GAP), INK_COLOUR, head)
        if self._overview is not None:
            picture, lines = self._overview
            room = OVERVIEW_COLUMNS * right - TILE_GAP, OVERVIEW_ROWS * down - TILE_GAP - CAPTION_HEIGHT
            large = ImageOps.contain(Image.fromarray(picture), room, Image.Resampling.LANCZOS)
            _paste_picture(sheet, draw, large, (TILE_GAP, top), lines)
        for (tile, lines, failed), (row, column) in zip(self._tiles, cells, strict=False):
            corner = TILE_GAP + column * right, top + row * down
            _paste_picture(sheet, draw, tile, corner, lines)
            _draw_ticks(draw, corner)
            if failed:
                _mark_failed(draw, corner, failed)
        return sheet


def _paste_picture(
    sheet: Image.Image, draw: ImageDraw.ImageDraw, picture: Image.Image, at: tuple[int, int], lines: CaptionLines
) -> None:
    """Paste a picture with a frame at a corner (x, y), px, and draw its caption lines below."""
    (x, y), (wide, high) = at, picture.size
    sheet.paste(picture, at)
    draw.rectangle((x - 1, y - 1, x + wide, y + high), outline=FRAME_COLOUR)
    for i, line in enumerate(lines):
        font = load_font(TEXT_HEIGHT, bold=i == 0)
        draw.text((x, y + high + (0.4 + 1.3 * i) * TEXT_HEIGHT), fit_text(line, font, wide), INK_COLOUR, font)


def _draw_ticks(draw: ImageDraw.ImageDraw, at: tuple[int, int]) -> None:
    """Draw ticks at the edges of a tile that point to its middle."""
    (x, y), (wide, high), long = at, TILE_SIZE, 12
    for colour, thick in ((INK_COLOUR, 5), (PAPER_COLOUR, 3)):
        for side in (x, x + wide - long):
            draw.line((side, y + high // 2, side + long - 1, y + high // 2), colour, thick)
        for side in (y, y + high - long):
            draw.line((x + wide // 2, side, x + wide // 2, side + long - 1), colour, thick)


def _mark_failed(draw: ImageDraw.ImageDraw, at: tuple[int, int], word: str) -> None:
    """Frame a tile in thick dashes, and write a word at its upper left."""
    (x, y), (wide, high), thick, dash = at, TILE_SIZE, 5, 15
    for begin in range(0, wide, 2 * dash):
        for side in (y, y + high - thick):
            draw.rectangle((x + begin, side, x + begin + dash - 1, side + thick - 1), fill=FAILURE_COLOUR)
    for begin in range(0, high, 2 * dash):
        for side in (x, x + wide - thick):
            draw.rectangle((side, y + begin, side + thick - 1, y + begin + dash - 1), fill=FAILURE_COLOUR)
    font, text = load_font(TEXT_HEIGHT, bold=True), f"\N{MULTIPLICATION X} {word}"
    box = (
        x + 2 * thick,
        y + 2 * thick,
        x + 2 * thick + font.getlength(text) + TEXT_HEIGHT,
        y + 2 * thick + 1.7 * TEXT_HEIGHT,
    )
    draw.rectangle(box, fill=PAPER_COLOUR, outline=FAILURE_COLOUR, width=2)
    draw.text(((box[0] + box[2]) / 2, (box[1] + box[3]) / 2), text, FAILURE_COLOUR, font, "mm")


class Film:
    """Film that is written frame by frame, in a `with` block; the file exists only if the block ends without an error.

    All frames have the size of the first. A GIF has the 256 colours of the first, and times in hundredths of a second.

    Args:
        path: ends in .mp4 or .gif.
        fps: frames a second, up to 100.

    Raises:
        OutputError: the path ends otherwise or can't be written, or the film has no frame.
        InputError: PyAV is not installed, or `fps` or a frame's size is wrong.
    """

    def __init__(self, path: Path, fps: float = 20.0) -> None:
        """Check path, encoder and rate; the `with` block opens the file."""
        self._av, self._path, self._gif = (
            extras.import_extra("cell", "av"),
            path,
            check_suffix(path, ".mp4", ".gif") == ".gif",
        )
        if not 0.0 < fps <= 100.0:
            raise InputError(f"{fps:g} is out of range", where="fps", right="give more than 0, up to 100 a second")
        self._rate = Fraction(fps).limit_denominator(1000)
        self._shape: tuple[int, ...] = ()
        self._frames = 0

    def add(self, frame: Picture) -> None:
        """Encode a frame, (H, W, 3) RGB; raise InputError unless it has the size of the first."""
        if not self._shape:
            self._start_stream(frame)
        if frame.shape != self._shape:
            what = f"has the shape {frame.shape}, the first frame {self._shape}"
            raise InputError(what, where="frame of a film", right="give all frames one size")
        encoded = self._indexed(frame) if self._gif else self._even_sized(frame)
        encoded.pts = self._frames
        self._frames += 1
        self._file.mux(self._stream.encode(encoded))

    def __enter__(self) -> Self:
        self._writing = self._open_file()
        self._writing.__enter__()
        return self

    def __exit__(self, *raised: Any) -> bool | None:
        return self._writing.__exit__(*raised)

    @contextmanager
    def _open_file(self) -> Iterator[None]:
        """Open the film's file; at its end finish the stream, or raise OutputError if there was no frame."""
        options = {} if self._gif else {"movflags": "+faststart"}
        with whole_file(self._path) as temporary:
            with self._av.open(str(temporary), "w", options=options) as self._file:
                yield
                if self._shape:
                    self._file.mux(self._stream.encode())
            if not self._shape:
                raise OutputError("the film has no frame", where=str(self._path), right="add one or more")

    def _start_stream(self, frame: Picture) -> None:
        """Start the stream in the size of the first frame, for MP4 rounded up to even; GIF gets its colours."""
        self._shape = frame.shape
        height, width = frame.shape[:2]
        if self._gif:
            self._colours = Image.fromarray(frame).quantize(256)
            rgb = np.array(self._colours.getpalette(), np.uint8).reshape(-1, 3)
            self._palette = np.full((256, 4), 255, np.uint8)  # alpha first
            self._palette[: len(rgb), 1:] = rgb
            self._stream = self._file.add_stream("gif", rate=self._rate)
            self._stream.pix_fmt = "pal8"
        else:
            # Colours at half the resolution: sizes are even.
            height, width = height + height % 2, width + width % 2
            self._stream = self._file.add_stream("libx264", rate=self._rate, options=H264)
            self._stream.pix_fmt, self._stream.thread_count = "yuv420p", ENCODER_THREADS
        self._stream.width, self._stream.height = width, height

    def _even_sized(self, frame: Picture) -> Any:
        """Return a frame for MP4, whose last row and column are repeated to even sizes."""
        height, width = frame.shape[:2]
        if height % 2 or width % 2:
            frame = np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), "edge")
        return self._av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")

    def _indexed(self, frame: Picture) -> Any:
        """Return a frame for GIF, in the 256 colours of the first frame, without dithering."""
        image = Image.fromarray(frame).quantize(palette=self._colours, dither=Image.Dither.NONE)
        return self._av.VideoFrame.from_ndarray((np.asarray(image), self._palette), format="pal8")


def add_caption(frame: Picture, left: str, right: str = "") -> Picture:
    """Return a frame with a strip of 1/18 of its height below it, (H + strip, W, 3), and a text at each end.

    Args:
        frame: (H, W, 3) RGB.
        left: text at the left end.
        right: text at the right end.
    """
    height, width = frame.shape[:2]
    return np.vstack([frame, _caption_strip(width, 2 * round(height / 36), left, right)])


@lru_cache(maxsize=8)
def _caption_strip(width: int, height: int, left: str, right: str) -> Picture:
    """Return the strip of a caption, (height, width, 3), with a text at each end, cut to fit."""
    strip, font, margin = Image.new("RGB", (width, height), INK_COLOUR), load_font(round(0.55 * height)), height // 3
    draw, middle = ImageDraw.Draw(strip), height / 2
    right = fit_text(right, font, width - 2 * margin)
    room = width - 3 * margin - font.getlength(right)
    draw.text((width - margin, middle), right, PAPER_COLOUR, font, "rm")
    draw.text((margin, middle), fit_text(left, font, room), PAPER_COLOUR, font, "lm")
    return np.asarray(strip)
