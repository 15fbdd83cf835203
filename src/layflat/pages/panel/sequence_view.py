"""Sequences: places in a table, performed once or again and again, saved by name and loaded again."""

from math import degrees

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.moves import Step, outputs_on
from layflat.pages.panel.sequences import check_pause, load_sequence, place_of, save_sequence, sequence_names
from layflat.rig.session import Snapshot

SHARES = (10, 100, 30)  # least, most, and at first, % of what the arm can do


class SequenceView:
    """The places of one page's sequence."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        self._desk, self._outputs = desk, desk.first.interface.outputs
        self.steps: list[Step] = []
        least, most, usual = SHARES
        with ui.row().classes("lf-line"):
            ui.label("Speed of moves:").props('id="move-share"')
            self.share = ui.slider(min=least, max=most, step=5, value=usual, on_change=self._set_share)
            self.share.classes("lf-slider").props('aria-labelledby="move-share"')
            ui.label().bind_text_from(self.share, "value", lambda x: f"{x:.0f} % of what the arm can do")
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
            self.name = ui.input("name").props("dense outlined")
            theme.button("Save", self._save, icon="save")
            self.saved = (
                ui.select(sequence_names(desk.folder), label="saved").props("dense outlined").classes("lf-select")
            )
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

    def _set_share(self) -> None:
        self._desk.pilot.share = float(self.share.value) / 100.0

    def _add(self) -> None:
        shot = self._desk.snapshot()
        try:
            pause = check_pause(float(self.pause.value if self.pause.value is not None else -1.0), "pause")
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        if shot is not None:
            outputs = outputs_on(self._desk.first, shot) if self._outputs else None
            self.steps.append(Step(tuple(map(float, shot["demand"])), pause, outputs))
            self.told.set_text("")
            self._draw()

    def _clear(self) -> None:
        self.steps.clear()
        self._draw()

    def _drop(self, at: int) -> None:
        del self.steps[at]
        self._draw()

    def _run(self, *, repeats: bool) -> None:
        self._desk.pilot.go(self.steps, repeats=repeats)

    async def _save(self) -> None:
        name, folder = str(self.name.value or ""), self._desk.folder
        if not self.steps:
            self.told.set_text("There are no steps to save: add some.")
            return
        try:
            if place_of(folder, name).exists() and not await confirmed(f"Replace the sequence {name!r}?", "Replace"):
                return
            path = save_sequence(folder, name, self._desk.first, self.steps)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.saved.set_options(sequence_names(folder), value=name)
        self.told.set_text(f"saved {path}")

    def _load(self) -> None:
        if not self.saved.value:
            self.told.set_text("Choose a saved sequence first.")
            return
        try:
            self.steps = load_sequence(self._desk.folder, self.saved.value, self._desk.first)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.name.value, _ = self.saved.value, self.told.set_text("")
        self._draw()

    def _draw(self) -> None:
        self.table.clear()
        with self.table:
            if not self.steps:
                ui.label("No steps yet: move the arm, then add its present angles.").classes("lf-quiet")
                return
            with ui.element("table").classes("lf-table"):
                with ui.element("tr"):
                    switched = ("then on",) if self._outputs else ()
                    joints = (f"{name} (deg)" for name in self._desk.first.joints)
                    for head in ("step", *joints, *switched, "pause (s)", ""):
                        theme.text_element("th", head)
                for at, step in enumerate(self.steps):
                    with ui.element("tr"):
                        angles = (f"{degrees(x):.1f}" for x in step.angles)
                        on = (_named(step.outputs),) if self._outputs else ()
                        for text in (str(at + 1), *angles, *on, f"{step.pause:g}"):
                            theme.text_element("td", text)
                        with ui.element("td"):
                            hint = f"Take step {at + 1} away"
                            theme.button("", lambda at=at: self._drop(at), icon="delete", kind="flat", hint=hint)


def _named(outputs: frozenset[str] | None) -> str:
    return "as before" if outputs is None else ", ".join(sorted(outputs)) or "nothing"
