"""The check before first air, step by step."""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.rig.check.open_loop import CheckResult

BY_HAND = (
    "The relief valve is set and the emergency stop is within reach.",
    "Nobody is within reach of the arm, and nothing is in its way.",
    "Hoses and straps are in place, and no hose is kinked.",
)
"""What only a person can see."""


class CheckView:
    """View of a commissioning check: points for a person to look at, a check without air, then small moves."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it for the page of some controls."""
        self._desk, self._controls = desk, controls
        self._busy, self._sound = False, False
        theme.text_element("h3", "1. Look yourself")
        self._seen = [ui.checkbox(text) for text in BY_HAND]
        theme.text_element("h3", "2. Link, timing and sensors, without air")
        self.without = theme.button("Check without air", lambda: self._run(air=False), icon="fact_check")
        theme.text_element("h3", "3. Valves and signs: each joint moves by some degrees")
        self.with_air = theme.button("Check with air", lambda: self._run(air=True), icon="air")
        self.told = ui.label("").props("role=status")
        self.found = ui.element("div")

    def refresh(self) -> None:
        """Enable what may be used."""
        free = not self._busy and self._controls.drives and self._desk.link.at_rest
        self.without.set_enabled(free)
        self.with_air.set_enabled(free and self._sound and all(one.value for one in self._seen))

    async def _run(self, *, air: bool) -> None:
        self._busy = True
        self.refresh()
        self.found.clear()
        try:
            found = await asyncio.to_thread(self._controls.check, air=air, tell=self._tell_from_there())
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        finally:
            self._busy = False
        wrong = sum(not one.passed for one in found)
        self._sound = not wrong
        self.told.set_text(f"{wrong} of {len(found)} checks failed" if wrong else f"all {len(found)} checks passed")
        self._draw(found)

    def _tell_from_there(self) -> Callable[[str], object]:
        """Return what shows a text, called from another thread."""
        loop = asyncio.get_running_loop()

        def tell(text: str) -> None:
            with suppress(RuntimeError):  # the pages are being closed
                loop.call_soon_threadsafe(self.told.set_text, text)

        return tell

    def _draw(self, found: list[CheckResult]) -> None:
        with self.found, ui.element("table").classes("lf-table"):
            with ui.element("tr"):
                for head in ("check", "found", "what to do"):
                    theme.text_element("th", head)
            for one in found:
                with ui.element("tr"):
                    for text in (one.what, one.found, one.action or "passed"):
                        theme.text_element("td", text)
