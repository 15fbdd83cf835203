"""Another controller: its kind and its gains, changed while the rig is at rest, after a question."""

from typing import Any

from nicegui import ui

from layflat.description.change import changed_all, paths, value_at
from layflat.errors import LayflatError
from layflat.experiments.beyond.guesses import with_tracking
from layflat.machine import Machine
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed
from layflat.pages.panel.desk import Desk

DESCRIBED, TRACKING = "as described", "tracking"
PREFIXES = "controller.", ".gains."  # of paths of values that belong to a controller


class ControllerView:
    """A field for each number of the controller that the rig has."""

    def __init__(self, desk: Desk, key: str) -> None:
        """Build it for the page of a key."""
        self._desk, self._key = desk, key
        self._offers: dict[str, Machine] = {DESCRIBED: desk.first}
        if desk.first.control_law.name != TRACKING and (tracking := with_tracking(desk.first)) is not None:
            self._offers[TRACKING] = tracking
        self.kind = ui.select(
            list(self._offers), value=DESCRIBED, label="control law", on_change=lambda _: self._draw()
        )
        self.kind.props("dense outlined").classes("lf-select")
        self.fields = ui.element("div").classes("lf-fields lf-wide")
        with ui.row().classes("lf-line"):
            self.use = theme.button("Use it", self._use, icon="published_with_changes", kind="primary")
            theme.button("Back to what is in use", self._draw, icon="undo")
        self.told = ui.label("").classes("lf-told").props("role=alert")
        ui.label("Changed while the rig is at rest, without air. The description's file stays as it is.").classes(
            "lf-quiet lf-small"
        )
        self._draw()

    def refresh(self) -> None:
        """Enable what may be used."""
        self.use.set_enabled(self._desk.operators.drives(self._key) and self._desk.link.at_rest)

    def _base(self) -> Machine:
        """Return the machine whose numbers are shown: what is in use, if that is of the chosen kind."""
        chosen, now = self._offers[str(self.kind.value)], self._desk.machine
        return now if now.control_law.name == chosen.control_law.name else chosen

    def _draw(self) -> None:
        self.fields.clear()
        base = self._base()
        self._numbers: dict[str, ui.number] = {}
        with self.fields:
            for path in paths(base):
                value: Any = value_at(base, path)
                if any(part in path for part in PREFIXES) and isinstance(value, float):
                    field = ui.number(path.removeprefix("controller."), value=value, format="%.6g")
                    self._numbers[path] = field.props("dense outlined")

    async def _use(self) -> None:
        base = self._base()
        values = {path: field.value for path, field in self._numbers.items() if field.value != value_at(base, path)}
        try:
            if any(value is None for value in values.values()):
                raise LayflatError("a field is empty: give a number")
            machine = changed_all(base, values) if values else base
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text("")
        what = f"{len(values)} changed values" if values else "no changed value"
        if await confirmed(f"Use the {self.kind.value} control law with {what}? The rig connects anew.", "Use it"):
            self._desk.link.change(machine)
