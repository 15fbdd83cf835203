"""The page of the studio: what a tab is made of, and which part follows which change."""

import asyncio
import time
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from nicegui import background_tasks, events, ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces, arrived
from layflat.pages.studio.beside import LIMIT, open_design
from layflat.pages.studio.commands import Commands
from layflat.pages.studio.editor import Editor
from layflat.pages.studio.notices import DiskView, KeptView
from layflat.pages.studio.results_view import ResultsView
from layflat.pages.studio.session import Session, What
from layflat.pages.studio.tabs import Tabs
from layflat.pages.studio.worker import Worker

TITLE = "layflat studio"
KINDS: tuple[What, ...] = ("figures", "cloud", "kept", "design")
PATIENCE = 1.5  # after so long a wait a page says what it waits for, s
OWN = "Each tab edits a design of its own, and only Save writes to the disk."
NO_NATIVE_UNDO = """({event}) => {
  const undoes = (event.ctrlKey || event.metaKey) && ['z', 'y'].includes(event.key.toLowerCase());
  if (undoes && !document.querySelector('.q-dialog')) event.preventDefault();
}"""
"""A browser would undo what was typed last, in whatever field."""


@lru_cache(maxsize=1)
def shared_worker() -> Worker:
    """Return the process that simulates for all tabs."""
    return Worker()


@lru_cache(maxsize=1)
def _tabs() -> Tabs:
    return Tabs()


async def studio_page(machine: str, folder: Path | None = None) -> None:
    """Build the page of a tab, a design session of its own, within the present client.

    Args:
        machine: built-in name or file.
        folder: that results are saved in; default: the current one.
    """
    client = ui.context.client
    if not await arrived():
        return
    worker = shared_worker()
    try:
        design = await worker.beside.call(open_design, machine, limit=LIMIT, what="the reading of the file")
        session = await _tabs().session(client, lambda: Session(design, worker))
    except LayflatError as error:
        with theme.frame(TITLE, machine):
            theme.note(str(error), "danger")
        return
    await StudioPage(session, folder or Path.cwd()).build()


class StudioPage:
    """Content of a tab."""

    def __init__(self, session: Session, folder: Path) -> None:
        """Take what it shows; `build` shows it."""
        self.session, self._folder = session, folder

    async def build(self) -> None:
        """Build it within the present client, piece by piece."""
        session, pieces = self.session, Pieces()
        with theme.frame(TITLE, session.design.machine.name) as frame:
            ui.add_css(files("layflat.pages.studio").joinpath("studio.css").read_text(encoding="utf-8"))
            frame.body.classes("st-page")
            self.commands = Commands(session, self._folder, self._edited)
            with frame.buttons:
                self.commands.build()
            await pieces.pause()
            with ui.element("div").classes("st-columns"):
                with ui.element("section").classes("st-left").props('aria-label="Values of the description"'):
                    self.editor = Editor(session.design, self._edited)
                    await self.editor.build()
                    ui.label(OWN).classes("st-own")
                with ui.element("section").classes("st-right").props('aria-label="Results" tabindex=0'):
                    DiskView(session, self._reread)
                    self.kept = KeptView(session, self._edited)
                    self.results = ResultsView(session, self._look_at)
                    await self.results.build(pieces)
        self.subtitle = frame.subtitle
        await pieces.pause()
        self.editor.look_at(session.step.joint)
        ui.keyboard(self._key, ignore=[]).on("key", js_handler=NO_NATIVE_UNDO)
        ui.timer(0.5, self._tell_wait)
        session.listen(self._changed)
        for what in KINDS:
            await pieces.pause()
            self._changed(what)
        self._follow()

    def _follow(self) -> None:
        client = ui.context.client
        task: asyncio.Task[None] = background_tasks.create(self._work(), name="studio results", context=client)

        def end() -> None:
            task.cancel()
            self.commands.tune.end()

        client.on_delete(end)

    async def _work(self) -> None:
        await self.session.follow()

    def _edited(self) -> None:
        self.session.renew()

    def _look_at(self, joint: str) -> None:
        self.editor.look_at(joint)
        self.session.look_at(joint)

    async def _reread(self) -> None:
        await self.editor.rebuild()
        self.editor.look_at(self.session.step.joint)
        self.session.renew()

    def _changed(self, what: What) -> None:
        session = self.session
        if what == "design":
            self.editor.refresh()
            self.commands.refresh()
            changed = len(session.design.changes)
            count = f"{changed} value{'s' * (changed != 1)} changed" if changed else "as opened"
            self.subtitle.set_text(f"{session.design.machine.name}: {count}")
        if what in {"design", "kept"}:
            self.kept.refresh()
        self.results.changed(what)

    def _tell_wait(self) -> None:
        since = self.session.waiting_since
        if since is not None and time.monotonic() - since > PATIENCE:
            seconds = f"{time.monotonic() - since:.0f} s"
            self.results.step.wait(f"Simulating for {seconds}: compiling, the first time only for such a machine.")

    def _key(self, event: events.KeyEventArguments) -> None:
        if not event.action.keydown or not (event.modifiers.ctrl or event.modifiers.meta) or self.commands.asking:
            return
        key = str(event.key).lower()
        act: Callable[[], None] | None = None
        if key == "z":
            act = self.commands.redo if event.modifiers.shift else self.commands.undo
        elif key == "y":
            act = self.commands.redo
        if act is not None and not self.editor.reset_typed():
            act()
