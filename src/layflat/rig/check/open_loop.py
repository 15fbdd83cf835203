"""Control cycles without a controller: read, look whether it is safe to go on, write."""

from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.parameters import drive_parts
from layflat.rig.abilities import falls, sinks, vent_time
from layflat.rig.clock import SECOND, Clock, Deadlines
from layflat.rig.driver import Command, DeviceState, Driver, Lifecycle, LinkError, Reading
from layflat.rig.safety.core import Core
from layflat.rig.safety.cycle_numbers import JUDGE
from layflat.rig.safety.detectors.sample import MOTION
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import joint_limits


class CheckResult(NamedTuple):
    """One thing that was looked at."""

    what: str
    found: str
    action: str = ""  # what to do; empty where the check passed

    @property
    def passed(self) -> bool:
        """True if nothing has to be done."""
        return not self.action


class UnsafeError(LayflatError):
    """A fault that ends a check with air at once; the message names it."""


class OpenLoopRig:
    """A driver that is configured, the clock that its cycles are timed by, and what is noted of the link."""

    def __init__(self, machine: Machine, driver: Driver, clock: Clock) -> None:
        self.machine, self.driver, self.clock = machine, driver, clock
        self.names = list(machine.joints)
        self.cycle = machine.cycle
        self.limits = [joint_limits(machine, name) for name in self.names]
        valve, self.angle_part, self.pressure_part = drive_parts(machine)
        self.span = valve.volts_to_full
        self.centred = np.full(len(self.names), valve.centre_voltage)
        self.sinking = sinks(machine)  # joints that gravity moves, (joints,)
        self.deadlines = Deadlines(clock, self.cycle)
        self.transactions: list[float] = []  # time that each took, s
        self.failures: list[LinkError] = []  # transactions without a good reply
        self._core = Core(machine)
        self._obeyed = False

    def cycles(self, seconds: float) -> int:
        """Control cycles in a time, s."""
        return round(seconds / self.cycle)

    def look(self) -> Reading | None:
        """Read in the next cycle; None where the reply was lost."""
        self.deadlines.wait()
        begun = self.clock.now()
        try:
            reading = self.driver.read()
        except LinkError as error:
            self.failures.append(error)
            reading = None
        self.transactions.append((self.clock.now() - begun) / SECOND)
        return reading

    def act(self, voltages: Array, *, reset: bool = False) -> Reading:
        """With air on: look, and ask for voltages; where a reply is lost, look again in the next cycle.

        Raise UnsafeError if it is not safe to go on.
        """
        lost = 0
        while True:
            if (reading := self.look()) is not None:
                self._judge(reading)
            elif (lost := lost + 1) >= Fault.LINK_LOST.cycles:
                raise UnsafeError(Fault.LINK_LOST.title)
            self.driver.write(Command(voltages.copy(), air=True, reset=reset))
            if reading is not None:
                return reading

    def rest(self, seconds: float) -> None:
        """Keep valves centred with air on; as `act`."""
        for _ in range(self.cycles(seconds)):
            self.act(self.centred)

    def vent(self) -> None:
        """Air off until the hoses are empty; the driver is left inactive.

        Valves are centred at first, then open to one end, but for those of an arm that would fall.
        """
        if self.driver.state is not Lifecycle.ACTIVE:
            return
        opened = self.centred if falls(self.machine) else self.centred + self.span
        for voltages, seconds in ((self.centred, 0.1), (opened, vent_time(self.machine))):
            for _ in range(self.cycles(seconds)):
                self.look()
                self.driver.write(Command(voltages.copy(), air=False))
        self.driver.deactivate()

    def _judge(self, reading: Reading) -> None:
        self._core.take(reading)
        self._core.perform(JUDGE, reading.supply, self.cycle, self.cycle, MOTION)
        fault, faults = self._core.found
        self._obeyed = self._obeyed or reading.device is DeviceState.RUNNING
        if self._obeyed and reading.device is not DeviceState.RUNNING:
            fault = Fault.DEVICE_DUMPED if reading.device is DeviceState.DUMPED else Fault.DEVICE_CENTRED
        if reading.stopped:
            fault = Fault.E_STOP
        if fault:
            raise UnsafeError(fault.title)
        for name, found in zip(self.names, faults, strict=True):
            if found:
                raise UnsafeError(f"joint {name!r}: {found.title}")
