"""Page of the studio: the views of a tab, and their updates after each change."""

import asyncio
import time
from collections import OrderedDict
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from nicegui import Client, background_tasks, events, ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces, wait_for_browser
from layflat.pages.studio.commands import Commands, DiskView, KeptView
from layflat.pages.studio.editor import Editor
from layflat.pages.studio.results_view import ResultsView
from layflat.pages.studio.session import ChangedPart, StudioSession
from layflat.pages.studio.worker import StudioProcesses, open_design

MAX_SESSIONS = 20  # sessions that are kept, those of closed tabs included
RELOAD_TIMEOUT = 1.0  # for the previous page of a tab to disconnect when it is reloaded, s
RELOAD_POLLS = 20
STUDIO_TITLE = "layflat studio"
KINDS: tuple[ChangedPart, ...] = ("figures", "cloud", "kept", "solids", "design")
WAIT_NOTICE_DELAY = 1.5  # of a wait until the page explains it, s
TAB_NOTICE = "Each tab edits a design of its own, and only Save writes to the disk."
NO_NATIVE_UNDO = """({event}) => {
  const undoes = (event.ctrlKey || event.metaKey) && ['z', 'y'].includes(event.key.toLowerCase());
  if (undoes && !document.querySelector('.q-dialog')) event.preventDefault();
}"""
"""Handler that keeps a browser from undoing typed text on Ctrl-Z, in whatever field."""


class TabSessions:
    """Studio sessions by browser tab."""

    def __init__(self) -> None:
        self._sessions: OrderedDict[str, tuple[StudioSession, Client]] = OrderedDict()

    async def session(self, client: Client, begin: Callable[[], StudioSession]) -> StudioSession:
        """Return the session of a client's tab; a new one if the tab has none, or another page shows it.

        The previous page of a reloaded tab has `RELOAD_TIMEOUT` to disconnect; a duplicated tab has the id of the
        first, whose page stays connected. Listeners of the session are removed, and sessions beyond `MAX_SESSIONS`
        forgotten, the least recent first.

        Args:
            client: client of the page.
            begin: creates a session.

        Raises:
            LayflatError: `begin` raised it.
        """
        tab = client.tab_id or client.id
        session, before = self._sessions.get(tab, (None, None))
        for _ in range(RELOAD_POLLS):
            if before is None or not before.has_socket_connection:
                break
            await asyncio.sleep(RELOAD_TIMEOUT / RELOAD_POLLS)
        if session is None or before is None or before.has_socket_connection:
            session = begin()
        session.leave()
        self._sessions[tab] = (session, client)
        self._sessions.move_to_end(tab)
        while len(self._sessions) > MAX_SESSIONS:
            self._sessions.popitem(last=False)
        return session


@lru_cache(maxsize=1)
def shared_worker() -> StudioProcesses:
    """Return the processes that work for all tabs, made by the first call."""
    return StudioProcesses()


@lru_cache(maxsize=1)
def _tabs() -> TabSessions:
    return TabSessions()


async def studio_page(machine: str, folder: Path | None = None) -> None:
    """Build the page of a tab, with a session of its own, within the present client; an error is shown as the page.

    Args:
        machine: built-in name or file.
        folder: folder in which results are saved; None is the current one.
    """
    client = ui.context.client
    if not await wait_for_browser():
        return
    worker = shared_worker()
    try:
        design = await worker.perform(open_design, machine, what="the reading of the file")
        session = await _tabs().session(client, lambda: StudioSession(design, worker))
    except LayflatError as error:
        with theme.frame(STUDIO_TITLE, machine):
            theme.note(str(error), "danger")
        return
    await StudioPage(session, folder or Path.cwd()).build()


class StudioPage:
    """Studio page in one browser tab."""

    def __init__(self, session: StudioSession, folder: Path) -> None:
        """Store the session and the folder of results; `build` makes the elements."""
        self.session, self._folder = session, folder

    async def build(self) -> None:
        """Build it within the present client, piece by piece."""
        session, pieces = self.session, Pieces()
        with theme.frame(STUDIO_TITLE, session.design.machine.name) as frame:
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
                    ui.label(TAB_NOTICE).classes("st-own")
                with ui.element("section").classes("st-right").props('aria-label="Results" tabindex=0'):
                    DiskView(session, self._reread)
                    self.kept = KeptView(session, self._edited)
                    self.results = ResultsView(session, self._show_joint)
                    await self.results.build(pieces)
        self.subtitle = frame.subtitle
        await pieces.pause()
        self.editor.show_joint(session.step.joint)
        ui.keyboard(self._handle_key, ignore=[]).on("key", js_handler=NO_NATIVE_UNDO)
        ui.timer(0.5, self._show_wait)
        session.listen(self._refresh_views)
        for what in KINDS:
            await pieces.pause()
            self._refresh_views(what)
        self._start_results()

    def _start_results(self) -> None:
        """Compute the results of the session in the background until the page is deleted."""
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

    def _show_joint(self, joint: str) -> None:
        self.editor.show_joint(joint)
        self.session.show_joint(joint)

    async def _reread(self) -> None:
        await self.editor.rebuild()
        self.editor.show_joint(self.session.step.joint)
        self.session.renew()

    def _refresh_views(self, what: ChangedPart) -> None:
        """Refresh the views that depend on the changed part of the session."""
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

    def _show_wait(self) -> None:
        """Show how long the simulation has been running, once it is longer than `WAIT_NOTICE_DELAY`."""
        since = self.session.waiting_since
        if since is not None and time.monotonic() - since > WAIT_NOTICE_DELAY:
            seconds = f"{time.monotonic() - since:.0f} s"
            self.results.step.wait(f"Simulating for {seconds}: compiling, the first time only for such a machine.")

    def _handle_key(self, event: events.KeyEventArguments) -> None:
        """Undo on Ctrl-Z, redo on Ctrl-Y or Ctrl-Shift-Z, outside dialogs; reset text being typed instead."""
        if (
            not event.action.keydown
            or not (event.modifiers.ctrl or event.modifiers.meta)
            or self.commands.has_open_dialog
        ):
            return
        key = str(event.key).lower()
        act: Callable[[], None] | None = None
        if key == "z":
            act = self.commands.redo if event.modifiers.shift else self.commands.undo
        elif key == "y":
            act = self.commands.redo
        if act is not None and not self.editor.reset_typed():
            act()
