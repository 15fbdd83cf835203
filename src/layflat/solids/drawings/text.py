"""Widths of texts on a sheet, and texts that fit into a room; mm."""

from __future__ import annotations

from functools import cache

CAPITAL_HEIGHT = 0.729  # of a capital letter of the font over the font's size
FONT_NAME = "DejaVu Sans"  # matplotlib brings it


@cache
def text_width(text: str, height: float) -> float:
    """Return the width of a line of text, from the height of its capital letters."""
    from matplotlib.font_manager import FontProperties  # noqa: PLC0415
    from matplotlib.textpath import text_to_path  # noqa: PLC0415

    width, _, _ = text_to_path.get_text_width_height_descent(text, FontProperties(family=FONT_NAME, size=100), False)
    return float(width) * height / CAPITAL_HEIGHT / 100


def fit_height(text: str, height: float, room: float) -> float:
    """Return the height of a text: the one that is given, or less so that it is no wider than the room.

    Args:
        text: the text.
        height: of capital letters.
        room: width that it may have.
    """
    return min(height, height * room / max(text_width(text, height), 1e-9))


def shorten_text(text: str, height: float, room: float) -> str:
    """Return a text, cut at a word and with an ellipsis if it is wider than the room.

    Args:
        text: the text.
        height: of capital letters.
        room: width that it may have.
    """
    if text_width(text, height) <= room:
        return text
    while text and text_width(text + " …", height) > room:
        text = text.rpartition(" ")[0] if " " in text else text[:-1]
    return text + " …"


def wrap_text(text: str, height: float, room: float) -> list[str]:
    """Return a text in lines that are no wider than the room.

    Args:
        text: the text.
        height: of capital letters.
        room: width that it may have.
    """
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer, height) <= room:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
