"""The real-time loop: read, judge, update, gate, write, record, publish; once a control cycle, at absolute deadlines.

deadline -> driver.read -> supervisor (detectors, demands, control law, voltages) -> driver.write -> row -> snapshot
"""

from struct import Struct
from time import perf_counter_ns, time_ns
from typing import Protocol

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.rig.clock import SECOND, Clock, Deadlines
from layflat.rig.driver import Command, DeviceState, Driver, LinkError, Reading
from layflat.rig.law import ArmLaw
from layflat.rig.record import SHARED
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.supervisor import HostRequest, Supervisor

HEAD = Struct(f"{len(SHARED)}d")  # of a row: what there is once
MAX_REASONS = 10  # kinds of trouble with the link that are told
ALIVE_EVERY = 20  # cycles between two looks whether the recorder is alive


class Host(Protocol):
    """Who wants something of the loop, and looks on."""

    def request(self, now: int) -> HostRequest:
        """What is wanted in the cycle that began at `now` (ns); edges are given once."""

    def publish(self, row: Array) -> None:
        """Show a row of `record.Layout`; it is used again in the next cycle."""

    @property
    def ended(self) -> bool:
        """Whether the loop is to end once it has let out the air."""


class Recorder:
    """What keeps every cycle; this one keeps nothing."""

    def push(self, row: Array) -> None:
        """Take a row of `record.Layout`; it is used again in the next cycle."""

    def event(self, text: str) -> None:
        """Take a line for people."""

    def alive(self) -> bool:
        """Whether rows reach the disk: false within a second of its death."""
        return True

    def end(self) -> None:
        """Nothing more will come."""


class Loop:
    """One rig in motion; `cycle` performs one control cycle, `run` all of them.

    The driver is inactive or active. Raise MachineError if the machine lacks valve, sensors, controller or gains.
    """

    def __init__(
        self, machine: Machine, driver: Driver, clock: Clock, host: Host, recorder: Recorder | None = None
    ) -> None:
        law = ArmLaw(machine, driver.late)
        self.driver, self.clock, self.host = driver, clock, host
        self.recorder = recorder or Recorder()
        self.supervisor = Supervisor(machine, law)
        self.deadlines = Deadlines(clock, machine.cycle)
        self.layout = law.layout
        self.row = np.zeros(self.layout.width)
        self._joints, self._faults = self.layout.joint_rows(self.row), self.layout.named(self.row, "joint_fault")
        n = len(machine.joints)
        self._reading = Reading(np.zeros(n), np.zeros(n), 0.0, False, DeviceState.RUNNING)
        self._seen_at: int | None = None
        self._cycles, self._compute = 0, 0.0
        self._recording = True
        self._told: set[str] = set()  # what was wrong with the link, each kind once

    def begin(self, reading: Reading) -> None:
        """Start with air that is there already, as a simulated run does, with controllers woken by this reading."""
        self.supervisor.begin(reading, filled=True)
        self._cycles = 1

    def run(self) -> None:
        """Cycle until the host has ended and the air is out; the driver is left deactivated, whatever happens."""
        try:
            while not (self.host.ended and self.supervisor.empty):
                self.cycle()
        finally:
            self.driver.finalize()

    def cycle(self) -> None:
        """Wait for the next deadline, and do what has to be done then."""
        now = self.deadlines.wait()
        begun = perf_counter_ns()
        try:
            reading: Reading | None = self.driver.read()
        except LinkError as error:
            reading = None
            self._tell_once(error.reason)
        answered, seen = perf_counter_ns(), self.clock.now()
        supervisor, deadlines = self.supervisor, self.deadlines
        elapsed = deadlines.cycle if self._seen_at is None else (seen - self._seen_at) / SECOND
        if reading is not None:
            self._reading, self._seen_at = reading, seen
            if self._cycles == 0:
                supervisor.begin(reading)
            self._cycles += 1
        if self._cycles % ALIVE_EVERY == 0:
            self._recording = self.recorder.alive()
        found = (Fault.CYCLE_MISSED,) if deadlines.missed_now else ()
        supervisor.noted = found if self._recording else (*found, Fault.RECORDER_DEAD)
        supervisor.barred = not self._recording
        supervisor.cycle(reading, self.host.request(now), elapsed, deadlines.elapsed)
        voltages = supervisor.voltages.copy()
        self.driver.write(Command(voltages, supervisor.air, supervisor.resets, supervisor.outputs))
        self._record(now, (answered - begun) / SECOND)
        self._compute = (perf_counter_ns() - answered) / SECOND
        deadlines.took(self._compute)

    def _tell_once(self, reason: str) -> None:
        """Note what is wrong with the link as an event, once for each reason: numbers in it do not make it another."""
        kind = "".join(letter for letter in reason if not letter.isdigit())
        if reason and kind not in self._told and len(self._told) < MAX_REASONS:
            self._told.add(kind)
            self.supervisor.ledger.events.append(f"link: {reason}")

    def _record(self, now: int, link: float) -> None:
        """Fill the row, hand it on, and tell what has to be told."""
        row, reading, supervisor, deadlines = self.row, self._reading, self.supervisor, self.deadlines
        ledger, begun = supervisor.ledger, deadlines.begun
        worst, since = ledger.worst, now - begun if begun is not None else 0
        HEAD.pack_into(
            row.data, 0, since / SECOND, time_ns() / SECOND, deadlines.elapsed, deadlines.lateness, self._compute, link,
            reading.supply, supervisor.air, reading.stopped, reading.device, supervisor.state, worst, supervisor.lost,
            supervisor.outputs,
        )  # fmt: skip
        supervisor.core.record(self._joints)
        if worst:
            self._faults[:] = [ledger.worst_of(j) for j in range(len(self._faults))]
        self.recorder.push(row)
        self.host.publish(row)
        if ledger.events:
            for text in ledger.events:
                self.recorder.event(text)
            ledger.events.clear()
