"""Views of the rig's state with reason and next step, of the operator, and of timing and air."""

from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.panel.desk import Controls, Desk
from layflat.pages.panel.link import LinkState
from layflat.pages.panel.pilot import air_rate
from layflat.rig.safety.faults import Fault, Reaction, RigState
from layflat.rig.session import RigSnapshot

FAULT_ADVICE: dict[Fault, tuple[str, str]] = {
    Fault.RECORDER_DEAD: (
        "Nothing is recorded any more: the disk may be full.",
        "Make room on the disk; the rig connects anew once its air is out.",
    ),
    Fault.DEMAND_LIMITED: (
        "The arm was asked to move faster than it can.",
        "Nothing to do: it went as fast as it can.",
    ),
    Fault.DEMAND_REFUSED: ("A place outside the working stroke was asked for.", "Ask for a place inside the stroke."),
    Fault.CYCLE_MISSED: (
        "This computer was too busy for the control loop.",
        "If it comes again and again, close other programs.",
    ),
    Fault.REPLY_LOST: ("One message from the rig was lost.", "If it comes again and again, look at cable and plugs."),
    Fault.MODEL_DOUBTED: (
        "The arm does not behave as described: a wrong payload, a leak, or something in its way.",
        "Look what holds the arm; check payload and description; then ask for another place.",
    ),
    Fault.FOLLOWING_ERROR: (
        "A joint does not go where it is led: something holds it, or the load is too heavy.",
        "Free the arm, or lighten the load. Then reset, and go on.",
    ),
    Fault.BAD_COMMAND: (
        "The control law asked for a voltage that can't be.",
        "Reset; if it comes again, check the gains.",
    ),
    Fault.DEVICE_CENTRED: (
        "The rig heard nothing from this computer for a moment and closed its valves.",
        "Look at cable and plugs. Then reset, and go on.",
    ),
    Fault.SETPOINT_STALE: (
        "Nobody minded the rig: the page was closed, hidden or out of touch.",
        "Keep this page open and in view while there is air; then start again.",
    ),
    Fault.NO_AIR: (
        "The supply did not come to its pressure.",
        "Open the supply, look for leaks. Then reset and start.",
    ),
    Fault.PRESSURE_FROZEN: (
        "A pressure sensor repeats one value.",
        "Look at the sensor's wires and plug. Then reset and start.",
    ),
    Fault.ANGLE_FROZEN: (
        "An angle does not change although it should: its sensor is frozen, or the joint is blocked.",
        "See whether the joint can turn; look at the sensor's wires. Then reset and start.",
    ),
    Fault.ANGLE_AT_RAIL: (
        "An angle sensor is open or shorted.",
        "Look at the sensor's wires and plug. Then reset and start.",
    ),
    Fault.SUPPLY_LOST: (
        "The supply's pressure has fallen: compressor off, line burst or shut.",
        "See to the compressor and the line. Then reset and start.",
    ),
    Fault.VALVE_UNRESPONSIVE: (
        "Air does not answer the valve: a spool sticks, or a hose is burst or kinked.",
        "Look at the joint's hoses and valve. Then reset and start.",
    ),
    Fault.LINK_LOST: (
        "The rig does not answer any more.",
        "Look at its power, cable and plugs. The page connects again by itself; then reset.",
    ),
    Fault.OVER_PRESSURE: ("Pressure is too high.", "Look at the regulator. Then reset and start."),
    Fault.OUTSIDE_STROKE: (
        "A joint went beyond its working stroke.",
        "See what pushed it. Then reset and start: the arm is led inside slowly.",
    ),
    Fault.OVER_SPEED: (
        "A joint was too fast.",
        "See what pushed it, or whether it lost its load. Then reset and start.",
    ),
    Fault.DEVICE_DUMPED: (
        "The rig heard nothing from this computer and vented the air.",
        "Look at cable and plugs. Then reset and start.",
    ),
    Fault.E_STOP: ("The emergency stop is pressed.", "Release it when all is well. Then reset and start."),
}
"""Reason for each fault, and the next step of a person."""

STATE_TEXTS: dict[RigState, tuple[str, str]] = {
    RigState.OFF: ("Off", "No air. Start brings it, slowly."),
    RigState.STARTING: ("Starting", "Air comes in slowly; the joints are held."),
    RigState.READY: ("Ready", "Air is there. Jog, or give a target."),
    RigState.MOVING: ("Moving", "The arm follows what it is asked for."),
    RigState.HOLDING: ("Holding", "The joints are held, with air. Go on when all is well."),
    RigState.STOPPED: ("Stopped", "The joints were held, and the air is vented. Start brings it again."),
    RigState.FAULT: ("Fault", "See what to do below."),
}
"""Name and meaning of each state."""

REACTION_TEXTS: dict[Reaction, str] = {
    Reaction.WARN: "The arm goes on.",
    Reaction.HOLD: "The joints are held, with air.",
    Reaction.STOP: "The joints were held, and the air is vented.",
    Reaction.VENT_JOINT: "The air is off; the joint's valve vents it.",
    Reaction.VENT: "The air of all joints is vented.",
    Reaction.DUMP: "The air is vented, by the rig itself, too.",
}
"""Effect of each reaction to a fault."""


STOP_NOTICE = (
    "Stop holds the arm where it is, with air; Vent vents the hoses. Neither is an emergency stop: that is the red "
    "button at the rig."
)

LINK_TEXTS = {
    LinkState.CONNECTING: (
        "Connecting",
        "With a machine that never ran here this takes half a minute: laws are compiled.",
    ),
    LinkState.OPEN: ("Connecting", ""),  # it is connected, and has not cycled yet
    LinkState.GONE: ("No rig", "The page connects again by itself."),
    LinkState.LENT: ("Checking", "The check has the rig."),
}
"""Name and meaning of the link's state while there is no cycle."""


