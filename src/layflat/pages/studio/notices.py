"""Notices above a design: it is kept as A, or a file was changed on the disk; the person chooses what follows."""

from collections.abc import Awaitable, Callable

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.studio.beside import LIMIT, reread
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


EVERY = 1.0  # between two looks at the files, s


class DiskView:
    """A line above the results, seen only where a file was changed."""

    def __init__(self, session: Session, reread: Callable[[], Awaitable[None]]) -> None:
        """Make it within the current element; `reread` is called when the files were read again."""
        self._session, self._reread = session, reread
        self._left: tuple[str, ...] = ()  # what is known to have changed, and was let be
        self._known: tuple[str, ...] = ()
        with ui.element("div").classes("lf-note lf-warning st-line").props("role=alert") as self._box:
            ui.icon("warning").props("aria-hidden=true")
            self._text = ui.label().classes("st-grow")
            theme.button("Reload, keep my changes", self._reload)
            theme.button("Go on without", self._go_on, kind="flat")
        self._box.set_visibility(False)
        if session.design.opened.files:
            ui.timer(EVERY, self._look)

    def _look(self) -> None:
        opened = self._session.design.opened
        changed = opened.changed_on_disk()
        self._known = tuple(f"{path}: {opened.state(path)}" for path in changed)
        self._box.set_visibility(bool(changed) and self._known != self._left)
        if changed:
            names = " and ".join(path.name for path in changed)
            self._text.set_text(f"{names} has changed on the disk since it was opened.")

    async def _reload(self) -> None:
        session = self._session
        try:
            design, dropped = await session.worker.beside.call(
                reread, session.design, limit=LIMIT, what="the reading of the file"
            )
        except LayflatError as error:
            self._text.set_text(str(error))
            return
        session.design.become(design)
        self._box.set_visibility(False)
        if dropped:
            text = f"These changes do not go with the file any more and were dropped: {', '.join(dropped)}"
            theme.say(text, "warning", stays=True)
        await self._reread()

    def _go_on(self) -> None:
        self._left = self._known
        self._box.set_visibility(False)
