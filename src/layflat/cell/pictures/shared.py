"""What films and sheets share: one typeface, and where they go."""

from functools import lru_cache
from pathlib import Path

import matplotlib as mpl
from PIL.ImageFont import FreeTypeFont, truetype

from layflat.errors import OutputError

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