class StatusView:
    """View of state, fault and advice."""

    def __init__(self, desk: Desk, controls: Controls) -> None:
        """Build the view for the page that has these controls."""
        self._desk, self._controls = desk, controls
        with theme.panel("State"):
            with ui.row().classes("lf-line"):
                self.state = ui.label("Connecting").classes("lf-state").props("role=status aria-live=polite")
                self.means = ui.label("").classes("lf-quiet")
            with ui.row().classes("lf-line"):
                self.start = theme.button("Start", controls.start, icon="play_arrow", kind="primary")
                self.vent = theme.button("Vent", controls.controlled_stop, icon="air")
                self.reset = theme.button("Reset", controls.reset, icon="restart_alt")
            self.fault = ui.column().classes("lf-fault").props("role=alert")
            self._shown_fault: tuple[Fault, str] | None = None
            ui.label(STOP_NOTICE).classes("lf-quiet lf-small")

    def refresh(self, shot: RigSnapshot | None) -> None:
        """Show state and fault of the last cycle, or the state of the link."""
        drives = self._controls.drives
        if shot is None:
            self._show_link_state()
            buttons = (False, False, False)
        else:
            name, means = STATE_TEXTS[shot.state]
            self.state.set_text(name)
            self.means.set_text(means)
            self.start.text = self.start.props["aria-label"] = "Go on" if shot.state is RigState.HOLDING else "Start"
            self._show_fault(shot.fault, shot.fault_text if shot.fault else self._desk.pilot.hold_reason)
            startable = shot.state in {RigState.OFF, RigState.STOPPED, RigState.HOLDING} and not shot.fault.latched
            buttons = (startable, bool(shot["air"]), shot.state is RigState.FAULT or shot.fault.latched)
        for button, is_useful in zip((self.start, self.vent, self.reset), buttons, strict=True):
            button.set_enabled(is_useful and drives)

    def _show_link_state(self) -> None:
        """Show the state of the link and its trouble, while no rig is connected."""
        link = self._desk.link
        name, means = LINK_TEXTS[link.state]
        self.state.set_text(name)
        self.means.set_text(means)
        self._show_fault(Fault.NONE, link.trouble)

    def _show_fault(self, fault: Fault, text: str) -> None:
        """Show a fault with reaction and next step, or a text without a fault as a note; nothing for an empty text."""
        if self._shown_fault == (fault, text):
            return
        self._shown_fault = fault, text
        self.fault.clear()
        if not text:
            return
        with self.fault:
            if fault is Fault.NONE:
                theme.note(text, "danger" if self._desk.snapshot() is None else "warning")
                return
            why, next_step = FAULT_ADVICE[fault]
            theme.note(text[:1].upper() + text[1:], "danger" if fault.latched else "warning")
            ui.label(why)
            ui.label(REACTION_TEXTS[fault.reaction]).classes("lf-quiet")
            ui.label(f"Next: {next_step}").classes("lf-next")


class OperatorView:
    """View of the page that drives, with the buttons of a handover; in the header."""

    def __init__(self, desk: Desk, key: str, name: str) -> None:
        """Build it for the page with this key and name."""
        self._operators, self._key = desk.operators, key
        self.text = ui.label("").props("role=status")
        self.take = theme.button("Drive from here", lambda: self._operators.take_control(key), kind="header")
        self.hand = theme.button("Hand over", lambda: self._operators.hand_over(key), kind="header")
        self.keep = theme.button("Keep driving", lambda: self._operators.refuse_request(key), kind="header")
        self._name = name

    def refresh(self) -> None:
        """Show which page drives or requests control, and the buttons that this page may use."""
        operator, requester = self._operators.operator, self._operators.requested_by
        drives = operator is not None and operator.key == self._key
        if operator is None:
            text = "nobody drives"
        elif drives and requester is not None:
            text = f"{requester.name} would like to drive"
        elif drives:
            text = f"this page drives ({self._name})"
        else:
            text = f"{operator.name} drives; this is {self._name}"
            text += ", which has asked" if requester is not None and requester.key == self._key else ""
        self.text.set_text(text)
        self.take.set_visibility(not drives)
        for button in (self.hand, self.keep):
            button.set_visibility(drives and requester is not None)


class TimingView:
    """View of link, lateness, recorder, supply and air, in a line of figures."""

    def __init__(self, desk: Desk) -> None:
        """Build the view within the current element."""
        self._desk = desk
        with theme.panel("Rig"), ui.element("dl").classes("lf-figures"):
            names = ("Link", "Loop late by", "Recorder", "Supply", "Air used")
            self._values = {name: theme.figure(name) for name in names}

    def refresh(self, shot: RigSnapshot | None) -> None:
        """Show the figures of the last cycle, and the mean air consumption; "-" for all without a cycle."""
        if shot is None:
            for label in self._values.values():
                label.set_text("-")
            return
        desk = self._desk
        history, ambient = desk.pilot.history, desk.machine.supply.ambient_pressure
        samples = history.samples()
        texts = (
            f"{1e3 * shot['link']:.2f} ms" if not shot["lost"] else f"{int(shot['lost'])} replies lost",
            f"{1e6 * shot['lateness']:.0f} us, worst {1e6 * history.worst_lateness:.0f} us",
            f"on: {desk.link.log_path.name}" if desk.link.is_recording else "not recording",
            f"{max(float(shot['supply']) - ambient, 0.0) / 1e5:.2f} bar",
            f"{air_rate(samples):.1f} normal litres/min (30 s)" if samples is not None else "-",
        )
        for label, text in zip(self._values.values(), texts, strict=True):
            label.set_text(text)
