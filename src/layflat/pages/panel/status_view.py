"""State of the rig with its reason and the next step, the operator, and the buttons that always count."""

from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.panel.advice import DONE, REASONS, STATES
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.history import air_rate
from layflat.pages.panel.link import Standing
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State
from layflat.rig.session import Snapshot

NO_STOP = (
    "Stop holds the arm where it is, with air; Vent lets the air out. Neither is an emergency stop: that is the red "
    "button at the rig."
)

GONE = {
    Standing.CONNECTING: (
        "Connecting",
        "With a machine that never ran here this takes half a minute: laws are compiled.",
    ),
    Standing.OPEN: ("Connecting", ""),  # it is there, and has not cycled yet
    Standing.GONE: ("No rig", "The page connects again by itself."),
    Standing.LENT: ("Checking", "The check has the rig."),
}
"""What is told while no cycle is seen."""


class StatusView:
    """State, fault and advice."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build it for the page of some controls."""
        self._desk, self._controls = desk, controls
        with theme.panel("State"):
            with ui.row().classes("lf-line"):
                self.state = ui.label("Connecting").classes("lf-state").props("role=status aria-live=polite")
                self.means = ui.label("").classes("lf-quiet")
            with ui.row().classes("lf-line"):
                self.start = theme.button("Start", controls.start, icon="play_arrow", kind="primary")
                self.vent = theme.button("Vent", controls.vent, icon="air")
                self.reset = theme.button("Reset", controls.reset, icon="restart_alt")
            self.fault = ui.column().classes("lf-fault").props("role=alert")
            self._told: tuple[Fault, str] | None = None
            ui.label(NO_STOP).classes("lf-quiet lf-small")

    def refresh(self, shot: Snapshot | None) -> None:
        """Show the last cycle, or that there is none."""
        drives = self._controls.drives
        if shot is None:
            self._show_gone()
            buttons = (False, False, False)
        else:
            name, means = STATES[shot.state]
            self.state.set_text(name)
            self.means.set_text(means)
            self.start.text = self.start.props["aria-label"] = "Go on" if shot.state is State.HOLDING else "Start"
            self._show_fault(shot.fault, shot.fault_text if shot.fault else self._desk.pilot.why)
            startable = shot.state in {State.OFF, State.STOPPED, State.HOLDING} and not shot.fault.latched
            buttons = (startable, bool(shot["air"]), shot.state is State.FAULT or shot.fault.latched)
        for button, fits in zip((self.start, self.vent, self.reset), buttons, strict=True):
            button.set_enabled(fits and drives)

    def _show_gone(self) -> None:
        link = self._desk.link
        name, means = GONE[link.standing]
        self.state.set_text(name)
        self.means.set_text(means)
        self._show_fault(Fault.NONE, link.trouble)

    def _show_fault(self, fault: Fault, text: str) -> None:
        if self._told == (fault, text):
            return
        self._told = fault, text
        self.fault.clear()
        if not text:
            return
        with self.fault:
            if fault is Fault.NONE:
                theme.note(text, "danger" if self._desk.snapshot() is None else "warning")
                return
            why, next_step = REASONS[fault]
            theme.note(text[:1].upper() + text[1:], "danger" if fault.latched else "warning")
            ui.label(why)
            ui.label(DONE[fault.reaction]).classes("lf-quiet")
            ui.label(f"Next: {next_step}").classes("lf-next")


class OperatorView:
    """View of who drives, and of how another page may; in the header."""

    def __init__(self, desk: Desk, key: str, name: str) -> None:
        """Build it for a page of this key and name."""
        self._operators, self._key = desk.operators, key
        self.text = ui.label("").props("role=status")
        self.take = theme.button("Drive from here", lambda: self._operators.take(key), kind="header")
        self.hand = theme.button("Hand over", lambda: self._operators.hand_over(key), kind="header")
        self.keep = theme.button("Keep driving", lambda: self._operators.keep(key), kind="header")
        self._name = name

    def refresh(self) -> None:
        """Show who drives now."""
        operator, asked = self._operators.operator, self._operators.asked_by
        drives = operator is not None and operator.key == self._key
        if operator is None:
            text = "nobody drives"
        elif drives and asked is not None:
            text = f"{asked.name} would like to drive"
        elif drives:
            text = f"this page drives ({self._name})"
        else:
            text = f"{operator.name} drives; this is {self._name}"
            text += ", which has asked" if asked is not None and asked.key == self._key else ""
        self.text.set_text(text)
        self.take.set_visibility(not drives)
        for button in (self.hand, self.keep):
            button.set_visibility(drives and asked is not None)


class TimingView:
    """Deadlines, link, recorder and air, in a line of figures."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        self._desk = desk
        with theme.panel("Rig"), ui.element("dl").classes("lf-figures"):
            self._values = {
                name: self._figure(name) for name in ("Link", "Loop late by", "Recorder", "Supply", "Air used")
            }

    @staticmethod
    def _figure(name: str) -> ui.label:
        with ui.element("div"):
            theme.text_element("dt", name)
            with ui.element("dd"):
                return ui.label("-")

    def refresh(self, shot: Snapshot | None) -> None:
        """Show the last cycle."""
        if shot is None:
            for label in self._values.values():
                label.set_text("-")
            return
        desk = self._desk
        history, ambient = desk.pilot.history, desk.machine.supply.ambient_pressure
        seen = history.seen()
        texts = (
            f"{1e3 * shot['link']:.2f} ms" if not shot["lost"] else f"{int(shot['lost'])} replies lost",
            f"{1e6 * shot['lateness']:.0f} us, worst {1e6 * history.worst_lateness:.0f} us",
            f"on: {desk.link.place.name}" if desk.link.recording else "not recording",
            f"{max(float(shot['supply']) - ambient, 0.0) / 1e5:.2f} bar",
            f"{air_rate(seen):.1f} normal litres/min (30 s)" if seen is not None else "-",
        )
        for label, text in zip(self._values.values(), texts, strict=True):
            label.set_text(text)
