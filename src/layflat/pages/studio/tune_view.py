"""Dialog that tunes the gains: start, progress, cancel, use the result."""

import asyncio

from nicegui import ui

from layflat.errors import InputError, LayflatError
from layflat.pages.look import theme
from layflat.pages.look.theme import clamp_number
from layflat.pages.studio.session import StudioSession
from layflat.pages.studio.tuning import DEFAULT_GENERATIONS, TuningRun

GENERATION_LIMITS = 1, 1000  # of generations, min and max
PROGRESS_PERIOD = 0.25  # of updates of the progress, s


class TuneView:
    """Dialog of the tuning, one at a time."""

    def __init__(self, session: StudioSession) -> None:
        """Make it, closed."""
        self._session = session
        self._run: TuningRun | None = None
        self._number = 0  # number of the newest tuning
        with ui.dialog().props("persistent") as self.dialog, ui.card().classes("lf-dialog") as card:
            card.props('role=dialog aria-modal=true aria-label="Tune the gains"')
            theme.text_element("h2", "Tune the gains")
            ui.label(
                "Searches for gains with which moves settle soon, over payloads, supplies, losses and drifts, as "
                "layflat tune does; it begins with the gains of this design."
            )
            self._generations = ui.number(
                "Generations",
                value=DEFAULT_GENERATIONS,
                min=GENERATION_LIMITS[0],
                max=GENERATION_LIMITS[1],
                format="%d",
            )
            self._generations.props("outlined dense").classes("st-setting")
            self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Generations done"')
            self._status = ui.label().props("role=status")
            with ui.row().classes("lf-line"):
                self._begin = theme.button("Begin", self._start, icon="play_arrow", kind="primary")
                self._cancel = theme.button("Cancel", self._stop, icon="stop")
                self._take = theme.button("Take these gains", self._apply, icon="check", kind="primary")
                theme.button("Close", self._close)
        self._timer = ui.timer(PROGRESS_PERIOD, self._show_progress, active=False)
        self._refresh("")

    def open(self) -> None:
        """Open the dialog."""
        self.dialog.open()

    def _generation_count(self) -> int:
        """Return the number of generations in the field."""
        return round(clamp_number(self._generations.value, *GENERATION_LIMITS, DEFAULT_GENERATIONS))

    def end(self) -> None:
        """End a tuning that runs or starts: the tab was closed."""
        self._number += 1
        if self._run is not None:
            self._run.close()
            self._run = None

    def _refresh(self, status: str) -> None:
        """Set the status text, and show buttons and bar for the state: not begun, running, ended with a result."""
        run = self._run
        is_running = run is not None and not run.progress.has_ended
        has_result = run is not None and bool(run.progress.changes)
        self._status.set_text(status)
        self._begin.set_visibility(not is_running and not has_result)
        self._cancel.set_visibility(is_running)
        self._take.set_visibility(has_result)
        self._bar.set_visibility(run is not None)
        self._generations.set_enabled(not is_running)

    async def _start(self) -> None:
        """Start a tuning run with the entered number of generations; close it if another has replaced it meanwhile."""
        self.end()
        self._number += 1
        number = self._number
        self._refresh("Begins; compiles the first time.")
        try:
            run = await asyncio.to_thread(TuningRun, self._session.design, self._generation_count())
        except LayflatError as error:
            self._refresh(str(error))
            return
        if number != self._number:  # another run was begun meanwhile, or the dialog was closed
            run.close()
            return
        self._run = run
        self._bar.set_value(0.0)
        self._refresh("Begins; compiles the first time.")
        self._timer.activate()

    def _show_progress(self) -> None:
        """Show the progress of the run: generations, first and best cost (s), error or end."""
        if self._run is None:
            return
        now = self._run.progress
        self._bar.set_value(now.done / max(1, now.total))
        if now.error:
            text = now.error
        elif now.has_ended and not now.changes:
            text = f"No better gains were found in {now.done} generations: those that are there stay."
        elif now.best is None:
            text = "Begins; compiles the first time."
        else:
            text = f"{now.done} of {now.total} generations; cost {now.first:.3g} s at first, now {now.best:.3g} s."
        if now.has_ended:
            self._timer.deactivate()
        self._refresh(text)

    def _stop(self) -> None:
        """Request that the run ends after the present generation, and hide the button."""
        if self._run is not None:
            self._run.cancel()
            self._cancel.set_visibility(False)

    def _apply(self) -> None:
        """Apply the tuned gains to the design as one edit and close the dialog; if refused, show the error instead."""
        if self._run is None:
            return
        try:
            self._session.design.edit_all(self._run.progress.changes)
        except InputError as error:
            self._refresh(str(error))
            return
        self._run = None
        self._session.renew()
        self.dialog.close()
        self._refresh("")

    def _close(self) -> None:
        """End the run without a result and close the dialog."""
        self.end()
        self._timer.deactivate()
        self._refresh("")
        self.dialog.close()
