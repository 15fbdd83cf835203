"""The real-time loop: read, judge, update, gate, write, record, publish; once a control cycle, at absolute deadlines.

deadline -> driver.read -> supervisor.judge, steer -> controllers -> supervisor.gate -> driver.write -> row -> snapshot
"""

from __future__ import annotations

from time import perf_counter_ns, time_ns
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.control.update import MEMORY, STATUS, flat, update, wake
from layflat.machine import Machine, parameters
from layflat.rig.clock import SECOND, Clock
from layflat.rig.deadlines import Deadlines
from layflat.rig.driver import Command, DeviceState, Driver, LinkError, Reading
from layflat.rig.record import BY_JOINT, SHARED, Layout
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.supervisor import HostRequest, Supervisor

Array = NDArray[np.float64]

ALIVE_EVERY = 20
"""Cycles between two looks whether the recorder is alive."""


class Host(Protocol):
    """Who wants something of the loop, and looks on."""

    def request(self, now: int) -> HostRequest:
        """What is wanted in the cycle that began at `now` (ns); edges are given once."""
        ...

    def publish(self, row: Array) -> None:
        """Show a row of `record.Layout`; it is used again in the next cycle."""
        ...

    @property
    def ended(self) -> bool:
        """Whether the loop is to end once it has let out the air."""
        ...


class Recorder(Protocol):
    """What keeps every cycle."""

    def push(self, row: Array) -> object:
        """Take a row of `record.Layout`; it is used again in the next cycle."""
        ...

    def event(self, text: str) -> object:
        """Take a line for people."""
        ...

    def alive(self) -> bool:
        """Whether rows reach the disk: false within a second of its death."""
        ...


class NoRecorder:
    """Keeps nothing."""

    def push(self, row: Array) -> None:
        """Forget a row."""

    def event(self, text: str) -> None:
        """Forget a line."""

    def alive(self) -> bool:
        """It can't die."""
        return True

    def end(self) -> None:
        """Nothing more will come."""


class Loop:
    """One rig in motion; `cycle` performs one control cycle, `run` all of them.

    Args:
        machine: with valve, sensors, controller and gains.
        driver: inactive or active.
        clock: what cycles are timed by.
        host: who wants something.
        recorder: what keeps the rows.

    Raises:
        MachineError: the machine has no controller.
    """

    def __init__(
        self, machine: Machine, driver: Driver, clock: Clock, host: Host, recorder: Recorder | None = None
    ) -> None:
        self.gains = np.array([flat(parameters.gains(machine, name)) for name in machine.joints])
        assert machine.controller is not None  # its gains were there
        cycle, n = machine.controller.cycle, len(machine.joints)
        self.driver, self.clock, self.host = driver, clock, host
        self.recorder: Recorder = recorder if recorder is not None else NoRecorder()
        self.supervisor = Supervisor(machine, cycle)
        self.deadlines = Deadlines(clock, cycle)
        self.layout = Layout.of(list(machine.joints))
        self.row = np.zeros(self.layout.width)
        self._joint_rows = self.row[len(SHARED) :].reshape(n, len(BY_JOINT))
        self._memory, self._status = np.zeros((1, n, MEMORY)), np.zeros((1, n, STATUS))
        self._voltages = np.full(n, machine.valve.centre_voltage if machine.valve is not None else 0.0)
        self._asked = self._voltages.copy()
        self._reading = Reading(np.zeros(n), np.zeros(n), 0.0, False, DeviceState.RUNNING)
        self._seen_at: int | None = None
        self._lost = self._cycles = 0
        self._compute = 0.0
        self._recording = True

    def begin(self, reading: Reading) -> None:
        """Start with air that is there already, as a simulated run does, with controllers woken by this reading."""
        self.supervisor.begin(reading, filled=True)
        wake(self._memory, reading.angles, reading.pressures)
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
            reading = self._reading = self.driver.read()
            lost = False
        except LinkError:
            reading, lost = self._reading, True
        answered, seen = perf_counter_ns(), self.clock.now()
        supervisor = self.supervisor
        elapsed = self.deadlines.cycle if self._seen_at is None else (seen - self._seen_at) / SECOND
        if lost:
            self._lost += 1
            supervisor.lost()
        else:
            self._lost, self._seen_at = 0, seen
            if self._cycles == 0:
                supervisor.begin(reading)
            supervisor.judge(reading, self._status, self._memory, self._voltages, elapsed)
            self._cycles += 1
        self._tell()
        supervisor.steer(self.host.request(now), self._status[0, :, 0].tolist(), self.deadlines.elapsed)
        if not lost:
            self._update(reading, elapsed)
        self._voltages = supervisor.gate(self._asked)
        self.driver.write(Command(self._voltages.copy(), supervisor.air, supervisor.resets))
        self._record(reading, now, self.deadlines.elapsed, (answered - begun) / SECOND)
        self._compute = (perf_counter_ns() - answered) / SECOND
        self.deadlines.took(self._compute)

    def _tell(self) -> None:
        """Let the supervisor know what is not the machine's fault."""
        supervisor = self.supervisor
        if self.deadlines.missed_now:
            supervisor.tell(Fault.CYCLE_MISSED, is_so=True)
        if self._cycles % ALIVE_EVERY == 0:
            self._recording = self.recorder.alive()
        supervisor.tell(Fault.RECORDER_DEAD, is_so=not self._recording)

    def _update(self, reading: Reading, elapsed: float) -> None:
        """Step the controllers."""
        supervisor = self.supervisor
        if supervisor.wake:
            wake(self._memory, reading.angles, reading.pressures)
            supervisor.wake = False
        update(
            self.gains,
            self._memory,
            reading.angles,
            reading.pressures,
            elapsed,
            supervisor.demands,
            self._asked,
            self._status,
        )

    def _record(self, reading: Reading, now: int, elapsed: float, link: float) -> None:
        """Fill the row, hand it on, and tell what has to be told."""
        row, joints, supervisor, deadlines = self.row, self._joint_rows, self.supervisor, self.deadlines
        ledger = supervisor.ledger
        begun = deadlines.begun
        since = now - begun if begun is not None else 0
        row[: len(SHARED)] = (
            since / SECOND, time_ns() / SECOND, elapsed, deadlines.lateness, self._compute, link, reading.supply,
            supervisor.air, reading.stopped, reading.device, supervisor.state, ledger.worst, self._lost,
        )  # fmt: skip
        status, memory = self._status[0], self._memory[0]
        joints[:, 0] = supervisor.demands
        joints[:, 1] = self._voltages
        joints[:, 2] = reading.angles
        joints[:, 3] = reading.pressures
        joints[:, 4:9] = status[:, :5]
        joints[:, 9:11] = memory[:, 7:9]
        joints[:, 11] = status[:, 5]
        joints[:, 12] = [ledger.worst_of(j) for j in range(len(joints))] if ledger.worst else 0.0
        self.recorder.push(row)
        self.host.publish(row)
        if ledger.events:
            for text in ledger.events:
                self.recorder.event(text)
            ledger.events.clear()
