"""Of a virtual rig: what it can be told to fail, to see what the panel says then."""

import asyncio
from collections.abc import Callable
from functools import partial

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.rig.device.failures import ALL, FAILURES

GENERAL = "the rig"  # where a failure is not a joint's


class FailuresView:
    """A failure to choose, a joint, and two buttons."""

    def __init__(self, tell: Callable[[str], str], joints: list[str]) -> None:
        """Build it; `tell` gives a line to the virtual rig and returns its answer."""
        self._tell = tell
        ui.label("This rig is simulated: try what happens when something fails.").classes("lf-quiet")
        names = [failure.name for failure in ALL]
        with ui.row().classes("lf-line"):
            self.failure = (
                ui.select(names, value=names[0], label="failure").props("dense outlined").classes("lf-select")
            )
            self.joint = ui.select(joints, value=joints[0], label="joint").props("dense outlined").classes("lf-select")
            theme.button("Fail", partial(self._do, "fail"), icon="bolt", kind="danger")
            theme.button("Heal", partial(self._do, "heal"), icon="healing")
        self.means = ui.label("").classes("lf-quiet")
        self.means.bind_text_from(self.failure, "value", lambda name: FAILURES[name].what if name in FAILURES else "")
        self.told = ui.label("").props("role=status")

    async def _do(self, word: str) -> None:
        try:
            answer = await asyncio.to_thread(self._tell, f"{word} {self.failure.value} {self.joint.value}")
        except LayflatError as error:
            answer = str(error)
        self.told.set_text(answer)
