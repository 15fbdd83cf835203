"""Views of all results of a design, on the right side of the page: figures, tables and pictures."""

from collections.abc import Callable
from dataclasses import replace
from math import degrees, radians

from nicegui import ui

from layflat.design.summary import Finding
from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.look.theme import clamp_number
from layflat.pages.studio.arm_view import ArmView
from layflat.pages.studio.cloud import StepCloud, Tolerances
from layflat.pages.studio.results import DesignQuantity, differences, relative_difference
from layflat.pages.studio.session import ChangedPart, ShownResults, StudioSession
from layflat.pages.studio.views import WAITING_TEXT, CamView, PressureView, ResultPanel, StepView, StrapView, TorqueView

TILE_NAMES = {
    "torque, greatest": "torque",
    "strap safety": "strap safety",
    "mass of the joint": "mass",
    "air of the move, nominal": "air per move",
    "settled, half of all runs": "settled, median",
    "settled, 95 % of all runs": "settled, 95 %",
}
"""Quantities that are shown as tiles, and their short names."""

MAX_FIGURE_ROWS = 15  # quantities in the table
SEVERITY_TONES = {"error": "danger", "warning": "warning", "note": "info"}
TOLERANCE_FIELDS = (
    ("supply", "Supply pressure, %", 50),
    ("valve", "Flow of the valve, %", 50),
    ("friction", "Torque of the brake, %", 100),
    ("losses", "Losses, %", 100),
    ("payload", "Payload up to, %", 200),
)
"""Fields of `Tolerances`, their names on the page, and their upper limits, per cent."""


class Tiles:
    """Tiles of the main quantities."""

    def __init__(self) -> None:
        """Make the tiles, without values, within the current element."""
        self._values: dict[str, ui.label] = {}
        self._units: dict[str, ui.label] = {}
        self._more: dict[str, ui.label] = {}
        with ui.element("dl").classes("st-tiles") as self.box:
            for name, short in TILE_NAMES.items():
                with ui.element("div").classes("st-tile"):
                    theme.text_element("dt", short)
                    with ui.element("dd"):
                        with ui.element("div").classes("st-figure"):
                            self._values[name] = ui.label("...").classes("st-value")
                            self._units[name] = ui.label().classes("lf-quiet lf-small")
                        self._more[name] = ui.label().classes("st-more")

    def show(self, now: list[DesignQuantity], other: list[DesignQuantity]) -> None:
        """Show the quantities of `TILE_NAMES`, and beneath them their relative differences from those of A, `other`."""
        by_name = {
            quantity.name: (quantity, relative_difference(quantity, beside))
            for quantity, beside, _ in differences(now, other)
        }
        for name, label in self._values.items():
            quantity, more = by_name.get(name, (None, ""))
            label.set_text(quantity.number if quantity is not None else "none")
            self._units[name].set_text(quantity.unit if quantity is not None and quantity.is_known else "")
            self._more[name].set_text(more)

    def mark_current(self, is_current: bool) -> None:
        """Grey the tiles out unless they belong to the newest edit."""
        self.box.classes(add="" if is_current else "st-old", remove="st-old" if is_current else "")


class DesignFiguresView(ResultPanel):
    """Table of all quantities of the design, those of A, and the differences."""

    def __init__(self) -> None:
        """Make the panel within the current element; `build` makes the rows."""
        super().__init__("Figures")
        with self.content:
            self._table = theme.LabelTable(("figure", "now", "A", "now less A"), MAX_FIGURE_ROWS)
            self.build = self._table.build

    def show(self, now: list[DesignQuantity], other: list[DesignQuantity]) -> None:
        """Show quantities and those of A."""
        compared = differences(now, other)
        self._table.show(
            [
                (one.name, one.text, other_quantity.text if other_quantity else "", more)
                for one, other_quantity, more in compared
            ]
        )


class FindingsView:
    """Table of the findings of the design rules and checks, worst first."""

    def __init__(self) -> None:
        self._box = ui.element("div").classes("st-findings")
        self._box.props('role=region aria-label="Design rules" aria-live=polite')
        self._shown: list[Finding] | None = None

    def show(self, findings: list[Finding], origin: str, *, checked: bool = True) -> None:
        """List findings, unless they are those shown already.

        Args:
            findings: findings, worst first.
            origin: source of the machine, which is removed from the texts.
            checked: whether the design rules have been evaluated.
        """
        if findings == self._shown:
            return
        self._shown = list(findings) if findings or checked else None
        self._box.clear()
        with self._box:
            if not findings and checked:
                theme.note("The design rules find nothing.", "good")
            elif not findings:
                theme.note(WAITING_TEXT)
            for finding in findings:
                text = str(finding).removeprefix(f"{origin}: ")
                theme.note(f"{finding.severity.capitalize()}: {text}", SEVERITY_TONES[finding.severity])


def quantities(session: StudioSession) -> tuple[list[DesignQuantity], list[DesignQuantity]]:
    """Return the quantities of a session's shown results, and those of design A; none for results to come."""
    return _quantities_of(session.shown), [] if session.kept is None else _quantities_of(session.kept.shown)


def _quantities_of(shown: ShownResults) -> list[DesignQuantity]:
    quantities = shown.figures.quantities if shown.figures is not None else []
    return quantities + (shown.cloud.quantities if isinstance(shown.cloud, StepCloud) else [])


