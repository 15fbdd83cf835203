"""Sequences: places in a table, performed once or again and again, saved by name and loaded again."""

import asyncio
from collections.abc import Sequence
from functools import partial
from math import degrees
from typing import Any

from nicegui import background_tasks, ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed, number, within
from layflat.pages.look.pieces import Pieces
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.moves import Step, outputs_on
from layflat.pages.panel.pilot import USUAL_SHARE
from layflat.pages.panel.sequences import MAX_STEPS, check_pause, is_saved, load_sequence, newest_names, save_sequence
from layflat.rig.session import Snapshot

SHARES = (10, 100, round(100 * USUAL_SHARE))  # least, most, and at first, % of what the arm can do
SOON = 0.05  # from a change of the steps to their drawing, s
FILES_WITHIN = 10.0  # in which files of sequences have to be read or written, s


class SequenceView:
    """The places of one page's sequence."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it; `list_saved` shows what was saved."""
        self._desk, self._controls, self._outputs = desk, controls, desk.first.interface.outputs
        self.steps: list[Step] = []
        ui.context.client.on_delete(lambda: desk.worker.forget(self))
        self._draws = self._stale = False  # whether the table is being drawn, and whether it has to be drawn anew
        least, most, usual = SHARES
        with ui.row().classes("lf-line"):
            ui.label("Speed of moves:").props('id="move-share"')
            self.share = ui.slider(min=least, max=most, step=5, value=usual, on_change=self._set_share)
            self.share.classes("lf-slider").props('aria-labelledby="move-share"')
            ui.label().bind_text_from(
                self.share, "value", lambda x: f"{within(x, *SHARES):.0f} % of what the arm can do"
            )
        with ui.row().classes("lf-line"):
            self.pause = ui.number("pause after it (s)", value=0.5, min=0.0, step=0.5).props("dense outlined")
            self.add = theme.button("Add present angles", self._add, icon="add_location_alt")
            theme.button("Clear", self._clear, icon="clear_all")
        self.table = ui.element("div")
        with ui.row().classes("lf-line"):
            self.run = theme.button("Run", lambda: self._run(repeats=False), icon="play_arrow", kind="primary")
            self.loop = theme.button("Run again and again", lambda: self._run(repeats=True), icon="repeat")
            self.progress = ui.label("").props("role=status").classes("lf-quiet")
        with ui.row().classes("lf-line"):
            self.name = ui.input("name").props("dense outlined maxlength=200")
            theme.button("Save", self._save, icon="save")
            self.saved = ui.select([], label="saved").props("dense outlined").classes("lf-select")
            theme.button("Load", self._load, icon="folder_open")
        self.told = ui.label("").classes("lf-told").props("role=alert")
        self._draw()

    def refresh(self, shot: Snapshot | None, fits: bool) -> None:
        """Enable what may be used, and show how far a run has come."""
        self.add.set_enabled(shot is not None)
        for button in (self.run, self.loop):
            button.set_enabled(fits and bool(self.steps))
        course = self._desk.pilot.course
        text = f"at step {course.step + 1}, {course.rounds} rounds done" if course is not None else ""
        self.progress.set_text(text)

    async def list_saved(self, chosen: str | None = None) -> None:
        """Show the names of what was saved, and choose one."""
        try:
            found, older = await self._files(newest_names, by=self)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        if older:
            self.told.set_text(f"The newest {len(found)} sequences are offered; {older} older ones are in the folder.")
        self.saved.set_options(found, value=chosen if chosen in found else None)

    async def _files(self, work: Any, *more: Any, by: object = None) -> Any:
        """Call what reads or writes files of the desk's folder, beside the event loop."""
        what = "work on the sequences' files"
        return await self._desk.worker.call(work, self._desk.folder, *more, limit=FILES_WITHIN, what=what, by=by)

    def _set_share(self) -> None:
        self._controls.share = within(self.share.value, *SHARES) / 100.0

    def _add(self) -> None:
        shot = self._desk.snapshot()
        pause = number(self.pause.value)
        try:
            if len(self.steps) >= MAX_STEPS:
                raise LayflatError(
                    f"A sequence has at most {MAX_STEPS} steps: take one away, or save it and begin another."
                )
            pause = check_pause(-1.0 if pause is None else pause, "pause")
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        if shot is not None:
            outputs = outputs_on(self._desk.first, shot) if self._outputs else None
            self.steps.append(Step(tuple(map(float, shot["demand"])), pause, outputs))
            self.told.set_text("")
            self._draw()

    def _clear(self) -> None:
        self.steps = []
        self._draw()

    def _drop(self, step: Step) -> None:
        """Take the step away whose button was pressed: rows on the page may be older than the steps."""
        self.steps = [one for one in self.steps if one is not step]
        self._draw()

    def _run(self, *, repeats: bool) -> None:
        try:
            self._controls.go(self.steps, repeats=repeats)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text("")

    async def _save(self) -> None:
        name, desk, steps = str(self.name.value or ""), self._desk, tuple(self.steps)
        if not steps:
            self.told.set_text("There are no steps to save: add some.")
            return
        try:
            there = await self._files(is_saved, name)
            if there and not await confirmed(f"Replace the sequence {name!r}?", "Replace"):
                return
            path = await self._files(save_sequence, name, desk.first, steps)
            await self.list_saved(name)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text(f"saved {path}")

    async def _load(self) -> None:
        if not self.saved.value:
            self.told.set_text("Choose a saved sequence first.")
            return
        name = str(self.saved.value)
        try:
            self.steps = await self._files(load_sequence, name, self._desk.first)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.name.value, _ = name, self.told.set_text("")
        self._draw()

    def _draw(self) -> None:
        """Draw the table anew, soon: what is pressed again and again meanwhile is drawn once."""
        self._stale = True
        if not self._draws:
            self._draws = True
            background_tasks.create(self._keep_drawn(), context=self.table)

    async def _keep_drawn(self) -> None:
        try:
            while self._stale:
                await asyncio.sleep(SOON)
                self._stale = False
                await self._draw_rows(tuple(self.steps))
        finally:
            self._draws = False

    async def _draw_rows(self, steps: Sequence[Step]) -> None:
        pieces = Pieces()
        for before in list(self.table):
            for row in reversed(list(before)):
                row.delete()
                await pieces.pause()
                if self._stale:
                    return
            before.delete()
        if not steps:
            ui.label("No steps yet: move the arm, then add its present angles.").classes("lf-quiet")
            return
        with ui.element("table").classes("lf-table"):
            self._draw_head()
            for at, step in enumerate(steps):
                self._draw_row(at, step)
                await pieces.pause()
                if self._stale:
                    return

    def _draw_head(self) -> None:
        switched = ("then on",) if self._outputs else ()
        joints = (f"{name} (deg)" for name in self._desk.first.joints)
        with ui.element("tr"):
            for head in ("step", *joints, *switched, "pause (s)", ""):
                theme.text_element("th", head)

    def _draw_row(self, at: int, step: Step) -> None:
        angles = (f"{degrees(x):.1f}" for x in step.angles)
        on = (_named(step.outputs),) if self._outputs else ()
        with ui.element("tr"):
            for text in (str(at + 1), *angles, *on, f"{step.pause:g}"):
                theme.text_element("td", text)
            with ui.element("td"):
                theme.button("", partial(self._drop, step), icon="delete", kind="flat", hint=f"Take step {at + 1} away")


def _named(outputs: frozenset[str] | None) -> str:
    return "as before" if outputs is None else ", ".join(sorted(outputs)) or "nothing"
