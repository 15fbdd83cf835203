"""View that changes the rig's controller: its kind and its gains, while the rig is at rest, after a question."""

from typing import Any

from nicegui import background_tasks, ui

from layflat.description.change import changed_all, paths, value_at
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.exchanged import with_tracking
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.look.theme import confirm, finite_number
from layflat.pages.panel.desk import Controls, Desk
from layflat.pages.studio.field import Field, describe_value, field_at, key_title

AS_DESCRIBED, TRACKING_LAW = "as described", "tracking"
PREFIXES = "controller.", ".gains."  # of paths of values that belong to a controller


class ControllerView:
    """View of the controller: a field for each number of it, in the unit of the description."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build the view for the page that has these controls."""
        self._desk, self._controls = desk, controls
        self._offers: dict[str, Machine] = {AS_DESCRIBED: desk.first}
        if desk.first.control_law.name != TRACKING_LAW and (tracking := with_tracking(desk.first)) is not None:
            self._offers[TRACKING_LAW] = tracking
        self._numbers: dict[str, tuple[Field, ui.number]] = {}
        self._drawn = 0  # which drawing of the fields is the newest
        self.kind = ui.select(
            list(self._offers), value=AS_DESCRIBED, label="control law", on_change=lambda _: self._draw()
        )
        self.kind.props("dense outlined").classes("lf-select")
        self.fields = ui.element("div").classes("lf-fields lf-wide")
        with ui.row().classes("lf-line"):
            self.use = theme.button("Use it", self._change_controller, icon="published_with_changes", kind="primary")
            theme.button("Back to what is in use", self._draw, icon="undo")
        self.status = ui.label("").classes("lf-told").props("role=alert")
        ui.label("Changed while the rig is at rest, without air. The description's file stays as it is.").classes(
            "lf-quiet lf-small"
        )
        self._draw()

    def refresh(self) -> None:
        """Enable the buttons that may be used now."""
        self.use.set_enabled(self._controls.drives and self._desk.link.is_at_rest)

    def _base(self) -> Machine:
        """Return the machine whose numbers are shown: the machine in use, if its control law is of the chosen kind."""
        chosen, now = self._offers.get(str(self.kind.value), self._desk.machine), self._desk.machine
        return now if now.control_law.name == chosen.control_law.name else chosen

    def _draw(self) -> None:
        """Redraw all fields; an older drawing that still runs ends."""
        self._drawn += 1
        background_tasks.create(self._draw_fields(self._drawn, self._base()), context=self.fields)

    async def _draw_fields(self, drawing: int, base: Machine) -> None:
        """Build the fields of the control law's numbers in short pieces, until a newer drawing is begun."""
        pieces, written = Pieces(), self._desk.written
        await pieces.turn()
        if drawing != self._drawn:
            return
        self.fields.clear()
        self._numbers = numbers = {}
        for path in paths(base):
            value: Any = value_at(base, path)
            if any(part in path for part in PREFIXES) and isinstance(value, float):
                numbers[path] = self._add_entry(field_at(base, written, path), value)
                await pieces.pause()
                if drawing != self._drawn:
                    return

    @staticmethod
    def _add_entry(field: Field, value: float) -> tuple[Field, ui.number]:
        """Add an entry for a number; return its field, in the unit that shows it best, with the entry."""
        field = field.readable(value)
        suffix = field.unit or None
        entry = ui.number(describe_path(field.path), value=field.number(value), format="%.7g", suffix=suffix)
        entry.props("dense outlined")
        if field.meaning or field.limits:
            entry.tooltip(describe_value(field.meaning, field.limits))
        return field, entry

    async def _change_controller(self) -> None:
        """Change the rig's controller by the entered values, after a question; then the rig connects anew."""
        base = self._base()
        with theme.show_errors_on(self.status):
            values = {path: text for path, (field, entry) in self._numbers.items()
                      if (text := _changed_value(field, entry.value, value_at(base, path))) is not None}  # fmt: skip
            machine = changed_all(base, values) if values else base
            self.status.set_text("")
            what = f"{len(values)} changed value{'s' * (len(values) != 1)}" if values else "no changed value"
            if await confirm(f"Use the {self.kind.value} control law with {what}? The rig connects anew.", "Use it"):
                self._controls.change(machine)  # the rig may have been started meanwhile


def describe_path(path: str) -> str:
    """Return a value's path in words, such as "Large: far error" of joint.large.gains.far.error."""
    keys = path.split(".")
    if keys[0] == "joint":
        return f"{key_title(keys[1])}: {' '.join(keys[3:]).replace('_', ' ')}"
    return key_title(" ".join(keys[1:]))


def _changed_value(field: Field, value: Any, before: float) -> Any:
    """Return an entered number as a description holds it, with its unit; None where it shows the SI value `before`.

    Raises:
        LayflatError: the entry holds no finite number.
    """
    typed = finite_number(value)
    if typed is None:
        raise LayflatError(f"{describe_path(field.path)}: holds no number; give one")
    if typed == field.number(before):
        return None
    return f"{typed:.9g} {field.unit}" if field.quantity is not None else typed
