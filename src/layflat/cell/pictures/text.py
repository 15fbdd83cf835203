"""Text in pictures: one typeface for films and sheets."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

INK, PAPER = (26, 26, 26), (255, 255, 255)


@lru_cache
def font(size: int, *, bold: bool = False) -> FreeTypeFont:
    """DejaVu Sans, which comes with matplotlib, `size` px high."""
    import matplotlib as mpl  # noqa: PLC0415  # both take long to import
    from PIL import ImageFont  # noqa: PLC0415

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


def fitted(text: str, written: FreeTypeFont, width: float) -> str:
    """A text, or as much of its beginning as has room in `width` px, with an ellipsis."""
    if written.getlength(text) <= width:
        return text
    while text and written.getlength(text + "\N{HORIZONTAL ELLIPSIS}") > width:
        text = text[:-1]
    return text.rstrip() + "\N{HORIZONTAL ELLIPSIS}"
