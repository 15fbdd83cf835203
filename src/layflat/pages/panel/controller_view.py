"""Another controller: its kind and its gains, changed while the rig is at rest, after a question."""

from typing import Any

from nicegui import background_tasks, ui

from layflat.description.change import changed_all, paths, value_at
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.exchanged import with_tracking
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed, number
from layflat.pages.look.pieces import Pieces
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.pages.studio.field import Field, sentence, titled
from layflat.pages.studio.fields import field_at

DESCRIBED, TRACKING = "as described", "tracking"
PREFIXES = "controller.", ".gains."  # of paths of values that belong to a controller


class ControllerView:
    """A field for each number of the controller that the rig has, in the unit in which people write it."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it for the page of some controls."""
        self._desk, self._controls = desk, controls
        self._offers: dict[str, Machine] = {DESCRIBED: desk.first}
        if desk.first.control_law.name != TRACKING and (tracking := with_tracking(desk.first)) is not None:
            self._offers[TRACKING] = tracking
        self._numbers: dict[str, tuple[Field, ui.number]] = {}
        self._drawn = 0  # which drawing of the fields is the newest
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
        self.use.set_enabled(self._controls.drives and self._desk.link.at_rest)

    def _base(self) -> Machine:
        """Return the machine whose numbers are shown: what is in use, if that is of the chosen kind."""
        chosen, now = self._offers.get(str(self.kind.value), self._desk.machine), self._desk.machine
        return now if now.control_law.name == chosen.control_law.name else chosen

    def _draw(self) -> None:
        """Draw all fields anew; a drawing that goes on ends."""
        self._drawn += 1
        background_tasks.create(self._draw_fields(self._drawn, self._base()), context=self.fields)

    async def _draw_fields(self, drawing: int, base: Machine) -> None:
        pieces, written = Pieces(), self._desk.written
        await pieces.turn()
        if drawing != self._drawn:
            return
        self.fields.clear()
        self._numbers = numbers = {}
        for path in paths(base):
            value: Any = value_at(base, path)
            if any(part in path for part in PREFIXES) and isinstance(value, float):
                numbers[path] = self._add(field_at(base, written, path), value)
                await pieces.pause()
                if drawing != self._drawn:
                    return

    @staticmethod
    def _add(field: Field, value: float) -> tuple[Field, ui.number]:
        field = field.readable(value)
        suffix = field.unit or None
        entry = ui.number(named(field.path), value=field.number(value), format="%.7g", suffix=suffix)
        entry.props("dense outlined")
        if field.meaning or field.limits:
            entry.tooltip(sentence(field.meaning, field.limits))
        return field, entry

    async def _use(self) -> None:
        base = self._base()
        try:
            values = {path: text for path, (field, entry) in self._numbers.items()
                      if (text := _changed(field, entry.value, value_at(base, path))) is not None}  # fmt: skip
            machine = changed_all(base, values) if values else base
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text("")
        what = f"{len(values)} changed value{'s' * (len(values) != 1)}" if values else "no changed value"
        if await confirmed(f"Use the {self.kind.value} control law with {what}? The rig connects anew.", "Use it"):
            try:
                self._controls.change(machine)
            except LayflatError as error:  # the rig may have been started meanwhile
                self.told.set_text(str(error))


def named(path: str) -> str:
    """Return a value's path in words, such as "Large: far error" of joint.large.gains.far.error."""
    keys = path.split(".")
    if keys[0] == "joint":
        return f"{titled(keys[1])}: {' '.join(keys[3:]).replace('_', ' ')}"
    return titled(" ".join(keys[1:]))


def _changed(field: Field, value: Any, before: float) -> Any:
    """Return what stands in a file for a number that was changed; None where it was not."""
    typed = number(value)
    if typed is None:
        raise LayflatError(f"{named(field.path)}: holds no number; give one")
    if typed == field.number(before):
        return None
    return f"{typed:.9g} {field.unit}" if field.quantity is not None else typed