class StepSettings:
    """Fields for the settings of the simulated step and of the tolerances."""

    def __init__(self, session: StudioSession) -> None:
        """Make them within the current element."""
        self._session = session
        tolerances, step = session.tolerances, session.step
        with ui.expansion("Step and tolerances").classes("st-settings").props("dense switch-toggle-side"):
            with ui.element("div").classes("st-grid"):
                self._size = _add_number("Step, deg", degrees(step.size), 1, 360, self._step)
                self._lasts = _add_number("Time shown, s", step.duration, 0.2, 10, self._step)
                self._shares = {
                    name: _add_number(label, 100 * getattr(tolerances, name), 0, upper, self._vary)
                    for name, label, upper in TOLERANCE_FIELDS
                }
            ui.label(
                "Runs differ by so much either way; payloads go from none to this share of the described one. The "
                "controller knows the nominal machine only."
            ).classes("lf-quiet lf-small")

    def _step(self) -> None:
        """Simulate the step with the size and duration in the fields."""
        step = self._session.step
        size, duration = _number_in(self._size, degrees(step.size)), _number_in(self._lasts, step.duration)
        self._session.simulate(step=replace(step, size=radians(size), duration=duration))

    def _vary(self) -> None:
        """Simulate with the tolerances in the fields."""
        before = self._session.tolerances
        shares = {name: _number_in(field, 100 * getattr(before, name)) / 100 for name, field in self._shares.items()}
        self._session.simulate(tolerances=Tolerances(**shares))


def _add_number(label: str, value: float, lower: float, upper: float, changed: Callable[[], object]) -> ui.number:
    """Add a field for a number; `changed` is called when it loses the focus or Enter is pressed."""
    field = ui.number(label, value=round(value, 6), min=lower, max=upper, format="%.4g").props("outlined dense")
    field.on("blur", changed).on("keydown.enter", changed)
    return field.classes("st-setting")


def _number_in(field: ui.number, before: float) -> float:
    """Return the number in a field, inside its limits; `before` where it holds none."""
    return clamp_number(field.value, field.min, field.max, before)


class ResultsView:
    """Views of the results, grey while they are older than the newest edit."""

    def __init__(self, session: StudioSession, look_at: Callable[[str], object]) -> None:
        """Store the session; `look_at` is called with the joint that is chosen; `build` makes the views."""
        self.session, self._look_at = session, look_at

    async def build(self, pieces: Pieces) -> None:
        """Make all views within the current element, piece by piece."""
        session, look_at = self.session, self._look_at
        joints = list(session.design.machine.joints)
        with ui.element("div").classes("st-bar-top"):
            if len(joints) > 1:
                ui.label("Joint").classes("st-name")
                chosen = ui.toggle(joints, value=session.step.joint, on_change=lambda event: look_at(event.value))
                chosen.props('dense no-caps unelevated toggle-color=primary aria-label="Joint that is shown"')
            StepSettings(session)
        await pieces.pause()
        self.tiles = Tiles()
        self.findings = FindingsView()
        await pieces.pause()
        with ui.element("div").classes("st-panels"):
            self.torque, self.step = TorqueView(session), StepView()
            await pieces.pause()
            self.cam, self.pressure = CamView(session), PressureView()
        await pieces.pause()
        self.arm = ArmView(session)
        await pieces.pause()
        self.strap, self.figures = StrapView(), DesignFiguresView()
        await self.figures.build(pieces)

    def changed(self, what: ChangedPart) -> None:
        """Show the part of the session that has changed."""
        if what in {"figures", "kept"}:
            self._show_figures()
        if what in {"cloud", "kept"}:
            self._show_cloud()
        if what == "solids":
            self.arm.show()
        self._mark_current()

    def _mark_current(self) -> None:
        """Show the views grey whose results are older than the newest edit."""
        session, shown = self.session, self.session.shown
        statics, cloud = shown.figures_number == session.number, shown.cloud_number == session.number
        for view in (self.torque, self.cam, self.strap):
            view.mark_current(statics)
        for late in (self.step, self.pressure):
            late.mark_current(cloud)
        self.arm.mark_current(session.solids_number == session.number)
        self.tiles.mark_current(statics and cloud)
        self.figures.mark_current(statics and cloud)

    def _show_figures(self) -> None:
        """Show the statics of the joint, and those of design A if they are of the same joint."""
        session = self.session
        figures, kept = session.shown.figures, session.kept.shown.figures if session.kept else None
        if figures is not None:
            kept = kept if kept is not None and kept.joint == figures.joint else None
            self.torque.show(figures, kept)
            self.cam.show(figures, kept)
            self.strap.show(figures)
        self.findings.show(session.findings, session.design.machine.origin, checked=figures is not None)
        self._show_tables()

    def _show_cloud(self) -> None:
        """Show the simulated step of the cloud, and that of design A if it was simulated without error."""
        shown, kept = self.session.shown, self.session.kept
        if shown.cloud is not None:
            other = kept.shown.cloud if kept is not None else None
            for view in (self.step, self.pressure):
                view.show(shown.cloud, other if not isinstance(other, LayflatError) else None)
        self._show_tables()

    def _show_tables(self) -> None:
        now, other = quantities(self.session)
        self.tiles.show(now, other)
        self.figures.show(now, other)
