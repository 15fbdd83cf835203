"""A box of results on the page."""

from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.look.charts import STYLES

BLUE, RED, GREEN = (colour for colour, _ in STYLES[:3])
OTHER = "A: "  # before the names of lines of the design that is kept as A
CHAIN = [8, 4]
HEIGHT = "13.5rem"
WAITING = "Waiting for the first figures."


class Panel:
    """A box with a heading, which is grey while its content is older than the newest edit."""

    def __init__(self, title: str) -> None:
        with theme.panel(title) as self.head:
            with self.head:
                self._mark = ui.label("computing").classes("st-computing").props("aria-hidden=true")
            self.content = ui.element("div").classes("st-content")
        self.current(False)

    def current(self, yes: bool) -> None:
        """Show whether the content belongs to the newest edit."""
        self._mark.set_visibility(not yes)
        self.content.classes(add="" if yes else "st-old", remove="st-old" if yes else "")
