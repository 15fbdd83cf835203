"""Films of the cell: H.264 that any browser plays, or an animated GIF."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any, Self

import numpy as np
from PIL import Image, ImageDraw

from layflat import extras
from layflat.arrays import Picture
from layflat.cell.pictures.sheet import INK, PAPER, fitted, font, of_kind
from layflat.errors import InputError, OutputError
from layflat.files import whole_file

H264 = {"preset": "veryfast", "crf": "23"}  # of x264: a film of the cell takes some 30 kB a second
THREADS = 1  # with two the same film has other bytes now and then, and is not there sooner


class Film:
    """A film that is written frame by frame, in a `with` block; it is there when the block ends well, or not at all.

    All frames have the size of the first. A GIF has the 256 colours of the first, and times that are hundredths of s.
    The path ends in .mp4 or .gif; there are up to 100 frames a second. Raise OutputError if it ends otherwise, can't be
    written or has no frame, InputError if PyAV is not installed, or for `fps` or a frame's size.
    """

    def __init__(self, path: Path, fps: float = 20.0) -> None:
        self._av, self._path, self._gif = extras.module("cell", "av"), path, of_kind(path, ".mp4", ".gif") == ".gif"
        if not 0.0 < fps <= 100.0:
            raise InputError(f"{fps:g} frames a second are not shown", where="fps", right="give 20, or any up to 100")
        self._rate = Fraction(fps).limit_denominator(1000)
        self._shape: tuple[int, ...] = ()
        self._frames = 0

    def add(self, frame: Picture) -> None:
        """Go on by a frame, (H, W, 3) RGB."""
        if not self._shape:
            self._begin(frame)
        if frame.shape != self._shape:
            raise InputError(f"{frame.shape} is not {self._shape}", where="frame of a film", right="give all one size")
        made = self._indexed(frame) if self._gif else self._even(frame)
        made.pts = self._frames
        self._frames += 1
        self._file.mux(self._stream.encode(made))

    def __enter__(self) -> Self:
        self._writing = self._written()
        self._writing.__enter__()
        return self

    def __exit__(self, *raised: Any) -> bool | None:
        return self._writing.__exit__(*raised)

    @contextmanager
    def _written(self) -> Iterator[None]:
        options = {} if self._gif else {"movflags": "+faststart"}
        with whole_file(self._path) as temporary:
            with self._av.open(str(temporary), "w", options=options) as self._file:
                yield
                if self._shape:
                    self._file.mux(self._stream.encode())
            if not self._shape:
                raise OutputError("the film has no frame", where=str(self._path), right="add some")

    def _begin(self, frame: Picture) -> None:
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
            self._stream.pix_fmt, self._stream.thread_count = "yuv420p", THREADS
        self._stream.width, self._stream.height = width, height

    def _even(self, frame: Picture) -> Any:
        height, width = frame.shape[:2]
        if height % 2 or width % 2:
            frame = np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), "edge")
        return self._av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")

    def _indexed(self, frame: Picture) -> Any:
        image = Image.fromarray(frame).quantize(palette=self._colours, dither=Image.Dither.NONE)
        return self._av.VideoFrame.from_ndarray((np.asarray(image), self._palette), format="pal8")


def captioned(frame: Picture, left: str, right: str = "") -> Picture:
    """A frame with a strip under it, a text at each end; the strip is 1/18 of the frame's height. (H + strip, W, 3)."""
    height, width = frame.shape[:2]
    return np.vstack([frame, _strip(width, 2 * round(height / 36), left, right)])


@lru_cache(maxsize=8)
def _strip(width: int, height: int, left: str, right: str) -> Picture:
    strip, written, margin = Image.new("RGB", (width, height), INK), font(round(0.55 * height)), height // 3
    draw, middle = ImageDraw.Draw(strip), height / 2
    right = fitted(right, written, width - 2 * margin)
    room = width - 3 * margin - written.getlength(right)
    draw.text((width - margin, middle), right, PAPER, written, "rm")
    draw.text((margin, middle), fitted(left, written, room), PAPER, written, "lm")
    return np.asarray(strip)
