"""Commissioning check before first air, step by step; and failures that a virtual rig can simulate."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.panel.desk import Controls, Desk
from layflat.rig.device.failures import ALL_FAILURES, FAILURES_BY_NAME
from layflat.rig.open_loop import CheckResult

MANUAL_CHECKS = (
    "The relief valve is set and the emergency stop is within reach.",
    "Nobody is within reach of the arm, and nothing is in its way.",
    "Hoses and straps are in place, and no hose is kinked.",
)
"""Points that only a person can check."""
WHOLE_RIG = "the rig"  # where a failure is not a joint's


class CheckView:
    """View of a commissioning check: points for a person, a check without air, then small moves."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build the view for the page that has these controls."""
        self._desk, self._controls = desk, controls
        self._busy, self._sound = False, False
        theme.text_element("h3", "1. Look yourself")
        self._points = [ui.checkbox(text) for text in MANUAL_CHECKS]
        theme.text_element("h3", "2. Link, timing and sensors, without air")
        self.without = theme.button("Check without air", lambda: self._run_check(air=False), icon="fact_check")
        theme.text_element("h3", "3. Valves and signs: each joint moves by some degrees")
        self.with_air = theme.button("Check with air", lambda: self._run_check(air=True), icon="air")
        self.status = ui.label("").props("role=status")
        self.results = ui.element("div")

    def refresh(self) -> None:
        """Enable the buttons that may be used now: with air only after a passed check, and with all points ticked."""
        free = not self._busy and self._controls.drives and self._desk.link.is_at_rest
        self.without.set_enabled(free)
        self.with_air.set_enabled(free and self._sound and all(one.value for one in self._points))

    async def _run_check(self, *, air: bool) -> None:
        """Perform the check in a thread and show its results, with air or without; an error appears as the status."""
        self._busy, self._sound = True, False
        self.refresh()
        self.results.clear()
        with theme.show_errors_on(self.status):
            try:
                results = await asyncio.to_thread(self._controls.check, air=air, tell=self._status_setter())
            finally:
                self._busy = False
            wrong = sum(not one.has_passed for one in results)
            self._sound = not wrong
            self.status.set_text(
                f"{wrong} of {len(results)} checks failed" if wrong else f"all {len(results)} checks passed"
            )
            self._show_results(results)

    def _status_setter(self) -> Callable[[str], object]:
        """Return a function that shows a status text and may be called from another thread."""
        loop = asyncio.get_running_loop()

        def tell(text: str) -> None:
            with suppress(RuntimeError):  # the pages are being closed
                loop.call_soon_threadsafe(self.status.set_text, text)

        return tell

    def _show_results(self, results: list[CheckResult]) -> None:
        """Show a row for each result: check, finding, and the action that it needs or "passed"."""
        with self.results, ui.element("table").classes("lf-table"):
            with ui.element("tr"):
                for head in ("check", "found", "what to do"):
                    theme.text_element("th", head)
            for result in results:
                with ui.element("tr"):
                    for text in (result.what, result.finding, result.action or "passed"):
                        theme.text_element("td", text)


class FailuresView:
    """View of the failures of a virtual rig: a choice of failure and joint, and buttons to fail and heal."""

    def __init__(self, tell: Callable[[str], str], joints: list[str]) -> None:
        """Build it; `tell` sends a command line to the virtual rig and returns its answer."""
        self._command = tell
        ui.label("This rig is simulated: try what happens when something fails.").classes("lf-quiet")
        names = [failure.name for failure in ALL_FAILURES]
        with ui.row().classes("lf-line"):
            self.failure = (
                ui.select(names, value=names[0], label="failure").props("dense outlined").classes("lf-select")
            )
            self.joint = ui.select(joints, value=joints[0], label="joint").props("dense outlined").classes("lf-select")
            theme.button("Fail", partial(self._do, "fail"), icon="bolt", kind="danger")
            theme.button("Heal", partial(self._do, "heal"), icon="healing")
        self.means = ui.label("").classes("lf-quiet")
        self.means.bind_text_from(
            self.failure, "value", lambda name: FAILURES_BY_NAME[name].what if name in FAILURES_BY_NAME else ""
        )
        self.status = ui.label("").props("role=status")

    async def _do(self, word: str) -> None:
        """Send "fail" or "heal" with the chosen failure and joint to the virtual rig, and show its answer."""
        with theme.show_errors_on(self.status):
            line = f"{word} {self.failure.value} {self.joint.value}"
            self.status.set_text(await asyncio.to_thread(self._command, line))
