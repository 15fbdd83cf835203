"""View of a sequence: steps in a table, performed once or repeatedly, saved by name and loaded again."""

import asyncio
from collections.abc import Sequence
from functools import partial
from math import degrees
from typing import Any

from nicegui import background_tasks, ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.look.theme import clamp_number, confirm, finite_number
from layflat.pages.panel.desk import Controls, Desk
from layflat.pages.panel.moves import (
    MAX_STEPS,
    SequenceStep,
    active_outputs,
    check_pause,
    is_saved,
    load_sequence,
    newest_names,
    save_sequence,
)
from layflat.pages.panel.pilot import DEFAULT_SPEED_FRACTION
from layflat.rig.session import RigSnapshot

SPEED_PERCENTAGES = (10, 100, round(100 * DEFAULT_SPEED_FRACTION))  # min, max and initial value, % of the arm's limits
REDRAW_DELAY = 0.05  # from a change of the steps to their drawing, s
FILE_TIMEOUT = 10.0  # for reading or writing files of sequences, s


class SequenceView:
    """View of one page's sequence."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it; `list_saved` lists the saved sequences."""
        self._desk, self._controls, self._outputs = desk, controls, desk.first.interface.outputs
        self.steps: list[SequenceStep] = []
        ui.context.client.on_delete(lambda: desk.worker.forget(self))
        self._draws = self._stale = False  # whether the table is being drawn, and whether it has to be redrawn
        lower, upper, usual = SPEED_PERCENTAGES
        with ui.row().classes("lf-line"):
            ui.label("Speed of moves:").props('id="move-share"')
            self.share = ui.slider(min=lower, max=upper, step=5, value=usual, on_change=self._set_share)
            self.share.classes("lf-slider").props('aria-labelledby="move-share"')
            ui.label().bind_text_from(
                self.share, "value", lambda x: f"{clamp_number(x, *SPEED_PERCENTAGES):.0f} % of what the arm can do"
            )
        with ui.row().classes("lf-line"):
            self.pause = ui.number("pause after it (s)", value=0.5, min=0.0, step=0.5).props("dense outlined")
            self.add = theme.button("Add present angles", self._add_step, icon="add_location_alt")
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
        self.status = ui.label("").classes("lf-told").props("role=alert")
        self._draw()

    def refresh(self, shot: RigSnapshot | None, can_move: bool) -> None:
        """Enable the buttons that may be used now, and show the progress of a sequence."""
        self.add.set_enabled(shot is not None)
        for button in (self.run, self.loop):
            button.set_enabled(can_move and bool(self.steps))
        course = self._desk.pilot.sequence
        text = f"at step {course.step + 1}, {course.rounds} rounds done" if course is not None else ""
        self.progress.set_text(text)

    async def list_saved(self, chosen: str | None = None) -> None:
        """List the names of the newest saved sequences, and select `chosen` if it is among them, else none."""
        with theme.show_errors_on(self.status):
            names, older = await self._files(newest_names, by=self)
            if older:
                text = f"The newest {len(names)} sequences are offered; {older} older ones are in the folder."
                self.status.set_text(text)
            self.saved.set_options(names, value=chosen if chosen in names else None)

    async def _files(self, work: Any, *arguments: Any, by: object = None) -> Any:
        """Call a function that reads or writes sequences of the desk's folder, in the worker process."""
        what = "work on the sequences' files"
        return await self._desk.worker.call(work, self._desk.folder, *arguments, limit=FILE_TIMEOUT, what=what, by=by)

    def _set_share(self) -> None:
        self._controls.share = clamp_number(self.share.value, *SPEED_PERCENTAGES) / 100.0

    def _add_step(self) -> None:
        """Append a step with the present demand, the entered pause (s) and the present outputs; at most `MAX_STEPS`."""
        shot = self._desk.snapshot()
        with theme.show_errors_on(self.status):
            if len(self.steps) >= MAX_STEPS:
                right = "take one away, or save it and begin another"
                raise LayflatError(f"A sequence has at most {MAX_STEPS} steps: {right}.")
            pause = check_pause(finite_number(self.pause.value), "pause")
            if shot is not None:
                outputs = active_outputs(self._desk.first, shot) if self._outputs else None
                self.steps.append(SequenceStep(tuple(map(float, shot["demand"])), pause, outputs))
                self.status.set_text("")
                self._draw()

    def _clear(self) -> None:
        self.steps = []
        self._draw()

    def _drop(self, step: SequenceStep) -> None:
        """Take the step away whose button was pressed: rows on the page may be older than the steps."""
        self.steps = [one for one in self.steps if one is not step]
        self._draw()

    def _run(self, *, repeats: bool) -> None:
        """Start the sequence of the present steps, or show why it is refused."""
        with theme.show_errors_on(self.status):
            self._controls.start_sequence(self.steps, repeats=repeats)
            self.status.set_text("")

    async def _save(self) -> None:
        """Save the steps by the entered name, after a question if it replaces a sequence."""
        name, desk, steps = str(self.name.value or ""), self._desk, tuple(self.steps)
        if not steps:
            self.status.set_text("There are no steps to save: add some.")
            return
        with theme.show_errors_on(self.status):
            exists = await self._files(is_saved, name)
            if exists and not await confirm(f"Replace the sequence {name!r}?", "Replace"):
                return
            path = await self._files(save_sequence, name, desk.first, steps)
            await self.list_saved(name)
            self.status.set_text(f"saved {path}")

    async def _load(self) -> None:
        """Replace the steps by those of the chosen saved sequence."""
        if not self.saved.value:
            self.status.set_text("Choose a saved sequence first.")
            return
        name = str(self.saved.value)
        with theme.show_errors_on(self.status):
            self.steps = await self._files(load_sequence, name, self._desk.first)
            self.name.value = name
            self.status.set_text("")
            self._draw()

    def _draw(self) -> None:
        """Redraw the table soon; requests until then share one redraw."""
        self._stale = True
        if not self._draws:
            self._draws = True
            background_tasks.create(self._redraw_until_newest(), context=self.table)

    async def _redraw_until_newest(self) -> None:
        """Redraw the table of steps, at most once every `REDRAW_DELAY`, until it shows the newest steps."""
        try:
            while self._stale:
                await asyncio.sleep(REDRAW_DELAY)
                self._stale = False
                await self._draw_rows(tuple(self.steps))
        finally:
            self._draws = False

    async def _draw_rows(self, steps: Sequence[SequenceStep]) -> None:
        """Replace the table by the given steps in short pieces; return early once they are outdated."""
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
        """Add the head of the table: step, joints, outputs if the machine has some, and pause."""
        switched = ("then on",) if self._outputs else ()
        joints = (f"{name} (deg)" for name in self._desk.first.joints)
        with ui.element("tr"):
            for head in ("step", *joints, *switched, "pause (s)", ""):
                theme.text_element("th", head)

    def _draw_row(self, at: int, step: SequenceStep) -> None:
        """Add the row of the step with index `at`: angles (deg), outputs, pause (s), and a button that deletes it."""
        angles = (f"{degrees(x):.1f}" for x in step.angles)
        on = (_output_names(step.outputs),) if self._outputs else ()
        with ui.element("tr"):
            for text in (str(at + 1), *angles, *on, f"{step.pause:g}"):
                theme.text_element("td", text)
            with ui.element("td"):
                theme.button("", partial(self._drop, step), icon="delete", kind="flat", hint=f"Take step {at + 1} away")


def _output_names(outputs: frozenset[str] | None) -> str:
    return "as before" if outputs is None else ", ".join(sorted(outputs)) or "nothing"
