"""Tune the gains from the page: begin, see how far it is, cancel, take what was found."""

import asyncio

from nicegui import ui

from layflat.errors import InputError, LayflatError
from layflat.pages.look import theme
from layflat.pages.look.dialogs import within
from layflat.pages.studio.session import Session
from layflat.pages.studio.tuning import GENERATIONS, TuningRun

LIMITS = 1, 1000  # of generations
LOOK = 0.25  # between two looks at how far it is, s


class TuneView:
    """A dialog about one tuning at a time."""

    def __init__(self, session: Session) -> None:
        """Make it, closed."""
        self._session = session
        self._run: TuningRun | None = None
        self._begun = 0  # which tuning is the newest
        with ui.dialog().props("persistent") as self.dialog, ui.card().classes("lf-dialog") as card:
            card.props('role=dialog aria-modal=true aria-label="Tune the gains"')
            theme.text_element("h2", "Tune the gains")
            ui.label(
                "Searches for gains with which moves settle soon, over payloads, supplies, losses and drifts, as "
                "layflat tune does; it begins with the gains of this design."
            )
            self._generations = ui.number("Generations", value=GENERATIONS, min=LIMITS[0], max=LIMITS[1], format="%d")
            self._generations.props("outlined dense").classes("st-setting")
            self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Generations done"')
            self._said = ui.label().props("role=status")
            with ui.row().classes("lf-line"):
                self._begin = theme.button("Begin", self._start, icon="play_arrow", kind="primary")
                self._cancel = theme.button("Cancel", self._stop, icon="stop")
                self._take = theme.button("Take these gains", self._apply, icon="check", kind="primary")
                theme.button("Close", self._close)
        self._timer = ui.timer(LOOK, self._look, active=False)
        self._show("")

    def open(self) -> None:
        """Open the dialog."""
        self.dialog.open()

    def _wanted(self) -> int:
        """Return how many generations are wanted."""
        return round(within(self._generations.value, *LIMITS, GENERATIONS))

    def end(self) -> None:
        """End a tuning that goes on, or is about to: the tab was closed."""
        self._begun += 1
        if self._run is not None:
            self._run.close()
            self._run = None

    def _show(self, text: str) -> None:
        run = self._run
        going = run is not None and not run.progress.ended
        found = run is not None and bool(run.progress.found)
        self._said.set_text(text)
        self._begin.set_visibility(not going and not found)
        self._cancel.set_visibility(going)
        self._take.set_visibility(found)
        self._bar.set_visibility(run is not None)
        self._generations.set_enabled(not going)

    async def _start(self) -> None:
        self.end()
        self._begun += 1
        begun = self._begun
        self._show("Begins; compiles the first time.")
        try:
            run = await asyncio.to_thread(TuningRun, self._session.design, self._wanted())
        except LayflatError as error:
            self._show(str(error))
            return
        if begun != self._begun:  # another one was begun meanwhile, or the dialog was closed
            run.close()
            return
        self._run = run
        self._bar.set_value(0.0)
        self._show("Begins; compiles the first time.")
        self._timer.activate()

    def _look(self) -> None:
        if self._run is None:
            return
        now = self._run.progress
        self._bar.set_value(now.done / max(1, now.wanted))
        if now.error:
            text = now.error
        elif now.ended and not now.found:
            text = f"No better gains were found in {now.done} generations: those that are there stay."
        elif now.best is None:
            text = "Begins; compiles the first time."
        else:
            text = f"{now.done} of {now.wanted} generations; cost {now.first:.3g} s at first, now {now.best:.3g} s."
        if now.ended:
            self._timer.deactivate()
        self._show(text)

    def _stop(self) -> None:
        if self._run is not None:
            self._run.cancel()
            self._cancel.set_visibility(False)

    def _apply(self) -> None:
        if self._run is None:
            return
        try:
            self._session.design.edit_all(self._run.progress.found)
        except InputError as error:
            self._show(str(error))
            return
        self._run = None
        self._session.renew()
        self.dialog.close()
        self._show("")

    def _close(self) -> None:
        self.end()
        self._timer.deactivate()
        self._show("")
        self.dialog.close()
