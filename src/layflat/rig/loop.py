"""The real-time loop: read, judge, update, gate, write, record, publish; once a control cycle, at absolute deadlines.

deadline -> driver.read -> supervisor (detectors, demands, control law, voltages) -> driver.write -> row -> snapshot
"""

from struct import Struct
from time import perf_counter_ns, time_ns
from typing import Protocol

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.clock import NS_PER_SECOND, Deadlines, LoopClock
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Driver, LinkError, SensorReading
from layflat.rig.law import ArmLaw
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.safety.remote import LawDevice, RemoteSupervisor
from layflat.rig.safety.supervisor import HostRequest, Supervisor

ROW_HEADER = Struct(f"{len(SHARED_COLUMNS)}d")  # shared numbers at the start of a row
MAX_REASONS = 10  # kinds of trouble with the link that become events
ALIVE_EVERY = 20  # cycles between two checks that the recorder is alive


def supervisor_of(machine: Machine, driver: Driver) -> Supervisor | RemoteSupervisor:
    """Return the supervisor of a machine: one of the loop's own, or that of a device which runs the law itself."""
    if driver.runs_law and isinstance(driver, LawDevice):
        return RemoteSupervisor(machine, driver)
    return Supervisor(machine, ArmLaw(machine, driver.late))


class Host(Protocol):
    """Host of the loop: it requests motions, and receives every row."""

    def request(self, now: int) -> HostRequest:
        """Return the request for the cycle that began at `now` (ns); each edge is returned once."""

    def publish(self, row: Array) -> None:
        """Receive a row of `record.RowLayout`; the array is overwritten in the next cycle."""

    @property
    def ended(self) -> bool:
        """Return whether the loop is to end once the hoses are vented."""


class LoopRecorder:
    """Base class of the loop's recorders, and one that keeps nothing."""

    def push(self, row: Array) -> None:
        """Record a row of `record.RowLayout`; the array is overwritten in the next cycle."""

    def event(self, text: str) -> None:
        """Record a line for people."""

    def is_alive(self) -> bool:
        """Return whether rows reach the disk: False within a second of the recorder's death."""
        return True

    def end(self) -> None:
        """Finish: no more rows and events will come."""


class RigLoop:
    """Control loop of one rig; `cycle` performs one control cycle, `run` all of them.

    Args:
        machine: description of the rig.
        driver: inactive or active driver of the rig.
        clock: clock of the deadlines.
        host: source of requests, and receiver of rows.
        recorder: receiver of rows and events; default: one that keeps nothing.

    Raises:
        MachineError: the machine lacks valve, sensors, controller or gains.
        KindError: its control law commands fractions of brake, dither or supply.
    """

    def __init__(
        self, machine: Machine, driver: Driver, clock: LoopClock, host: Host, recorder: LoopRecorder | None = None
    ) -> None:
        self.driver, self.clock, self.host = driver, clock, host
        self.recorder = recorder or LoopRecorder()
        self._supervisor = supervisor_of(machine, driver)
        self.deadlines = Deadlines(clock, machine.cycle)
        self.layout = RowLayout.for_machine(machine)
        self.row = np.zeros(self.layout.width)
        self._joints = self.layout.joint_rows(self.row)
        n = len(machine.joints)
        self._reading = SensorReading(np.zeros(n), np.zeros(n), 0.0, False, DeviceState.RUNNING)
        self._seen_at: int | None = None
        self._cycles, self._compute = 0, 0.0
        self._recording = True
        self._reported: set[str] = set()  # kinds of trouble with the link that became events

    @property
    def supervisor(self) -> Supervisor:
        """Return the supervisor that runs in this loop; where the device has its own, there is none."""
        assert isinstance(self._supervisor, Supervisor)
        return self._supervisor

    def start_filled(self, reading: SensorReading) -> None:
        """Start with filled hoses, as a simulated run does, and controllers initialized with this reading."""
        self.supervisor.start_filled(reading)
        self._cycles = 1

    def run(self) -> None:
        """Cycle until the host has ended and the air is out; finalize the driver at the end, whatever happens."""
        try:
            while not (self.host.ended and self._supervisor.is_vented):
                self.cycle()
        finally:
            self.driver.finalize()

    def cycle(self) -> None:
        """Wait for the next deadline, then read, supervise, write, record and publish.

        Deadlines missed by a cycle or more are skipped, with the fault CYCLE_MISSED. A LinkError in reading counts as a
        lost reply, whose reason becomes an event once; writing raises none.
        """
        now = self.deadlines.wait()
        begun = perf_counter_ns()
        try:
            reading: SensorReading | None = self.driver.read()
        except LinkError as error:
            reading = None
            self._report_once(error.reason)
        answered, seen = perf_counter_ns(), self.clock.now()
        supervisor, deadlines = self._supervisor, self.deadlines
        elapsed = deadlines.cycle if self._seen_at is None else (seen - self._seen_at) / NS_PER_SECOND
        if reading is not None:
            self._reading, self._seen_at = reading, seen
            self._cycles += 1
        if self._cycles % ALIVE_EVERY == 0:
            self._recording = self.recorder.is_alive()
        supervisor.missed, supervisor.recording = deadlines.missed_now > 0, self._recording
        supervisor.cycle(reading, self.host.request(now), elapsed, deadlines.elapsed)
        supervisor.send(self.driver)
        self._record(now, (answered - begun) / NS_PER_SECOND)
        self._compute = (perf_counter_ns() - answered) / NS_PER_SECOND
        deadlines.record_compute_time(self._compute)

    def _report_once(self, reason: str) -> None:
        """Add an event about the link once for each of up to `MAX_REASONS` reasons, digits in them ignored."""
        kind = "".join(letter for letter in reason if not letter.isdigit())
        if reason and kind not in self._reported and len(self._reported) < MAX_REASONS:
            self._reported.add(kind)
            self._supervisor.ledger.events.append(f"link: {reason}")

    def _record(self, now: int, link: float) -> None:
        """Fill the row, pass it to recorder and host, and record the events of the cycle, which are cleared.

        `now` is the begin of the cycle, ns; `link` the duration of its transaction, s.
        """
        row, reading, supervisor, deadlines = self.row, self._reading, self._supervisor, self.deadlines
        ledger, begun = supervisor.ledger, deadlines.begun
        since = now - begun if begun is not None else 0
        ROW_HEADER.pack_into(
            row.data, 0, since / NS_PER_SECOND, time_ns() / NS_PER_SECOND, deadlines.elapsed, deadlines.lateness,
            self._compute, link, reading.supply, supervisor.is_pressurised, reading.stopped, reading.device,
            supervisor.state, supervisor.fault, supervisor.lost, supervisor.outputs,
        )  # fmt: skip
        supervisor.record(self._joints)
        self.recorder.push(row)
        self.host.publish(row)
        if ledger.events:
            for text in ledger.events:
                self.recorder.event(text)
            ledger.events.clear()
