"""Lines of text as matplotlib draws them, without the layout of paragraphs that its own texts go through."""

from __future__ import annotations

from functools import cache
from math import cos, radians, sin
from typing import TYPE_CHECKING

from matplotlib.font_manager import FontProperties, findfont
from matplotlib.text import Text

from layflat.solids.drawings.text import FONT_NAME

if TYPE_CHECKING:
    from matplotlib.backend_bases import RendererBase

WIDTH_SHARES = {"left": 0.0, "center": 0.5, "right": 1.0}
"""Share of a line's width that lies before its anchor."""


class TextLine(Text):
    """One line of black text on its base line, which turns about its anchor."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw the line, as matplotlib does on a figure."""
        text, font, angle = self.get_text(), self.get_fontproperties(), self.get_rotation()
        if not text:
            return
        x, y = self.get_transform().transform(self.get_position())
        if renderer.flipy():  # that of SVG, whose readers align texts themselves
            y = renderer.get_canvas_width_height()[1] - y
        elif share := WIDTH_SHARES[self.get_horizontalalignment()]:
            before = share * renderer.get_text_width_height_descent(text, font, False)[0]
            x, y = x - cos(radians(angle)) * before, y - sin(radians(angle)) * before
        renderer.open_group("text", self.get_gid())
        pen = renderer.new_gc()
        pen.set_foreground((0.0, 0.0, 0.0, 1.0), isRGBA=True)
        renderer.draw_text(pen, x, y, text, font, angle, ismath=False, mtext=self)
        pen.restore()
        renderer.close_group("text")
        self.stale = False


def font_of(size: float) -> FontProperties:
    """Return the font of drawings in a size, pt; its file is named so that it is not looked for at each text."""
    return FontProperties(family=FONT_NAME, fname=_font_file(), size=size)


@cache
def _font_file() -> str:
    return findfont(FontProperties(family=FONT_NAME))
