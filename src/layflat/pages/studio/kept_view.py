"""Say that a design is kept as A, what it looks like in the charts, and let the person return to it or drop it."""

from collections.abc import Callable

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.studio.session import Session


class KeptView:
    """A line above the results, seen while there is an A."""

    def __init__(self, session: Session, edited: Callable[[], object]) -> None:
        """Make it within the current element; `edited` is called when the design has become A again."""
        self._session, self._edited = session, edited
        with ui.element("div").classes("lf-note st-line") as self._box:
            ui.icon("push_pin").props("aria-hidden=true")
            self._text = ui.label().classes("st-grow")
            self._return = theme.button("Return", self._go_back, hint="Return to A: an edit that can be undone")
            theme.button("Drop", session.drop, kind="flat", hint="Drop A: compare no more")
        self.refresh()

    def refresh(self) -> None:
        """Show what there is."""
        kept = self._session.kept
        self._box.set_visibility(kept is not None)
        if kept is not None:
            changed = len(kept.changes)
            count = f"{changed} value{'s' * (changed != 1)} changed" if changed else "as opened"
            self._text.set_text(f"Red and dashed: A, kept at {kept.since}, {count}.")
            self._return.set_enabled(kept.changes != self._session.design.changes)

    def _go_back(self) -> None:
        kept = self._session.kept
        if kept is None:
            return
        try:
            self._session.design.replace_all(kept.changes)
        except LayflatError as error:
            theme.say(str(error), "danger")
            return
        self._edited()
