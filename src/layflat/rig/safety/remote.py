"""Supervisor of a rig whose device runs the control law and the supervisor itself: it forwards requests to the device.

States, faults and signals are those that the device reports. Faults of the link remain the loop's: the device knows
nothing of replies that are lost on their way.
"""

from math import nan
from typing import Protocol, runtime_checkable

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.abilities import vent_time
from layflat.rig.driver import Driver, SensorReading
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.ledger import START_BARRED
from layflat.rig.safety.requests import DeviceRequest, DeviceStatus
from layflat.rig.safety.state_machine import CENTRED_TIME
from layflat.rig.safety.supervisor import REFUSAL_TEXTS, HostRequest, event_texts

EVENT_MODULUS, CYCLE_MODULUS = 1 << 16, 1 << 16  # numbers of events and cycles go round


@runtime_checkable
class LawDevice(Protocol):
    """Driver of a device that runs the control law."""

    @property
    def status(self) -> DeviceStatus | None:
        """Return the last status; None before the first."""

    def request(self, request: DeviceRequest) -> None:
        """Store a request for the next transaction."""


class RemoteLedger:
    """Ledger of the faults that the device reports, and of those of its link; the worst wins."""

    def __init__(self, joints: int) -> None:
        self.events: list[str] = []  # events to be recorded; the loop clears them
        self.reported, self.joints = Fault.NONE, [Fault.NONE] * joints  # worst fault of the device, and of each joint
        self.is_link_lost = False  # whether the link was lost since the last reset
        self._present: set[Fault] = set()  # faults of the link in this cycle

    @property
    def worst(self) -> Fault:
        """Return the worst fault that is latched or of this cycle."""
        latched = Fault.LINK_LOST if self.is_link_lost else Fault.NONE
        return max(self.reported, latched, *self._present)

    def note(self, faults: set[Fault]) -> None:
        """Replace the faults of the link by those of this cycle; one that is new adds an event."""
        self.events += [fault.title for fault in sorted(faults - self._present)]
        self._present = faults
        self.is_link_lost = self.is_link_lost or Fault.LINK_LOST in faults


class RemoteSupervisor:
    """Supervisor of a machine whose control law and supervisor run on the device."""

    def __init__(self, machine: Machine, device: LawDevice) -> None:
        self._device, self._names = device, list(machine.joints)
        self.ledger = RemoteLedger(len(self._names))
        self.missed = False  # whether a cycle of the loop was left out before this one
        self.recording = True  # whether the rows are recorded; else no start is allowed
        self.lost, self.outputs = 0, 0  # replies lost in succession; digital outputs that are on, as bits
        self._reported = RigState.OFF
        self.valve_mode, self._vented = ValveMode.CENTRE, True
        self._request = DeviceRequest.first(len(self._names))
        self._events: int | None = None  # number of the device's events so far; None before the first status
        layout = RowLayout.for_machine(machine)
        self._signals = np.full((len(self._names), len(layout.by_joint) - 1), nan)
        self._measured = [layout.columns[name] for name in ("measured_angle", "measured_pressure")]
        safety = machine.safety
        self._silent_for, self._time_to_vent = 0.0, (
            safety.setpoint_age + safety.hold_time + CENTRED_TIME + vent_time(machine)
        )  # fmt: skip

    @property
    def state(self) -> RigState:
        """Return the state that the device reports; FAULT once its link was lost, until a reset."""
        return RigState.FAULT if self.ledger.is_link_lost else self._reported

    @property
    def is_pressurised(self) -> bool:
        """Return whether the dump valve connected the supply when the device last replied."""
        return self.valve_mode in {ValveMode.HOLD, ValveMode.FOLLOW}

    @property
    def is_vented(self) -> bool:
        """Return whether the hoses are vented: as the device reports, or in silence by the time that it takes."""
        return self._vented or self._silent_for > self._time_to_vent

    @property
    def fault(self) -> Fault:
        """Return the worst fault of device and link."""
        return self.ledger.worst

    def cycle(self, reading: SensorReading | None, request: HostRequest, elapsed: float, since: float) -> None:
        """Take over the device's status, and send it the host's request.

        Args:
            reading: reading of the sensors; None where the reply was lost.
            request: request of the host.
            elapsed: time since the last reading, s, which the device measures itself.
            since: time since the last cycle, s.
        """
        del elapsed
        faults = {Fault.CYCLE_MISSED} if self.missed else set[Fault]()
        if reading is not None:
            self.lost, self._silent_for = 0, 0.0
            status = self._device.status
            assert status is not None  # of which this is the reading
            self._mirror(status)
        else:
            self.lost, self._silent_for = self.lost + 1, self._silent_for + since
            faults |= {Fault.REPLY_LOST, *([Fault.LINK_LOST] if self.lost >= Fault.LINK_LOST.cycles else [])}
        self.ledger.note(faults)
        if request.reset and reading is not None:
            self.ledger.is_link_lost = False
        self._forward(request)

    def send(self, driver: Driver) -> None:
        """Leave the driver alone: the request of this cycle is with it already."""

    def record(self, rows: Array) -> None:
        """Write the signals of each joint, as in `record.RowLayout`, into rows, (joints, numbers)."""
        rows[:, :-1], rows[:, -1] = self._signals, self.ledger.joints

    def _mirror(self, status: DeviceStatus) -> None:
        """Take over states, faults, events and signals of the device."""
        skipped = len(status.events) if self._events is None else (self._events - status.events_before) % EVENT_MODULUS
        before = status.state if self._events is None else self._reported
        events = status.events[skipped if skipped <= len(status.events) else 0 :]
        self.ledger.events += event_texts(events, before, self._names)
        self._events = (status.events_before + len(status.events)) % EVENT_MODULUS
        self._reported, self.valve_mode, self._vented = status.state, status.mode, status.vented
        self.outputs, self.ledger.reported, self.ledger.joints = status.outputs, status.fault, status.joint_faults
        self._signals[:] = status.signals
        self._signals[:, self._measured] = np.column_stack([status.reading.angles, status.reading.pressures])

    def _forward(self, request: HostRequest) -> None:
        """Send the host's request; a start only while no link fault is latched, and a stop while one is."""
        ledger = self.ledger
        start = request.start and not ledger.is_link_lost
        if request.start and not start:
            ledger.events.append(REFUSAL_TEXTS[START_BARRED])
        forwarded = request._replace(start=start, stop=request.stop or ledger.is_link_lost)
        self._request = self._request.following(forwarded, recording=self.recording, events=self._events or 0)
        self._device.request(self._request)
